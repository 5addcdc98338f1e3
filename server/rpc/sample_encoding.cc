#include "server/rpc/sample_encoding.h"

#include <stdexcept>

#include <grpcpp/impl/codegen/proto_utils.h>

#include "mwidth/v1/telemetry.pb.h"
#include "server/rpc/convert.h"

namespace mwidth::rpc {
namespace {

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

}  // namespace

grpc::ByteBuffer Encode(const std::string& axis, const record::Batch& batch) {
  v1::StreamSamplesResponse response;
  v1::SampleBatch& columns = *response.mutable_batch();
  columns.set_axis(axis);
  columns.set_first_tick(batch.first_tick);
  columns.set_decimation(batch.decimation);
  columns.set_missed_ticks_before(batch.missed_ticks_before);
  columns.set_dropped_ticks_before(batch.dropped_ticks_before);
  Reserve(static_cast<int>(batch.samples.size()), columns);
  for (const exchange::Sample& sample : batch.samples) {
    Append(sample, columns);
  }

  grpc::ByteBuffer bytes;
  bool own_buffer = false;
  const grpc::Status status =
      grpc::SerializationTraits<v1::StreamSamplesResponse>::Serialize(response, &bytes, &own_buffer);
  if (!status.ok()) {
    throw std::runtime_error("cannot serialize a batch of samples: " + status.error_message());
  }
  return bytes;
}

}  // namespace mwidth::rpc
