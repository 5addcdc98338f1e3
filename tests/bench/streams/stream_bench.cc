// One end of the comparison, as a process of its own: compare_delivery runs them.
//
//   mwidth_stream_bench serve shared|naive|grpc|tcp BATCH
//   mwidth_stream_bench read grpc|tcp BATCH ADDRESS SUBSCRIBERS
//
// A server prints "listening on HOST:PORT". Each answers every line of standard input with its figures so
// far, as JSON, and ends with it.
#include <sys/resource.h>

#include <atomic>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/streams/readers.h"
#include "tests/bench/streams/servers.h"

namespace mwidth::bench {
namespace {

double CpuS() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

int Serve(const std::string& kind, std::size_t batch) {
  const auto server = kind == "shared"  ? MakeSharedServer()
                      : kind == "naive" ? MakeNaiveServer()
                      : kind == "grpc"  ? MakeBareGrpcServer(batch)
                                        : MakeTcpServer(batch);
  std::cout << "listening on " << server->address() << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::cout << "{\"cpu_s\": " << CpuS() - server->FeederCpuS() << "}" << std::endl;
  }
  // Nobody waits for the end of a server that is done.
  std::_Exit(0);
}

int Read(const std::string& kind, std::size_t batch, const std::string& address, std::size_t subscribers) {
  Received received;
  std::atomic<bool> over = false;
  std::thread reader([&] {
    if (kind == "grpc") {
      ReadGrpc(address, subscribers, batch, received, over);
    } else {
      ReadTcp(address, subscribers, received, over);
    }
  });
  for (std::string line; std::getline(std::cin, line);) {
    std::cout << "{\"subscribers\": " << received.subscribers << ", \"samples\": " << received.samples
              << ", \"messages\": " << received.messages << ", \"absent_ticks\": " << received.absent_ticks
              << ", \"cpu_s\": " << CpuS() << "}" << std::endl;
  }
  std::_Exit(0);
}

}  // namespace
}  // namespace mwidth::bench

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv, argv + argc);
  try {
    if (words.size() == 4 && words[1] == "serve") {
      return mwidth::bench::Serve(words[2], std::stoul(words[3]));
    }
    if (words.size() == 6 && words[1] == "read") {
      return mwidth::bench::Read(words[2], std::stoul(words[3]), words[4], std::stoul(words[5]));
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  std::fprintf(stderr, "usage: see the top of stream_bench.cc\n");
  return 2;
}
