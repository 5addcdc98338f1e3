// A disk that takes nothing.
#pragma once

#include <csignal>

#include <sys/resource.h>

namespace mwidth::record {

/// Nothing can be written to any file of this process while it lives, as on a disk that fails.
class NoFileGrows {
 public:
  NoFileGrows() {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit none{.rlim_cur = 0, .rlim_max = old_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &none);
  }
  NoFileGrows(const NoFileGrows&) = delete;
  NoFileGrows& operator=(const NoFileGrows&) = delete;
  ~NoFileGrows() { setrlimit(RLIMIT_FSIZE, &old_); }

 private:
  rlimit old_{};
};

}  // namespace mwidth::record
