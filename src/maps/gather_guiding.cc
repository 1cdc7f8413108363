#include "maps/gather_guiding.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/archive.h"
#include "core/random.h"

namespace glowworm {

namespace {

/// Rays of a point of the pilot pass, and most of all.
constexpr std::uint32_t kRaysEach = 16;
constexpr double kMaxRays = 1 << 19;
/// The pilot pass ends after one of so many parts if a guide from that gains less than its rays would cost: guided rays
/// find more photons, so a sample takes about a tenth longer.
constexpr std::size_t kParts = 4;
/// Points of a piece of the pilot pass: a tenth of a second of a core.
constexpr double kPointsOfPiece = 4096;
/// Fewest points of a piece that are worked on at a time. Lookups of many points are faster, so as many are taken as an
/// eighth of the free memory holds.
constexpr std::size_t kMinPointsAtOnce = 256;
constexpr std::uint64_t kBytesAtWork = 13'000;
/// Memory of a point, and of it with its rays.
constexpr std::uint64_t kBytesOfPoint = 2 * sizeof(Vec3), kBytesEach = kBytesOfPoint + kRaysEach * (sizeof(float) + 1);

class Pilot {
 public:
  /// @param wanted number of points
  Pilot(const Tracer& tracer, const PhotonMaps& maps, const View& view, double wanted, const PassSettings& settings,
        MemoryBudget& budget)
      : tracer_(tracer), maps_(maps), view_(view), wanted_(wanted), settings_(settings), budget_(budget) {
    settings_.kind = PassKind::gather_rays;
    settings_.gather = settings_.light_samples = 1;
    settings_.patches = settings_.by_disk = settings_.places = settings_.extrapolates = false;
    settings_.guide = nullptr;
    settings_.light_groups = nullptr;
    settings_.seed = hash_combine(settings_.seed, kGuideStream);
  }

  /// Gathers from piece `piece` of `pieces` of the points, and appends to the rays. The first of kParts of the pieces
  /// have points from everywhere.
  void gather(std::size_t piece, std::size_t pieces, GuideRays& rays) {
    if (!found_) find_points();
    found_ = true;
    const auto first_of = [&](std::size_t i) { return normals_.size() * i / pieces; };
    const std::size_t at_once = std::max<std::size_t>(budget_.available() / 8 / kBytesAtWork, kMinPointsAtOnce);
    for (std::size_t first = first_of(piece), end = first_of(piece + 1); first < end; first += at_once)
      gather_from(first, std::min(first + at_once, end), rays);
  }

 private:
  void find_points() {
    if (view_.points) look_from(*view_.points, static_cast<std::size_t>(wanted_));
    for (const Camera* const camera : view_.cameras()) {
      const double points = wanted_ / static_cast<double>(view_.cameras().size());
      look_from(*camera, std::sqrt(std::min(points / (static_cast<double>(settings_.width) * settings_.height), 1.0)));
    }
    positions_ = in_parts(positions_);
    normals_ = in_parts(normals_);
  }

  /// Every kParts-th point, then the points after these, and so on.
  static std::vector<Vec3> in_parts(const std::vector<Vec3>& points) {
    std::vector<Vec3> out;
    out.reserve(points.size());
    for (std::size_t part = 0; part < kParts; ++part)
      for (std::size_t i = part; i < points.size(); i += kParts) out.push_back(points[i]);
    return out;
  }

  /// @param share of the pixels along a side of the picture
  void look_from(const Camera& camera, double share) {
    const auto scaled = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels * share))); };
    CameraPassSettings camera_settings;
    camera_settings.width = scaled(settings_.width);
    camera_settings.height = scaled(settings_.height);
    camera_settings.seed = settings_.seed;
    const int rows = std::max(1, static_cast<int>(kMinPointsAtOnce) / camera_settings.width);
    for (int y = 0; y < camera_settings.height; y += rows) {
      const CameraTask task{0, y, camera_settings.width, std::min(y + rows, camera_settings.height), 0, 1};
      SlotRadiance emitted;
      FirstHit first_hit;
      GatherPoints points;
      camera_pass(tracer_, camera, task, camera_settings, emitted, first_hit, points, statistics_);
      for (std::size_t i = 0; i < points.size(); ++i)
        if (GatherGuide::guides(points.bsdf[i])) add(points.position[i], points.normal[i]);
    }
  }

  /// @param count points in all, which repeat points of the grid or leave some out
  void look_from(const PointGrid& grid, std::size_t count) {
    const std::size_t cells = grid.normal.size();
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t cell = count < cells ? i * cells / count : i % cells;
      if (grid.has(cell) && !grid.looks_behind(cell)) add(grid.position[cell], grid.normal[cell]);
    }
  }

  void add(Vec3 position, Vec3 normal) {
    positions_.push_back(position);
    normals_.push_back(normal);
  }

  /// Gathers from points [first, end). The rays do not depend on which points are gathered from at once.
  void gather_from(std::size_t first, std::size_t end, GuideRays& rays) {
    PointGrid grid;
    grid.position.assign(positions_.begin() + static_cast<std::ptrdiff_t>(first),
                         positions_.begin() + static_cast<std::ptrdiff_t>(end));
    grid.normal.assign(normals_.begin() + static_cast<std::ptrdiff_t>(first),
                       normals_.begin() + static_cast<std::ptrdiff_t>(end));
    grid.on_surfaces = true;
    grid.height = 1;
    grid.width = static_cast<int>(end - first);
    grid.first_sequence = static_cast<std::uint32_t>(first);
    PassSettings settings = settings_;
    settings.width = grid.width;
    settings.height = 1;
    const CameraTask task{0, 0, grid.width, 1, 0, kRaysEach};
    const PassResult found = render_pass(tracer_, maps_, grid, task, settings, budget_, memory_, statistics_);
    const auto count = static_cast<std::uint32_t>(grid.width);
    for (std::uint32_t i = 0; i < count; ++i) {
      rays.position.push_back(grid.position[i]);
      rays.normal.push_back(grid.normal[i]);
      for (std::uint32_t sample = 0; sample < kRaysEach; ++sample) {
        const std::size_t slot = std::size_t{sample} * count + i;
        const float light = luminance(found.radiance.direct[slot] + found.radiance.indirect[slot]);
        rays.light.push_back(std::isfinite(light) ? light : 0.0f);
        rays.cell.push_back(GatherGuide::cell(gather_square(grid.sequence(i, sample), sample, 1, 0, settings.seed)));
      }
    }
  }

  const Tracer& tracer_;
  const PhotonMaps& maps_;
  const View& view_;
  double wanted_;
  PassSettings settings_;
  MemoryBudget& budget_;
  PassMemory memory_;
  Statistics statistics_;  // The counts are not the render's.
  bool found_ = false;
  std::vector<Vec3> positions_, normals_;
};

std::vector<std::byte> packed_rays(const GuideRays& rays) {
  return archived(rays.position, rays.normal, rays.cell, rays.light);
}

GuideRays unpacked_rays(std::span<const std::byte> bytes) {
  GuideRays rays;
  unarchive(bytes, rays.position, rays.normal, rays.cell, rays.light);
  const std::size_t points = rays.position.size();
  require(rays.normal.size() == points && rays.cell.size() == points * kRaysEach &&
          rays.light.size() == points * kRaysEach);
  for (const auto* vectors : {&rays.position, &rays.normal})
    for (const Vec3& v : *vectors) require(is_finite(v));
  static_assert(GatherGuide::kSide * GatherGuide::kSide == 256);  // so that every byte is a cell
  for (const float light : rays.light) require(std::isfinite(light));
  return rays;
}

void append_rays(GuideRays& rays, const GuideRays& more) {
  const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  add(rays.position, more.position);
  add(rays.normal, more.normal);
  add(rays.cell, more.cell);
  add(rays.light, more.light);
}

}  // namespace

namespace {

/// Points of the pilot pass.
double pilot_points(double pixels, std::uint32_t gather, bool of_points) {
  // Half of one sample's rays in all pixels. Points may be few, with many samples each.
  return std::clamp(pixels * gather * 0.5, of_points ? double{1 << 16} : 0, kMaxRays) / kRaysEach;
}

}  // namespace

std::uint64_t gather_guide_bytes(double pixels, std::uint32_t gather, bool of_points) {
  return static_cast<std::uint64_t>(pilot_points(pixels, gather, of_points)) * (kBytesOfPoint + kBytesEach);
}

GatherGuide learn_gather_guide(const Tracer& tracer, const PhotonMaps& maps, const View& view,
                               const PassSettings& settings, MemoryBudget& budget, Statistics& statistics,
                               SharedWork* shared) {
  if (settings.gather == 0 || (view.points ? !view.points->learns : maps.empty())) return {};
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  const double pixels = static_cast<double>(settings.width) * settings.height;
  const bool of_points = view.points != nullptr;
  const double points = pilot_points(pixels, settings.gather, of_points);
  const Reservation reservation(budget, "guide of gather rays", gather_guide_bytes(pixels, settings.gather, of_points));
  const std::size_t pieces = kParts * static_cast<std::size_t>(std::ceil(points / kPointsOfPiece / kParts));
  Pilot pilot(tracer, maps, view, points, settings, budget);
  GuideRays rays;
  rays.rays_each = kRaysEach;
  const auto gather = [&](const char* name, std::size_t first, std::size_t end) {
    const auto make = [&](std::size_t piece) {
      GuideRays own;
      pilot.gather(first + piece, pieces, own);
      return packed_rays(own);
    };
    const auto take = [&](std::size_t, std::span<const std::byte> bytes) { append_rays(rays, unpacked_rays(bytes)); };
    if (shared)
      shared->divide(name, end - first, make, take);
    else
      for (std::size_t piece = first; piece < end; ++piece) pilot.gather(piece, pieces, rays);
  };
  gather("gather-guide", 0, pieces / kParts);
  // Guided rays find more photons, so a sample takes about a tenth longer: the guide has to gain that.
  if (view.camera && GatherGuide(rays).gain() < 0.12) return {};
  gather("gather-guide-more", pieces / kParts, pieces);
  return GatherGuide(rays);
}

}  // namespace glowworm
