#include "render/gather_guiding.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/random.h"

namespace glowworm {

namespace {

/// Rays of a point of the pilot pass, and most of all.
constexpr std::uint32_t kRaysEach = 16;
constexpr double kMaxRays = 1 << 20;
/// Rays from a PointGrid at least: there may be few points, with many samples each.
constexpr double kMinRaysFromPoints = 1 << 16;
/// Rays of the pilot pass, as a share of those of a sample of all pixels.
constexpr double kShare = 0.5;
/// Points of the pilot pass that are worked on at a time.
constexpr std::size_t kCellsAtOnce = 256;
/// Memory of what is kept of each point.
constexpr std::uint64_t kBytesEach = 2 * sizeof(Vec3) + kRaysEach * (sizeof(float) + 1);

class Pilot {
 public:
  Pilot(const Tracer& tracer, const PhotonMaps& maps, const PassSettings& settings, MemoryBudget& budget)
      : tracer_(tracer), maps_(maps), settings_(settings), budget_(budget) {
    settings_.kind = PassKind::gather_rays;
    settings_.gather = settings_.light_samples = 1;
    settings_.patches = settings_.by_disk = settings_.places = false;
    settings_.guide = nullptr;
    settings_.light_groups = nullptr;
    rays_.rays_each = kRaysEach;
  }

  /// @param share of the pixels along a side of the picture
  GuideRays look_from(const Camera& camera, double share) {
    const auto scaled = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels * share))); };
    CameraPassSettings camera_settings;
    camera_settings.width = scaled(settings_.width);
    camera_settings.height = scaled(settings_.height);
    camera_settings.seed = hash_combine(settings_.seed, kGuideStream);
    const int rows = std::max(1, static_cast<int>(kCellsAtOnce) / camera_settings.width);
    for (int y = 0; y < camera_settings.height; y += rows) {
      const CameraTask task{0, y, camera_settings.width, std::min(y + rows, camera_settings.height), 0, 1};
      SlotRadiance emitted;
      FirstHit first_hit;
      GatherPoints points;
      camera_pass(tracer_, camera, task, camera_settings, emitted, first_hit, points, statistics_);
      for (std::size_t i = 0; i < points.size(); ++i)
        if (is_lambertian(points.bsdf[i])) add(points.position[i], points.normal[i]);
    }
    gather();
    return std::move(rays_);
  }

  /// @param count points in all, which repeat those of the grid or leave some out
  GuideRays look_from(const PointGrid& grid, std::size_t count) {
    const std::size_t cells = grid.normal.size();
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t cell = count < cells ? i * cells / count : i % cells;
      if (grid.has(cell)) add(grid.position[cell], grid.normal[cell]);
    }
    gather();
    return std::move(rays_);
  }

 private:
  void add(Vec3 position, Vec3 normal) {
    pending_.position.push_back(position);
    pending_.normal.push_back(normal);
    if (pending_.normal.size() == kCellsAtOnce) gather();
  }

  /// Gathers from the pending points.
  void gather() {
    PointGrid grid = std::move(pending_);
    pending_ = {};
    grid.on_surfaces = true;
    grid.height = 1;
    grid.width = static_cast<int>(grid.normal.size());
    if (grid.width == 0) return;
    PassSettings settings = settings_;
    settings.width = grid.width;
    settings.height = 1;
    settings.seed = hash_combine(hash_combine(settings_.seed, kGuideStream), runs_++);
    const CameraTask task{0, 0, grid.width, 1, 0, kRaysEach};
    const PassResult found = render_pass(tracer_, maps_, grid, task, settings, budget_, memory_, statistics_);
    const auto count = static_cast<std::uint32_t>(grid.width);
    for (std::uint32_t i = 0; i < count; ++i) {
      rays_.position.push_back(grid.position[i]);
      rays_.normal.push_back(grid.normal[i]);
      for (std::uint32_t sample = 0; sample < kRaysEach; ++sample) {
        const std::size_t slot = std::size_t{sample} * count + i;
        const float light = luminance(found.radiance.direct[slot] + found.radiance.indirect[slot]);
        rays_.light.push_back(std::isfinite(light) ? light : 0.0f);
        rays_.cell.push_back(GatherGuide::cell(gather_square(i, sample, 1, 0, settings.seed)));
      }
    }
  }

  const Tracer& tracer_;
  const PhotonMaps& maps_;
  PassSettings settings_;
  MemoryBudget& budget_;
  PassMemory memory_;
  Statistics statistics_;  // The counts are not the render's.
  GuideRays rays_;
  PointGrid pending_;
  std::uint32_t runs_ = 0;
};

}  // namespace

GatherGuide learn_gather_guide(const Tracer& tracer, const PhotonMaps& maps, const View& view,
                               const PassSettings& settings, MemoryBudget& budget, Statistics& statistics) {
  if (settings.gather == 0 || (view.points ? !view.points->learns : maps.empty())) return {};
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  const double pixels = static_cast<double>(settings.width) * settings.height;
  const double rays = pixels * settings.gather * kShare;
  const double points = std::clamp(rays, view.points ? kMinRaysFromPoints : 0, kMaxRays) / kRaysEach;
  const Reservation reservation(budget, "guide of gather rays", static_cast<std::uint64_t>(points) * kBytesEach);
  Pilot pilot(tracer, maps, settings, budget);
  if (view.points) return GatherGuide(pilot.look_from(*view.points, static_cast<std::size_t>(points)));
  return GatherGuide(pilot.look_from(*view.camera, std::sqrt(std::min(points / pixels, 1.0))));
}

}  // namespace glowworm
