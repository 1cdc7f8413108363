#include "render/photon_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/random.h"
#include "core/statistics.h"

namespace glowworm {

namespace {

constexpr std::size_t kMostSquares = 1024;
constexpr std::size_t kPixelsEach = static_cast<std::size_t>(CameraTask::kSquare) * CameraTask::kSquare;

/// Tasks of whole squares all over the part, a sample of each pixel.
std::vector<CameraTask> squares_of(const PixelBounds& part) {
  constexpr int kSide = CameraTask::kSquare;
  const auto up = [](int x) { return (x + kSide - 1) / kSide; };
  const int x0 = up(part.x0), y0 = up(part.y0);
  const auto columns = static_cast<std::size_t>(std::max(part.x1 / kSide - x0, 0));
  const auto rows = static_cast<std::size_t>(std::max(part.y1 / kSide - y0, 0));
  // One of each run of squares, at a random place in it: no column has them all.
  const std::size_t run = (columns * rows + kMostSquares - 1) / kMostSquares;
  std::vector<CameraTask> out;
  for (std::size_t first = 0; first < columns * rows; first += run) {
    const std::size_t at = first + hash32(static_cast<std::uint32_t>(first)) % run;
    if (at >= columns * rows) break;
    const int x = (x0 + static_cast<int>(at % columns)) * kSide, y = (y0 + static_cast<int>(at / columns)) * kSide;
    out.push_back({x, y, x + kSide, y + kSide, 0, 1});
  }
  return out;
}

/// Light in the slots of a pass.
std::vector<RGB> light_of(const SlotRadiance& light, bool with_direct, bool with_caustic) {
  std::vector<RGB> out = {light.indirect.begin(), light.indirect.end()};
  for (std::size_t slot = 0; slot < out.size(); ++slot) {
    if (with_caustic) out[slot] += light.caustic[slot];
    if (with_direct) out[slot] += light.emitted[slot] + light.direct[slot];
  }
  return out;
}

/// The mean over squares of the variance of a pixel over the square of its level, in one channel; NaN if it has no
/// light.
/// @param first, second with signs
double relative_variance(const std::vector<RGB>& light, const std::vector<RGB>& first, const std::vector<RGB>& second,
                         int channel) {
  double all = 0;
  for (const RGB& level : light) all += double{level[channel]} / static_cast<double>(light.size());
  double sum = 0;
  for (std::size_t begin = 0; begin < light.size(); begin += kPixelsEach) {
    double level = 0, variance = 0;
    for (std::size_t slot = begin; slot < begin + kPixelsEach; ++slot) {
      level += double{light[slot][channel]} / kPixelsEach;
      variance += double{first[slot][channel]} * double{second[slot][channel]} / kPixelsEach;
    }
    const double scale = level * level + 0.01 * all * all;
    if (scale > 0) sum += variance / scale;
  }
  return all > 0 ? sum * kPixelsEach / static_cast<double>(light.size()) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

double measure_photon_variance(const Tracer& tracer, const PhotonMaps& maps, const View& view, const PixelBounds& part,
                               const PassSettings& settings, MemoryBudget& budget,
                               const std::function<void()>& add_signs) {
  const std::vector<CameraTask> tasks = squares_of(part);
  PassMemory memory;
  Statistics not_the_renders;
  PassSettings pass = settings;
  pass.places = pass.fine = pass.by_disk = false;
  pass.values = {};
  pass.light_groups = nullptr;
  const auto look = [&](std::uint32_t stream) {
    pass.seed = hash_combine(hash_combine(settings.seed, kPhotonNoiseStream), stream);
    const PassResult found = render_pass(tracer, maps, view, tasks, pass, budget, memory, not_the_renders);
    return light_of(found.radiance, pass.direct, pass.caustic);
  };
  const std::vector<RGB> light = look(0);
  add_signs();
  // Only what is a sum over photons.
  pass.direct = false;
  pass.photons_alone = true;
  const std::vector<RGB> first = look(1), second = look(2);
  double sum = 0;
  int lit = 0;
  for (int channel = 0; channel < 3; ++channel) {
    const double variance = relative_variance(light, first, second, channel);
    if (std::isnan(variance)) continue;
    sum += variance;
    ++lit;
  }
  return lit > 0 ? std::max(sum / lit, 0.0) : 0;
}

}  // namespace glowworm
