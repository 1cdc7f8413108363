// One density estimate of fixed size on one thread, for scripts/count-instructions: prints what was counted.
//
// usage: estimate_once [ENGINE [SCENE [PHOTONS [SIDE [RAYS]]]]]     (default: blocked builtin:atrium 100000 64 100)
//   SIDE  pixels of the picture along each side; RAYS  final gather rays of a pixel. Each photon has its own radius,
//   that k = 50 asks for.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "core/parallel.h"
#include "density/engine.h"
#include "density/radius.h"
#include "kernels/simd.h"
#include "support/recording.h"

int main(int argc, char** argv) {
  using namespace glowworm;
  const std::vector<std::string> asked(argv + 1, argv + argc);
  const auto argument = [&](std::size_t i, const char* otherwise) { return i < asked.size() ? asked[i] : otherwise; };
  set_thread_count(1);
  bench::RecordingSettings settings;
  settings.photons = std::stoull(argument(2, "100000"));
  settings.width = settings.height = std::stoi(argument(3, "64"));
  settings.gather = static_cast<std::uint32_t>(std::stoul(argument(4, "100")));
  const bench::Recording recording = record(bench::Stage(argument(1, "builtin:atrium")), settings);
  RadiusPolicy policy;
  PhotonRadii found = measured_radii(recording.photons, 50);
  policy.radii = found.radii;
  policy.order = found.order;
  const auto engine = make_engine(argument(0, "blocked"));
  Statistics s;
  engine->build(recording.photons, recording.photons.flux, policy, s);
  std::vector<RGB> radiance(recording.points.size());
  engine->estimate(recording.points, radiance, s);
  fmt::print("engine {} isa {} photons {} query_points {} shader_operations {} pairs_tested {} vector_steps {}\n",
             engine->name(), simd_name(), recording.photons.size(), recording.points.size(),
             s.count(Counter::shader_operations), s.count(Counter::pairs_tested), s.count(Counter::packet_steps));
}
