#include "tests/bench/loop/overload.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <future>
#include <iostream>
#include <limits>
#include <memory>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/client_callback.h>

#include "client/cpp/client.h"

namespace mwidth::bench {
namespace {

constexpr int kStreams = 256;
constexpr uint32_t kMaxBatch = 10;
constexpr int kMassThreads = 8;
constexpr std::size_t kBlockBytes = 1 << 20;
constexpr uint64_t kFileBlocks = 128;

/// One subscriber.
class Stream final : public grpc::ClientReadReactor<v1::StreamSamplesResponse> {
 public:
  explicit Stream(const std::string& address)
      : stub_(
            v1::TelemetryService::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()))) {
    request_.set_max_batch(kMaxBatch);
    stub_->async()->StreamSamples(&context_, &request_, this);
    StartRead(&response_);
    StartCall();
  }
  void OnReadDone(bool ok) override {
    if (!ok) {
      return;
    }
    const v1::SampleBatch& batch = response_.batch();
    samples_ += static_cast<uint64_t>(batch.position_size());
    lost_ += batch.dropped_ticks_before();
    ++batches_;
    StartRead(&response_);
  }
  void OnDone(const grpc::Status& /*status*/) override {
    // Told while the lock is held: once it is released, End may destroy this.
    const std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_one();
  }

  /// Ends the stream and adds what it saw.
  void End(OverloadReport& report) {
    context_.TryCancel();
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return done_; });
    ++report.streams;
    report.samples += samples_;
    report.batches += batches_;
    report.lost += lost_;
  }

 private:
  std::unique_ptr<v1::TelemetryService::Stub> stub_;
  grpc::ClientContext context_;
  v1::StreamSamplesRequest request_;
  v1::StreamSamplesResponse response_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  uint64_t samples_ = 0;
  uint64_t batches_ = 0;
  uint64_t lost_ = 0;
};

uint64_t SetMasses(client::Control& control, const std::atomic<bool>& ending) {
  uint64_t answers = 0;
  for (; !ending; ++answers) {
    control.SetMass(answers % 2 == 0 ? 0.05 : 0.1);
  }
  return answers;
}

uint64_t KeepDiskBusy(const std::atomic<bool>& ending) {
  std::string name = (std::filesystem::temp_directory_path() / "mwidth-bench-XXXXXX").string();
  const int file = mkstemp(name.data());
  if (file < 0) {
    throw std::system_error(errno, std::generic_category(), name);
  }
  unlink(name.c_str());
  const std::vector<char> block(kBlockBytes, 'x');
  uint64_t blocks = 0;
  for (; !ending; ++blocks) {
    const auto at = static_cast<off_t>(blocks % kFileBlocks * kBlockBytes);
    if (pwrite(file, block.data(), block.size(), at) < 0 || fdatasync(file) < 0) {
      throw std::system_error(errno, std::generic_category(), name);
    }
  }
  close(file);
  return blocks;
}

}  // namespace

int RunOverload(const std::string& address) try {
  const auto client = client::Client::Connect(address);
  auto control = client.AcquireControl("overload");
  control.StartRendering();
  std::vector<std::unique_ptr<Stream>> streams;
  for (int i = 0; i < kStreams; ++i) {
    streams.push_back(std::make_unique<Stream>(address));
  }
  std::atomic<bool> ending{false};
  std::vector<std::future<uint64_t>> masses;
  for (int i = 0; i < kMassThreads; ++i) {
    masses.push_back(std::async(std::launch::async, [&] { return SetMasses(control, ending); }));
  }
  auto disk = std::async(std::launch::async, [&ending] { return KeepDiskBusy(ending); });
  std::cout << "ready" << std::endl;
  std::cin.ignore(std::numeric_limits<std::streamsize>::max());
  ending = true;
  OverloadReport report;
  for (auto& set : masses) {
    report.masses_set += set.get();
  }
  report.megabytes_written = disk.get();
  for (auto& stream : streams) {
    stream->End(report);
  }
  std::cout << report.streams << ' ' << report.samples << ' ' << report.batches << ' ' << report.lost << ' '
            << report.masses_set << ' ' << report.megabytes_written << std::endl;
  return 0;
} catch (const std::exception& error) {
  std::cout << "error " << error.what() << std::endl;
  return 1;
}

Overload::Overload(const std::string& address) {
  std::array<int, 2> input{};
  std::array<int, 2> output{};
  if (pipe2(input.data(), O_CLOEXEC) < 0 || pipe2(output.data(), O_CLOEXEC) < 0) {
    throw std::system_error(errno, std::generic_category(), "pipe2");
  }
  input_ = input[1];
  output_ = output[0];
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, output[1], STDOUT_FILENO);
  const std::string program = std::filesystem::read_symlink("/proc/self/exe");
  std::array<std::string, 3> words{program, "--overload", address};
  std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(), nullptr};
  const int error = posix_spawn(&process_, program.c_str(), &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  close(input[0]);
  close(output[1]);
  if (error != 0) {
    throw std::system_error(error, std::generic_category(), program);
  }
  if (const std::string line = ReadLine(); line != "ready") {
    throw std::runtime_error("the overload does not begin: " + line);
  }
}

Overload::~Overload() {
  CloseInput();
  close(output_);
  waitpid(process_, nullptr, 0);
}

void Overload::CloseInput() {
  if (input_ >= 0) {
    close(input_);
    input_ = -1;
  }
}

std::string Overload::ReadLine() const {
  std::string line;
  char c = 0;
  while (read(output_, &c, 1) == 1 && c != '\n') {
    line += c;
  }
  return line;
}

OverloadReport Overload::End() {
  CloseInput();
  const std::string line = ReadLine();
  std::istringstream words(line);
  OverloadReport report;
  words >> report.streams >> report.samples >> report.batches >> report.lost >> report.masses_set >>
      report.megabytes_written;
  if (!words) {
    report.error = line.empty() ? "it ended early" : line;
  }
  return report;
}

}  // namespace mwidth::bench
