#include "client/cpp/channel_arguments.h"

namespace mwidth::client {
namespace {

constexpr int kWindowBytes = 256 * 1024;

}  // namespace

grpc::ChannelArguments ChannelArguments() {
  grpc::ChannelArguments arguments;
  // A web proxy from the environment must not come between a laboratory's client and its robot.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // Not to measure the bandwidth by pings, of which each wakes client and server: samples come at a steady
  // rate. A window of a fixed size lets a stored session through at 256 KiB a round trip.
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kWindowBytes);
  return arguments;
}

}  // namespace mwidth::client
