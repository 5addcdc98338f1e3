// A C++ client of mwidthd. example.cc shows it at work.
#pragma once

#include <grpcpp/channel.h>
#include <mwidth/v1/rendering.grpc.pb.h>
#include <mwidth/v1/session.grpc.pb.h>
#include <mwidth/v1/stability.grpc.pb.h>
#include <mwidth/v1/telemetry.grpc.pb.h>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cpp/clock_offset.h"
#include "client/cpp/control.h"
#include "client/cpp/failure.h"
#include "client/cpp/sample_stream.h"

namespace mwidth::client {

/// Default bound on every call and on the connection attempt.
inline constexpr Seconds kCallTimeout{5};
/// Bound on what the server computes for longer: sweeps, simulations, and proofs over an envelope.
inline constexpr Seconds kAnalysisTimeout{300};

/// Everything that a client may ask of one server. An empty `axis` means the only one, as in the API.
///
/// All functions are safe from any thread, block for one round trip, and throw Error. The objects that it
/// returns keep the connection for themselves and may outlive it.
class Client {
 public:
  /// Connects to "HOST:PORT". Throws Error (UNAVAILABLE) at once where nobody listens, after `timeout` where
  /// nobody answers. `timeout` then also bounds every call. Plain text: for the laboratory's own network.
  static Client Connect(const std::string& address, Seconds timeout = kCallTimeout);
  /// Uses a channel of the caller's making, connected or not.
  explicit Client(const std::shared_ptr<grpc::ChannelInterface>& channel,
                  Seconds call_timeout = kCallTimeout);

  /// What the axes are and what they are doing; an empty `axis` means all.
  v1::GetStateResponse State(const std::string& axis = "") const;
  /// The same for one axis; throws Error (NOT_FOUND) where `axis` is empty and the server has several.
  v1::AxisState Axis(const std::string& axis = "") const;
  /// The M-width of the axis's loop, with the fields that are set in `overrides` in place of its own. Robust
  /// over the hands of `envelope` and the devices of `tolerance` where either is given; otherwise over the
  /// axis's own, which an override leaves out. With either up to kAnalysisTimeout.
  v1::GetMWidthResponse MWidth(const std::string& axis = "", const v1::LoopParameters& overrides = {},
                               const std::optional<v1::HandEnvelope>& envelope = std::nullopt,
                               const std::optional<v1::DeviceTolerance>& tolerance = std::nullopt) const;
  /// What the loop does to a sinusoid, and what the hand feels of the device over frequency.
  v1::GetFrequencyResponseResponse FrequencyResponse(const v1::GetFrequencyResponseRequest& request) const;
  /// How truly and how quietly a mass is rendered; with `request.simulate` up to kAnalysisTimeout.
  v1::GetAccuracyResponse Accuracy(const v1::GetAccuracyRequest& request) const;
  /// Hands row after row of the grid to `take`, in order, from the calling thread; false ends the sweep.
  /// Returns whether all rows were taken. Blocks for kAnalysisTimeout at most.
  bool SweepMWidth(const v1::SweepMWidthRequest& request,
                   const std::function<bool(const v1::SweepMWidthResponse&)>& take) const;
  /// Zero force on the next tick, fault latched, on every axis of the server; `axis` is only for the record.
  /// For anyone, at any time, without a lease. Returns every axis with its state after the stop.
  v1::EmergencyStopResponse EmergencyStop(const std::string& reason, const std::string& axis = "") const;

  /// Takes the control lease, renewed until the object goes. `client_name` is shown to people who look at the
  /// state; an unset `ttl` means the server's own (1 s). Throws Error, with reason CONTROL_HELD where another
  /// client has it.
  Control AcquireControl(const std::string& client_name, const std::string& axis = "",
                         std::optional<Seconds> ttl = std::nullopt) const;

  /// Streams every `decimation`-th tick from now on, reduced as `reduction` says, in batches of at least
  /// `min_batch` (0: what is there) and at most `max_batch` samples (0: the server's choice). Errors, an
  /// unknown axis among them, come from the stream's Next.
  SampleStream Stream(const std::string& axis = "", uint32_t decimation = 1, uint32_t max_batch = 0,
                      uint32_t min_batch = 0, v1::Reduction reduction = v1::REDUCTION_UNSPECIFIED) const;

  /// Hands what happens from now on, or behind `request.after_number`, to `take`, from the calling thread,
  /// until that returns false, which it is asked at the next event. Throws Error when the server ends the
  /// stream.
  void WatchEvents(const v1::StreamEventsRequest& request,
                   const std::function<bool(const v1::StreamEventsResponse&)>& take) const;
  /// From std::chrono::steady_clock to the axis's clock: the best of `count` exchanges.
  ClockOffset SyncClock(const std::string& axis = "", int count = 16) const;

  /// Begins to record an axis. A `labels.run` of 0 becomes the next one.
  v1::Session StartSession(const v1::SessionLabels& labels, const std::string& axis = "") const;
  /// Ends it; everything is on the server's disk then.
  v1::Session EndSession(const std::string& session_id) const;
  /// Marks a moment of the session that records the axis; without `time` the one at which it arrives.
  v1::Marker AddMarker(const v1::AddMarkerRequest& request) const;
  /// What the server has recorded, the newest first.
  v1::ListSessionsResponse ListSessions(const v1::ListSessionsRequest& request = {}) const;
  v1::GetSessionResponse GetSession(const std::string& session_id) const;
  /// Hands samples, events and markers of a session to `take` in the order of time, from the calling thread;
  /// false ends it. Returns whether all was taken. Blocks for as long as that lasts.
  bool ReadSession(const v1::ReadSessionRequest& request,
                   const std::function<bool(const v1::ReadSessionResponse&)>& take) const;

 private:
  std::shared_ptr<v1::RenderingService::StubInterface> rendering_;
  std::shared_ptr<v1::StabilityService::StubInterface> stability_;
  std::shared_ptr<v1::TelemetryService::StubInterface> telemetry_;
  std::shared_ptr<v1::SessionService::StubInterface> sessions_;
  Seconds call_timeout_;
};

}  // namespace mwidth::client
