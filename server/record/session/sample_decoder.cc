#include <string>

#include <zstd.h>

#include "server/record/session/block_layout.h"
#include "server/record/session/sample_codec.h"

namespace mwidth::record {

class SampleDecoder::Planes {
 public:
  explicit Planes(const SessionAxis& axis)
      : period_ns_(PeriodNs(axis)), rebuilder_(axis), context_(ZSTD_createDCtx()) {
    if (!context_) {
      throw std::bad_alloc();
    }
  }

  void Decode(std::span<const std::byte> block, std::vector<exchange::Sample>& samples) {
    block_ = block;
    const BlockHead head = TakeHead();
    samples.assign(head.samples, {});
    values_.resize(head.samples);
    plane_.resize(head.samples);
    at_ = kHeadBytes;
    column_ = 0;
    ForEachStoredColumn(period_ns_,
                        [this, &samples](int, const auto&, const auto& set) { Load(samples, set); });
    ForEachDerivedColumn([this, &samples, &head](int, const auto&, const auto& set) {
      head.derived_stored != 0 ? Load(samples, set) : LoadFirst(samples[0], set);
    });
    if (at_ != block_.size()) {
      throw BlockError("there are bytes behind the last column");
    }
    CheckTicks(samples);
    Derive(head, samples);
  }

 private:
  struct FreeContext {
    void operator()(ZSTD_DCtx* context) const noexcept { ZSTD_freeDCtx(context); }
  };

  BlockHead TakeHead() const {
    BlockHead head;
    if (block_.size() < kHeadBytes) {
      throw BlockError("it ends within its head");
    }
    std::memcpy(&head, block_.data(), sizeof head);
    if (head.version != kBlockVersion || head.derived_stored > 1 || head.stored_columns != kStoredColumns ||
        head.derived_columns != kDerivedColumns) {
      throw BlockError("it is of another format");
    }
    if (head.samples == 0 || head.samples > kMaxBlockSamples) {
      throw BlockError("it says to have " + std::to_string(head.samples) + " samples");
    }
    return head;
  }

  ColumnHead TakeColumnHead() {
    const ColumnHead head = GetColumnHead(block_.data() + sizeof(BlockHead) + column_ * kColumnHeadBytes);
    ++column_;
    if (head.order > 2 || head.width > 8) {
      Throw("cannot be told how it is stored");
    }
    return head;
  }

  [[noreturn]] void Throw(const std::string& what) const {
    throw BlockError("column " + std::to_string(column_) + " " + what);
  }

  // The next plane of the column, whole.
  const std::byte* TakePlane() {
    uint32_t stored = 0;
    if (block_.size() - at_ < sizeof stored) {
      Throw("is missing");
    }
    std::memcpy(&stored, block_.data() + at_, sizeof stored);
    at_ += sizeof stored;
    if (stored > plane_.size() || stored > block_.size() - at_) {
      Throw("is longer than the block");
    }
    const std::byte* bytes = block_.data() + at_;
    at_ += stored;
    if (stored == plane_.size()) {
      return bytes;
    }
    if (ZSTD_decompressDCtx(context_.get(), plane_.data(), plane_.size(), bytes, stored) != plane_.size()) {
      Throw("does not decompress");
    }
    return plane_.data();
  }

  template <typename Set>
  void LoadFirst(exchange::Sample& sample, const Set& set) {
    if (!set(TakeColumnHead().first, 0, sample)) {
      Throw("has a value that it cannot have");
    }
  }

  template <typename Set>
  void Load(std::vector<exchange::Sample>& samples, const Set& set) {
    const ColumnHead head = TakeColumnHead();
    values_.assign(values_.size(), 0);
    for (unsigned byte = 0; byte < head.width; ++byte) {
      const std::byte* plane = TakePlane();
      for (std::size_t i = 0; i < values_.size(); ++i) {
        values_[i] |= std::to_integer<uint64_t>(plane[i]) << (8 * byte);
      }
    }
    uint64_t value = 0;
    uint64_t step = 0;
    bool possible = true;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const uint64_t difference = UnZigZag(values_[i]);
      step = head.order == 2 ? step + difference : difference;
      value = head.order == 0 ? difference : value + step;
      possible = set(value + head.first, i, samples[i]) && possible;
    }
    if (!possible) {
      Throw("has a value that it cannot have");
    }
  }

  static void CheckTicks(const std::vector<exchange::Sample>& samples) {
    for (std::size_t i = 1; i < samples.size(); ++i) {
      if (samples[i].tick <= samples[i - 1].tick) {
        throw BlockError("its ticks do not rise");
      }
    }
  }

  void Derive(const BlockHead& head, std::vector<exchange::Sample>& samples) {
    derived_.resize(samples.size());
    derived_[0] = DerivedOf(samples[0]);
    const bool stored = head.derived_stored != 0;
    if (!stored && !rebuilder_.Begin(samples[0])) {
      throw BlockError("no estimator runs with its filter");
    }
    for (std::size_t i = 1; i < samples.size(); ++i) {
      if (stored) {
        derived_[i] = DerivedOf(samples[i]);
        continue;
      }
      const auto rebuilt = rebuilder_.Follow(samples[i]);
      if (!rebuilt) {
        throw BlockError("no estimator runs with its filter");
      }
      derived_[i] = *rebuilt;
      SetDerived(*rebuilt, samples[i]);
    }
    if (Checksum(std::as_bytes(std::span(derived_))) != head.derived_checksum) {
      throw BlockError(stored ? "its derived columns are not what was written"
                              : "its derived columns, computed again, are not what was recorded: damage, or "
                                "arithmetic other than that of the build that wrote it");
    }
  }

  uint64_t period_ns_;
  ColumnRebuilder rebuilder_;
  std::unique_ptr<ZSTD_DCtx, FreeContext> context_;
  std::span<const std::byte> block_;
  std::size_t at_ = 0;
  std::size_t column_ = 0;
  std::vector<DerivedColumns> derived_;
  std::vector<uint64_t> values_;
  std::vector<std::byte> plane_;
};

SampleDecoder::SampleDecoder(const SessionAxis& axis) : planes_(std::make_unique<Planes>(axis)) {}
SampleDecoder::SampleDecoder(SampleDecoder&&) noexcept = default;
SampleDecoder& SampleDecoder::operator=(SampleDecoder&&) noexcept = default;
SampleDecoder::~SampleDecoder() = default;

void SampleDecoder::Decode(std::span<const std::byte> block, std::vector<exchange::Sample>& samples) {
  try {
    planes_->Decode(block, samples);
  } catch (...) {
    samples.clear();
    throw;
  }
}

}  // namespace mwidth::record
