// How this project's clients connect.
#pragma once

#include <grpcpp/support/channel_arguments.h>

namespace mwidth::client {

/// No proxy, and no probing of the connection's bandwidth.
grpc::ChannelArguments ChannelArguments();

}  // namespace mwidth::client
