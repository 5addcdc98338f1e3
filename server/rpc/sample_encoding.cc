#include "server/rpc/sample_encoding.h"

#include <memory>
#include <stdexcept>
#include <vector>

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/wire_format_lite.h>
#include <grpcpp/support/slice.h>

#include "server/rpc/convert.h"

namespace mwidth::rpc {
namespace {

using google::protobuf::internal::WireFormatLite;

v1::Reduction MessageOf(record::Reduction reduction) {
  switch (reduction) {
    case record::Reduction::kPick:
      return v1::REDUCTION_PICK;
    case record::Reduction::kLowPass:
      return v1::REDUCTION_LOW_PASS;
    case record::Reduction::kMinMax:
      return v1::REDUCTION_MIN_MAX;
  }
  return v1::REDUCTION_UNSPECIFIED;
}

void Reserve(int samples, v1::SampleBatch& columns) {
  columns.mutable_monotonic_ns()->Reserve(samples);
  columns.mutable_position()->Reserve(samples);
  columns.mutable_velocity()->Reserve(samples);
  columns.mutable_acceleration()->Reserve(samples);
  columns.mutable_force()->Reserve(samples);
  columns.mutable_mass()->Reserve(samples);
  columns.mutable_state()->Reserve(samples);
  columns.mutable_saturated()->Reserve(samples);
  columns.mutable_position_counts()->Reserve(samples);
  columns.mutable_force_counts()->Reserve(samples);
  columns.mutable_position_stale()->Reserve(samples);
  columns.mutable_acceleration_counts()->Reserve(samples);
  columns.mutable_force_taken()->Reserve(samples);
}

void Append(const exchange::Sample& sample, v1::SampleBatch& columns) {
  columns.add_monotonic_ns(sample.monotonic_ns);
  columns.add_position(sample.position);
  columns.add_velocity(sample.velocity);
  columns.add_acceleration(sample.acceleration);
  columns.add_force(sample.force);
  columns.add_mass(sample.mass);
  columns.add_state(Convert(sample.state));
  columns.add_saturated(sample.saturated || sample.slew_limited);
  columns.add_position_counts(sample.position_counts);
  columns.add_force_counts(sample.force_counts);
  columns.add_position_stale(sample.position_stale);
  columns.add_acceleration_counts(sample.acceleration_counts);
  columns.add_force_taken(sample.force_taken);
}

void Append(const record::Extremes& extremes, v1::SampleBatch& columns) {
  columns.add_position_min(extremes.position_min);
  columns.add_position_max(extremes.position_max);
  columns.add_velocity_min(extremes.velocity_min);
  columns.add_velocity_max(extremes.velocity_max);
  columns.add_acceleration_min(extremes.acceleration_min);
  columns.add_acceleration_max(extremes.acceleration_max);
  columns.add_force_min(extremes.force_min);
  columns.add_force_max(extremes.force_max);
}

// A StreamSamplesResponse with nothing but what stands in place of the last batch's own fields. Written field
// by field, because a message would leave out those that are 0.
std::string Overrides(const record::Delivery& delivery) {
  using Batch = v1::SampleBatch;
  const auto encode = [](const auto& write) {
    std::string bytes;
    {
      google::protobuf::io::StringOutputStream stream(&bytes);
      google::protobuf::io::CodedOutputStream out(&stream);
      write(out);
    }
    return bytes;
  };
  const std::string batch = encode([&](auto& out) {
    WireFormatLite::WriteUInt64(Batch::kFirstTickFieldNumber, delivery.first_tick(), &out);
    WireFormatLite::WriteUInt64(Batch::kMissedTicksBeforeFieldNumber, delivery.missed_ticks_before, &out);
    WireFormatLite::WriteUInt64(Batch::kDroppedTicksBeforeFieldNumber, delivery.dropped_ticks_before, &out);
  });
  return encode([&](auto& out) {
    WireFormatLite::WriteBytes(v1::StreamSamplesResponse::kBatchFieldNumber, batch, &out);
  });
}

// Its memory is the batch's, which lives as long as the slice.
grpc::Slice SliceOf(std::shared_ptr<const record::EncodedBatch> batch) {
  using Owner = std::shared_ptr<const record::EncodedBatch>;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): gRPC does not write to it
  auto* bytes = const_cast<char*>(batch->bytes.data());
  const std::size_t size = batch->bytes.size();
  auto owner = std::make_unique<Owner>(std::move(batch));
  return {bytes, size, [](void* kept) { const std::unique_ptr<Owner> freed(static_cast<Owner*>(kept)); },
          owner.release()};
}

}  // namespace

void Convert(const std::string& axis, const record::Batch& batch, v1::SampleBatch& message) {
  message.set_axis(axis);
  message.set_first_tick(batch.first_tick);
  message.set_decimation(batch.decimation);
  message.set_reduction(MessageOf(batch.reduction));
  message.set_missed_ticks_before(batch.missed_ticks_before);
  message.set_dropped_ticks_before(batch.dropped_ticks_before);
  Reserve(static_cast<int>(batch.samples.size()), message);
  for (const exchange::Sample& sample : batch.samples) {
    Append(sample, message);
  }
  for (const record::Extremes& extremes : batch.extremes) {
    Append(extremes, message);
  }
}

record::Encode SampleEncoding(const std::string& axis) {
  return [axis](const record::Batch& batch) {
    v1::StreamSamplesResponse response;
    Convert(axis, batch, *response.mutable_batch());
    return response.SerializeAsString();
  };
}

grpc::ByteBuffer Assemble(const record::Delivery& delivery) {
  std::vector<grpc::Slice> slices;
  for (const auto& batch : delivery.batches) {
    slices.push_back(SliceOf(batch));
  }
  if (!delivery.as_encoded()) {
    slices.emplace_back(Overrides(delivery));
  }
  return {slices.data(), slices.size()};
}

}  // namespace mwidth::rpc
