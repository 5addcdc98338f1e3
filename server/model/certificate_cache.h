// Robust intervals that were proved before.
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>

#include "server/model/envelope.h"
#include "server/model/robust_interval.h"

namespace mwidth::model {

/// Keeps the certificates of the envelopes asked for last. Equal envelopes, to the last bit, have equal
/// certificates, so a certificate never goes stale. Any thread, several at once; not for the loop's thread.
class CertificateCache {
 public:
  /// `capacity` at least 1.
  explicit CertificateCache(std::size_t capacity = 64) : capacity_(capacity) {}

  /// The certificate of `envelope`: a look-up if it is kept, otherwise proved here, while others may look up.
  /// Precondition: Validate(envelope) is empty.
  std::shared_ptr<const RobustCertificate> Get(const LoopEnvelope& envelope);

 private:
  /// Moves the certificate to the front; null where there is none. Holds mutex_.
  std::shared_ptr<const RobustCertificate> Find(const LoopEnvelope& envelope);

  std::size_t capacity_;
  std::mutex mutex_;
  /// Most recently used first.
  std::list<std::shared_ptr<const RobustCertificate>> certificates_;
};

}  // namespace mwidth::model
