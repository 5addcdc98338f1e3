// Settings of ThreadSanitizer for tests that go through gRPC; without effect in other builds.
//
// Debian's libgrpc is not built with ThreadSanitizer, which therefore does not see how gRPC hands memory from
// one of its threads to the next, and reports every such handover as a race. A report with a frame of gRPC in
// it is dropped here. What is left to judge in such a test is what our own threads do among themselves.

extern "C" {

// Names that ThreadSanitizer looks for.
const char* __tsan_default_options();  // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
const char*
__tsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

const char* __tsan_default_options() {  // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
  return "ignore_noninstrumented_modules=1";
}

const char*
__tsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
  return "race:grpc\n";
}

}  // extern "C"
