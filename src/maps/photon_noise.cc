#include "maps/photon_noise.h"

#include <algorithm>

#include "core/random.h"
#include "core/statistics.h"
#include "density/photon_sample.h"

namespace glowworm {

namespace {

/// What bounds the cost, and gives the root to a tenth: squares; pixels of each that show its level, and their rays;
/// pixels of all whose variance is found, and their rays in each of two sets.
constexpr std::size_t kMostNoiseSquares = 128, kMostPixels = 256;
constexpr std::size_t kLevelPixels = 8;
constexpr std::uint32_t kLevelRays = 8, kRays = 16;
constexpr std::size_t kPixelsEach = static_cast<std::size_t>(CameraTask::kSquare) * CameraTask::kSquare;

/// Light in the slots of a pass.
std::vector<RGB> light_of(const SlotRadiance& light, bool with_direct, bool with_caustic) {
  std::vector<RGB> out = {light.indirect.begin(), light.indirect.end()};
  for (std::size_t slot = 0; slot < out.size(); ++slot) {
    if (!light.medium.empty()) out[slot] += light.medium[slot];
    if (with_caustic) out[slot] += light.caustic[slot];
    if (with_direct) out[slot] += light.emitted[slot] + light.direct[slot];
  }
  return out;
}

/// Some pixels of each square, at random places in it.
std::vector<CameraTask> pixels_of(const std::vector<CameraTask>& squares, std::size_t count, std::uint32_t seed) {
  std::vector<CameraTask> out;
  const std::size_t run = kPixelsEach / count;
  for (const CameraTask& square : squares)
    for (std::size_t i = 0; i < count; ++i) {
      const auto at = static_cast<int>(i * run + hash_combine(seed, static_cast<std::uint32_t>(out.size())) % run);
      const int x = square.x0 + at % CameraTask::kSquare, y = square.y0 + at / CameraTask::kSquare;
      out.push_back({x, y, x + 1, y + 1, 0, 1});
    }
  return out;
}

/// For each channel that has light, the square of each square's level, and 0.01 times the square of the overall level.
std::vector<RGB> squared_levels(const std::vector<RGB>& light) {
  std::vector<RGB> levels(light.size() / kLevelPixels, RGB(0.0f));
  RGB all(0.0f);
  for (std::size_t slot = 0; slot < light.size(); ++slot)
    levels[slot / kLevelPixels] += light[slot] / static_cast<float>(kLevelPixels);
  for (const RGB& level : levels) all += level / static_cast<float>(levels.size());
  for (RGB& level : levels) level = level * level + all * all * 0.01f;
  return levels;
}

/// The mean over pixels, and channels that have light, of the variances over the squares of the levels.
double relative_variance(const std::vector<RGB>& variances, const std::vector<RGB>& levels) {
  const std::size_t each = variances.size() / std::max<std::size_t>(levels.size(), 1);
  double sum = 0;
  for (std::size_t pixel = 0; pixel < variances.size(); ++pixel) {
    const RGB &variance = variances[pixel], &level = levels[pixel / each];
    double of_pixel = 0;
    int lit = 0;
    for (int channel = 0; channel < 3; ++channel) {
      if (!(level[channel] > 0)) continue;
      ++lit;
      of_pixel += double{variance[channel]} / double{level[channel]};
    }
    sum += of_pixel / std::max(lit, 1);
  }
  return std::max(sum / std::max(static_cast<double>(variances.size()), 1.0), 0.0);
}

std::vector<RGB> products(const std::vector<RGB>& first, const std::vector<RGB>& second) {
  std::vector<RGB> out(first.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = first[i] * second[i];
  return out;
}

void add(std::vector<RGB>& sum, const std::vector<RGB>& more) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += more[i];
}

/// The share of the square of a target that photons may have; the least growth of their number that is worth a new map.
/// The variance falls in proportion to this power of their number (measured in four rooms: 0.64 to 0.83).
constexpr double kPhotonsShare = 0.5, kLeastGrowth = 1.25, kPower = 0.75;

}  // namespace

std::vector<CameraTask> squares_of(const PixelBounds& part, std::size_t most) {
  constexpr int kSide = CameraTask::kSquare;
  const auto up = [](int x) { return (x + kSide - 1) / kSide; };
  const int x0 = up(part.x0), y0 = up(part.y0);
  const auto columns = static_cast<std::size_t>(std::max(part.x1 / kSide - x0, 0));
  const auto rows = static_cast<std::size_t>(std::max(part.y1 / kSide - y0, 0));
  // One of each run of squares, at a random place in it: no column has them all.
  const std::size_t run = (columns * rows + most - 1) / most;
  std::vector<CameraTask> out;
  for (std::size_t first = 0; first < columns * rows; first += run) {
    const std::size_t at = first + hash32(static_cast<std::uint32_t>(first)) % run;
    if (at >= columns * rows) break;
    const int x = (x0 + static_cast<int>(at % columns)) * kSide, y = (y0 + static_cast<int>(at / columns)) * kSide;
    out.push_back({x, y, x + kSide, y + kSide, 0, 1});
  }
  return out;
}

RenderSettings with_photons_for_noise(RenderSettings s, double variance) {
  if (s.photon_target <= 0) return s;
  const double wanted = variance / (kPhotonsShare * s.photon_target * s.photon_target);
  const double growth = std::min(std::pow(wanted, 1 / kPower),
                                 static_cast<double>(kMostPhotonsForNoise) / static_cast<double>(s.photons));
  if (growth < kLeastGrowth) return s;
  s.photons = static_cast<std::uint64_t>(growth * static_cast<double>(s.photons));
  s.nearest = static_cast<std::uint32_t>(std::lround(std::sqrt(growth) * s.nearest));
  return s;
}

double noise_left_to_samples(double target, double photon_variance) {
  return std::sqrt(std::max(target * target - photon_variance, (1 - kPhotonsShare) * target * target));
}

double measure_photon_variance(const Tracer& tracer, const PhotonMaps& maps, const View& view, const PixelBounds& part,
                               const PassSettings& settings, MemoryBudget& budget) {
  const std::vector<CameraTask> squares = squares_of(part, kMostNoiseSquares);
  if (squares.empty()) return 0;
  PassMemory memory;
  Statistics not_the_renders;
  PassSettings pass = settings;
  pass.places = pass.surface_samples = pass.by_disk = false;
  pass.values = {};
  pass.light_groups = nullptr;
  const auto look = [&](CameraTasks tasks, std::uint32_t stream) {
    pass.seed = hash_combine(hash_combine(settings.seed, kPhotonNoiseStream), stream);
    return render_pass(tracer, maps, view, tasks, pass, budget, memory, not_the_renders);
  };
  pass.gather = kLevelRays;
  const PassResult light = look(pixels_of(squares, kLevelPixels, settings.seed), 0);
  pass.gather = kRays;
  pass.direct = false;
  pass.query_points_alone = true;
  const std::size_t each = std::clamp<std::size_t>(kMostPixels / squares.size(), 1, kPixelsEach);
  const std::vector<CameraTask> pixels = pixels_of(squares, each, hash32(settings.seed));
  const PassResult first = look(pixels, 1), second = look(pixels, 2);
  std::vector<RGB> variances =
      variance_by_photons(maps.sample(), first.global_points, second.global_points, pixels.size());
  // Signed photons in media alone bring light to these.
  add(variances, products(light_of(first.radiance, false, false), light_of(second.radiance, false, false)));
  add(variances,
      variance_by_photons(maps.caustic_sample(), first.caustic_points, second.caustic_points, pixels.size()));
  return relative_variance(variances, squared_levels(light_of(light.radiance, settings.direct, settings.caustic)));
}

}  // namespace glowworm
