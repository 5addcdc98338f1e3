#include <bit>
#include <cmath>
#include <stdexcept>

#include <xxhash.h>
#include <zstd.h>

#include "server/record/session/block_layout.h"
#include "server/record/session/sample_codec.h"

namespace mwidth::record {
namespace {

// Higher levels search longer for repetitions, of which noise has none.
constexpr int kZstdLevel = 1;

}  // namespace

uint64_t Checksum(std::span<const std::byte> bytes) noexcept {
  return XXH3_64bits(bytes.data(), bytes.size());
}

uint64_t PeriodNs(const SessionAxis& axis) noexcept {
  return axis.period_s > 0 && axis.period_s < 1e3 ? static_cast<uint64_t>(std::llround(axis.period_s * 1e9))
                                                  : 0;
}

class SampleEncoder::Planes {
 public:
  explicit Planes(const SessionAxis& axis)
      : period_ns_(PeriodNs(axis)), rebuilder_(axis), context_(ZSTD_createCCtx()) {
    if (!context_) {
      throw std::bad_alloc();
    }
  }

  // Looks at the derived columns of samples that nobody has looked at.
  CheckedSamples Check(std::span<const exchange::Sample> samples) {
    derived_.resize(samples.size());
    derived_[0] = DerivedOf(samples[0]);
    bool follow = rebuilder_.Begin(samples[0]);
    for (std::size_t i = 1; i < samples.size(); ++i) {
      derived_[i] = DerivedOf(samples[i]);
      if (follow) {
        const auto rebuilt = rebuilder_.Follow(samples[i]);
        follow = rebuilt && SameBits(*rebuilt, derived_[i]);
      }
    }
    return {.samples = samples, .derived = derived_, .follow = follow};
  }

  std::span<const std::byte> Encode(const CheckedSamples& checked, Packing packing) {
    const std::span<const exchange::Sample> samples = checked.samples;
    samples_ = samples;
    packing_ = packing;
    values_.resize(samples.size());
    plane_.resize(samples.size());
    block_.resize(kHeadBytes);
    BlockHead head{.samples = static_cast<uint32_t>(samples.size())};
    // Nothing follows from a sample with whose filter no estimator runs.
    head.derived_stored = checked.follow && rebuilder_.Begin(samples[0]) ? 0 : 1;
    head.derived_checksum = Checksum(std::as_bytes(checked.derived));
    std::memcpy(block_.data(), &head, sizeof head);
    column_ = 0;
    ForEachStoredColumn(period_ns_, [this](int order, const auto& get, const auto&) { Store(order, get); });
    ForEachDerivedColumn([this, &head](int order, const auto& get, const auto&) {
      head.derived_stored != 0 ? Store(order, get) : StoreFirst(get);
    });
    return block_;
  }

 private:
  struct FreeContext {
    void operator()(ZSTD_CCtx* context) const noexcept { ZSTD_freeCCtx(context); }
  };

  void PutHead(const ColumnHead& head) {
    Put(head, block_.data() + sizeof(BlockHead) + column_ * kColumnHeadBytes);
    ++column_;
  }

  template <typename Get>
  void StoreFirst(const Get& get) {
    PutHead({.first = get(samples_[0], 0)});
  }

  template <typename Get>
  void Store(int order, const Get& get) {
    const std::size_t count = samples_.size();
    const uint64_t first = get(samples_[0], 0);
    uint64_t previous = 0;
    uint64_t previous_step = 0;
    uint64_t all = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const uint64_t value = get(samples_[i], i) - first;
      const uint64_t step = value - previous;
      const uint64_t difference = order == 0 ? value : order == 1 ? step : step - previous_step;
      values_[i] = ZigZag(difference);
      all |= values_[i];
      previous = value;
      previous_step = step;
    }
    const auto width = static_cast<uint8_t>((static_cast<unsigned>(std::bit_width(all)) + 7U) / 8U);
    PutHead({.first = first, .order = static_cast<uint8_t>(order), .width = width});
    for (unsigned byte = 0; byte < width; ++byte) {
      for (std::size_t i = 0; i < count; ++i) {
        plane_[i] = static_cast<std::byte>(values_[i] >> (8 * byte));
      }
      AppendPlane();
    }
  }

  void AppendPlane() {
    const std::size_t at = block_.size();
    std::size_t size = plane_.size();
    if (packing_ == Packing::kCompressed) {
      block_.resize(at + sizeof(uint32_t) + ZSTD_compressBound(plane_.size()));
      const std::size_t compressed =
          ZSTD_compressCCtx(context_.get(), block_.data() + at + sizeof(uint32_t),
                            block_.size() - at - sizeof(uint32_t), plane_.data(), plane_.size(), kZstdLevel);
      if (ZSTD_isError(compressed) == 0 && compressed < size) {
        size = compressed;
      }
    }
    block_.resize(at + sizeof(uint32_t) + size);
    if (size == plane_.size()) {
      std::memcpy(block_.data() + at + sizeof(uint32_t), plane_.data(), size);
    }
    const auto stored = static_cast<uint32_t>(size);
    std::memcpy(block_.data() + at, &stored, sizeof stored);
  }

  uint64_t period_ns_;
  ColumnRebuilder rebuilder_;
  std::unique_ptr<ZSTD_CCtx, FreeContext> context_;
  std::span<const exchange::Sample> samples_;
  Packing packing_ = Packing::kPlain;
  std::size_t column_ = 0;
  std::vector<DerivedColumns> derived_;
  std::vector<uint64_t> values_;
  std::vector<std::byte> plane_;
  std::vector<std::byte> block_;
};

SampleEncoder::SampleEncoder(const SessionAxis& axis) : planes_(std::make_unique<Planes>(axis)) {}
SampleEncoder::SampleEncoder(SampleEncoder&&) noexcept = default;
SampleEncoder& SampleEncoder::operator=(SampleEncoder&&) noexcept = default;
SampleEncoder::~SampleEncoder() = default;

std::span<const std::byte> SampleEncoder::Encode(std::span<const exchange::Sample> samples, Packing packing) {
  return planes_->Encode(planes_->Check(samples), packing);
}
std::span<const std::byte> SampleEncoder::Encode(const CheckedSamples& samples, Packing packing) {
  return planes_->Encode(samples, packing);
}

}  // namespace mwidth::record
