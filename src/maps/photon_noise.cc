#include "maps/photon_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/random.h"
#include "core/statistics.h"

namespace glowworm {

namespace {

constexpr std::size_t kMostSquares = 1024;
/// Most looks with each of two sets of rays, and the standard error of an estimate that is small enough, as a share of
/// it. What rays add to it falls in proportion to the number of looks.
constexpr std::uint32_t kMostLooks = 4;
constexpr double kPrecision = 0.25;
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

void add(std::vector<RGB>& sum, const std::vector<RGB>& light) {
  for (std::size_t slot = 0; slot < light.size(); ++slot) sum[slot] += light[slot];
}

struct Estimate {
  double value = 0, standard_error = 0;
};

/// The mean over squares, and channels that have light, of the variance of a pixel over the square of its level.
/// @param first, second sums of so many looks with signs
Estimate relative_variance(const std::vector<RGB>& light, const std::vector<RGB>& first, const std::vector<RGB>& second,
                           std::uint32_t looks) {
  RGB all(0.0f);
  for (const RGB& level : light) all += level / static_cast<float>(light.size());
  double sum = 0, sum_of_squares = 0;
  for (std::size_t begin = 0; begin < light.size(); begin += kPixelsEach) {
    double of_square = 0;
    int lit = 0;
    for (int channel = 0; channel < 3; ++channel) {
      if (!(all[channel] > 0)) continue;
      ++lit;
      double level = 0, variance = 0;
      for (std::size_t slot = begin; slot < begin + kPixelsEach; ++slot) {
        level += double{light[slot][channel]} / kPixelsEach;
        variance += double{first[slot][channel]} * double{second[slot][channel]} / kPixelsEach;
      }
      of_square += variance / (level * level + 0.01 * double{all[channel]} * double{all[channel]});
    }
    of_square /= std::max(lit, 1) * std::pow(looks, 2);
    sum += of_square;
    sum_of_squares += of_square * of_square;
  }
  const double squares = static_cast<double>(light.size()) / kPixelsEach, mean = sum / std::max(squares, 1.0);
  return {std::max(mean, 0.0), std::sqrt(std::max(sum_of_squares - sum * mean, 0.0)) / std::max(squares, 1.0)};
}

/// The share of the square of a target that photons may have; the least growth of their number that is worth a new map.
/// The variance falls in proportion to this power of their number (measured in four rooms: 0.64 to 0.83).
constexpr double kPhotonsShare = 0.5, kLeastGrowth = 1.25, kPower = 0.75;

}  // namespace

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
                               const PassSettings& settings, double precision, MemoryBudget& budget,
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
  std::vector<RGB> first(light.size()), second(light.size());
  for (std::uint32_t looks = 1;; ++looks) {
    add(first, look(2 * looks - 1));
    add(second, look(2 * looks));
    const Estimate found = relative_variance(light, first, second, looks);
    if (looks >= kMostLooks || found.standard_error <= std::max(precision, kPrecision * found.value))
      return found.value;
  }
}

}  // namespace glowworm
