// Long computations, which must not be felt by the loops and may not pile up.
#pragma once

#include <future>
#include <semaphore>

namespace mwidth::rpc {

/// Lets every other thread of the host go before the calling one, for good: SCHED_IDLE. A loop without
/// real-time scheduling, which is an ordinary thread, would otherwise wait for the end of a worker's time
/// slice now and then; a thread of SCHED_IDLE is preempted the moment an ordinary one wakes up, which
/// SCHED_BATCH and nice values do not promise. Where the host refuses, the thread stays as it was.
void LowerPriority() noexcept;

/// What `work` returns, or throws, on a thread of its own at low priority. Waits for it.
template <typename Work>
auto AtLowPriority(const Work& work) {
  return std::async(std::launch::async,
                    [&work] {
                      LowerPriority();
                      return work();
                    })
      .get();
}

/// How many of them may run at once.
class ComputationLimit {
 public:
  explicit ComputationLimit(int most) : free_(most) {}

  /// One place, given back on destruction.
  class Place {
   public:
    /// Takes one if there is one. `limit` outlives it.
    explicit Place(ComputationLimit& limit) : limit_(limit), taken_(limit.free_.try_acquire()) {}
    ~Place() {
      if (taken_) {
        limit_.free_.release();
      }
    }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    bool taken() const { return taken_; }

   private:
    ComputationLimit& limit_;
    const bool taken_;
  };

 private:
  std::counting_semaphore<> free_;
};

}  // namespace mwidth::rpc
