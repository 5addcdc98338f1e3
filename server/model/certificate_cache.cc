#include "server/model/certificate_cache.h"

#include <algorithm>

namespace mwidth::model {

std::shared_ptr<const RobustCertificate> CertificateCache::Get(const LoopEnvelope& envelope) {
  {
    const std::lock_guard lock(mutex_);
    if (auto kept = Find(envelope)) {
      return kept;
    }
  }
  auto proved = std::make_shared<const RobustCertificate>(CertifyRobustInterval(envelope));
  const std::lock_guard lock(mutex_);
  if (auto kept = Find(envelope)) {  // another thread proved the same meanwhile
    return kept;
  }
  certificates_.push_front(proved);
  if (certificates_.size() > capacity_) {
    certificates_.pop_back();
  }
  return proved;
}

std::shared_ptr<const RobustCertificate> CertificateCache::Find(const LoopEnvelope& envelope) {
  const auto found = std::find_if(certificates_.begin(), certificates_.end(),
                                  [&](const auto& kept) { return kept->assumed == envelope; });
  if (found == certificates_.end()) {
    return nullptr;
  }
  certificates_.splice(certificates_.begin(), certificates_, found);
  return *found;
}

}  // namespace mwidth::model
