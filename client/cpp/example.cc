// Takes control of an axis, renders a mass, prints a second of samples and shows what a refusal looks like.
//
//   mwidth-example [HOST:PORT]      without it: MWIDTH_SERVER, or 127.0.0.1:50051
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <variant>

#include "client/cpp/client.h"

namespace {

using mwidth::client::Refusal;
using mwidth::v1::SetMassResponse;

void Report(const mwidth::client::MassAnswer& answer) {
  if (const auto* refusal = std::get_if<Refusal>(&answer)) {
    std::printf("refused (%s): %s\n", refusal->reason.c_str(), refusal->sentence.c_str());
    std::printf("nearest admitted mass: %g\n", refusal->stability.nearest_admitted_mass());
  } else {
    const auto& admitted = std::get<SetMassResponse>(answer);
    std::printf("rendering %g, gain margin %.1f dB\n", admitted.mass(),
                admitted.stability().gain_margin_db());
  }
}

void Run(const char* address) {
  const auto client = mwidth::client::Client::Connect(address);
  const auto admitted = client.MWidth().m_width().admitted();

  auto control = client.AcquireControl("example");  // renewed in the background, released at the end of Run
  control.StartRendering();
  Report(control.SetMass(admitted.max() / 2));

  auto stream = client.Stream("", /*decimation=*/100, /*max_batch=*/1);
  for (double first_s = -1, time_s = 0; first_s < 0 || time_s < first_s + 1;) {
    const auto batch = stream.Next();
    for (int i = 0; batch && i < batch->position_size(); ++i) {
      time_s = 1e-9 * static_cast<double>(batch->monotonic_ns(i));
      first_s = first_s < 0 ? time_s : first_s;
      std::printf("%6.3f s  position %9.6f  force %9.6f\n", time_s - first_s, batch->position(i),
                  batch->force(i));
    }
  }

  Report(control.SetMass(admitted.max() * 2));
  control.StopRendering();
}

}  // namespace

int main(int argc, char** argv) {
  const char* configured = std::getenv("MWIDTH_SERVER");
  const char* address = configured != nullptr ? configured : "127.0.0.1:50051";
  try {
    Run(argc > 1 ? argv[1] : address);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
