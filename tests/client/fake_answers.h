// What the fake server says: figures of one made-up loop, in the form of mwidthd's answers.
#pragma once

#include <grpcpp/support/status.h>
#include <mwidth/v1/stability.pb.h>

#include <string>

namespace mwidth::testing {

/// Edges of what is admitted, within the nominal (-0.07, 0.5).
inline constexpr double kAdmittedMin = -0.0512345678;
inline constexpr double kAdmittedMax = 0.3512345678;

/// Highest cut-off that the mass that is set is admitted with.
inline constexpr double kMaxCutoffHz = 40;

v1::LoopParameters Loop();
v1::MWidth Width();
/// The report on `mass`, admitted or not.
v1::StabilityReport Report(double mass);
/// A status with an ErrorInfo of `reason` in its details, and `report` where there is one.
grpc::Status Failure(grpc::StatusCode code, const std::string& reason, const std::string& message,
                     const v1::StabilityReport* report = nullptr);

}  // namespace mwidth::testing
