#include "device/canopen/sdo_client.h"

#include <sstream>

#include "device/canopen/sdo.h"

namespace mwidth::device::canopen {
namespace {

constexpr double kPatienceS = 0.5;

std::string Hex(uint32_t value) {
  std::ostringstream text;
  text << std::hex << std::uppercase << value << 'h';
  return text.str();
}

// The next frame with this identifier until a time.
std::optional<can::Frame> WaitUntil(can::Bus& bus, uint16_t identifier, int64_t deadline_ns, Now now) {
  can::Frame frame;
  while (true) {
    switch (bus.Receive(frame, deadline_ns)) {
      case can::Reception::kLost:
        throw std::runtime_error("the bus is lost; check the cable, the termination and the bit rate");
      case can::Reception::kNothing:
        return std::nullopt;
      case can::Reception::kFrame:
        break;
    }
    if (frame.identifier == identifier && !frame.remote) {
      return frame;
    }
    if (now() >= deadline_ns) {
      return std::nullopt;
    }
  }
}

}  // namespace

std::string NameOf(const Object& object) {
  return Hex(object.index) + (object.subindex == 0 ? "" : ":" + std::to_string(object.subindex));
}

std::optional<can::Frame> WaitFor(can::Bus& bus, uint16_t identifier, double patience_s, Now now) {
  return WaitUntil(bus, identifier, now() + static_cast<int64_t>(patience_s * 1e9), now);
}

template <typename Judge>
uint32_t SdoClient::Exchange(const can::Frame& request, const Object& object, Judge judge) {
  const int64_t deadline_ns = now_() + static_cast<int64_t>(kPatienceS * 1e9);
  bus_.Send(request);
  while (const auto frame = WaitUntil(bus_, static_cast<uint16_t>(kSdoReply + node_), deadline_ns, now_)) {
    const SdoReply reply = judge(*frame, object);
    switch (reply.kind) {
      case SdoKind::kValue:
      case SdoKind::kTaken:
        return reply.value;
      case SdoKind::kAborted:
        throw SdoAborted("it refuses object " + NameOf(object) + ": " + AbortWords(reply.value) + " (" +
                         Hex(reply.value) + ")");
      case SdoKind::kWrongSize:
        throw std::runtime_error("its object " + NameOf(object) + " has not the " +
                                 std::to_string(object.size) +
                                 " bytes of the profile; check that it is a CiA 402 drive");
      case SdoKind::kOther:
        break;
    }
  }
  throw std::runtime_error("it does not answer for object " + NameOf(object) +
                           "; check its power, its node number, the bit rate and the termination");
}

uint32_t SdoClient::Upload(const Object& object) {
  return Exchange(UploadRequest(node_, object), object, UploadReply);
}

void SdoClient::Download(const Object& object, uint32_t value) {
  Exchange(DownloadRequest(node_, object, value), object, DownloadReply);
}

}  // namespace mwidth::device::canopen
