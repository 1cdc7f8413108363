#include "gather/bright_patches.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "core/warp.h"
#include "scene/surface.h"
#include "transport/light_connection.h"

namespace glowworm {

namespace {

/// A triangle's sides are halved at most this many times.
constexpr int kDeepest = 7;
/// Probe rays around a bright photon, and how far above the surface they start, in radii.
constexpr int kProbes = 6;
constexpr float kAbove = 0.25f;

/// The irradiance above which points are bright; infinite if sampling bright points would not pay off.
double find_threshold(const LitPlaces& places) {
  std::vector<std::size_t> order;
  double area = 0, flux = 0, moment = 0;
  for (std::size_t i = 0; i < places.flux.size(); ++i) {
    if (!(places.irradiance[i] > 0) || !(places.flux[i] > 0)) continue;
    order.push_back(i);
    // A photon represents the area over which its flux gives the irradiance there.
    area += static_cast<double>(places.flux[i]) / places.irradiance[i];
    flux += places.flux[i];
    moment += static_cast<double>(places.flux[i]) * places.irradiance[i];
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return places.irradiance[a] != places.irradiance[b] ? places.irradiance[a] > places.irradiance[b] : a < b;
  });
  double bright_area = 0, bright_moment = 0, threshold = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order) {
    bright_area += static_cast<double>(places.flux[i]) / places.irradiance[i];
    // Patches cover at most 8% of the lit area, so that few rays need weighting, and have at least 8 times the mean
    // irradiance.
    if (bright_area > 0.08 * area || places.irradiance[i] < 8 * flux / area) break;
    bright_moment += static_cast<double>(places.flux[i]) * places.irradiance[i];
    threshold = places.irradiance[i];
  }
  // Patches pay off if they hold at least half of the mean square of radiosity.
  return bright_moment >= 0.5 * moment ? threshold : std::numeric_limits<double>::infinity();
}

std::uint64_t key_of(std::uint32_t triangle, std::uint32_t cell) { return std::uint64_t{triangle} << 32 | cell; }

/// The number of times a triangle's sides are halved until its cells are no larger than a square around a circle of
/// that radius.
int level_of(const Geometry& geometry, std::uint32_t triangle, float radius) {
  const float cells = std::clamp(geometry.area(triangle) / (4 * radius * radius), 1.0f, float{1 << (2 * kDeepest)});
  return static_cast<int>(std::lround(std::log2(cells) / 2));
}

/// Number of a cell. Each square of the barycentric grid holds two cells, a lower and an upper one.
std::uint32_t cell_of(Vec2 barycentric, int level) {
  const int n = 1 << level;
  const float x = barycentric.x * static_cast<float>(n), y = barycentric.y * static_cast<float>(n);
  const int i = std::clamp(static_cast<int>(x), 0, n - 1), j = std::clamp(static_cast<int>(y), 0, n - 1 - i);
  const bool upper = (x - static_cast<float>(i)) + (y - static_cast<float>(j)) > 1 && i + j < n - 1;
  return static_cast<std::uint32_t>((i * n + j) * 2 + upper);
}

Vec3 point_on(const Geometry& geometry, std::uint32_t triangle, Vec2 b) {
  const auto [p, q, r] = geometry.corners(triangle);
  return p + (q - p) * b.x + (r - p) * b.y;
}

}  // namespace

// One ray in four goes to patches.
std::uint32_t default_patch_samples(std::uint32_t gather_rays) { return std::max(1u, gather_rays / 4); }

BrightPatches::BrightPatches(const Tracer& tracer, const LitPlaces& places, const RadiusGrid& radii) {
  const double threshold = find_threshold(places);
  if (!std::isfinite(threshold)) return;
  const Scene& scene = tracer.scene();
  const Geometry& geometry = scene.geometry();
  std::vector<Ray> rays;
  std::vector<std::size_t> place;
  for (std::size_t i = 0; i < places.position.size(); ++i) {
    if (places.irradiance[i] < threshold) continue;
    // Probe back to the surface from slightly above it, over a disc as wide as the blur of photons, because patches
    // also emit between photons.
    const Vec3 n = places.normal[i];
    const Frame frame = Frame::from_normal(n);
    const float radius = radii.radius(places.position[i]), above = kAbove * radius;
    Sampler sampler(SamplerKind::independent, 0, kBrightPatchStream, static_cast<std::uint32_t>(i));
    for (int k = 0; k < kProbes; ++k) {
      const Vec2 on_disc = k == 0 ? Vec2{0, 0} : square_to_disk(sampler.next2()) * radius;
      const Vec3 over = places.position[i] + frame.s * on_disc.x + frame.t * on_disc.y + n * above;
      rays.push_back({over, 0, -n, 2 * above});
      place.push_back(i);
    }
  }
  std::vector<Hit> hits(rays.size());
  tracer.intersect(rays, hits, RayOrder::incoherent);
  level_.assign(geometry.triangles.size(), kNoLevel);
  std::vector<double> irradiance, count;
  std::vector<LightBounds> bounds;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::uint32_t triangle = hits[i].triangle;
    if (triangle == kNone || geometry.emission_of(triangle) != kNone) continue;
    SurfacePoint point = surface_point(scene, triangle, hits[i].barycentric);
    const Vec3 wo = places.normal[place[i]];
    const Bsdf bsdf = resolve_bsdf(scene, point);
    const float scattered = luminance(shaded(point, bsdf).albedo(wo, kBroad));
    if (!(scattered > 0)) continue;
    if (level(triangle) == kNoLevel)
      (triangle < level_.size() ? level_[triangle] : instance_level_[triangle]) =
          static_cast<std::uint8_t>(level_of(geometry, triangle, radii.radius(point.position)));
    const std::uint32_t patch = add(geometry, triangle, cell_of(hits[i].barycentric, level(triangle)));
    if (patch == bounds.size()) {
      LightBounds& b = bounds.emplace_back();
      const Patch& p = patches_[patch];
      for (const Vec2 corner : {p.corner, p.corner + p.side_a, p.corner + p.side_b})
        b.box.grow(point_on(geometry, triangle, corner));
      b.axis = face_forward(geometry.normal(triangle), wo);
      irradiance.push_back(0);
      count.push_back(0);
    }
    LightBounds& b = bounds[patch];
    // Translucent sheets emit on both sides, and may be lit on both.
    b.two_sided |= dot(b.axis, wo) < 0 || (lobes(bsdf) & kDiffuseTransmission);
    irradiance[patch] += places.irradiance[place[i]] * scattered;
    count[patch] += 1;
  }
  for (std::size_t i = 0; i < bounds.size(); ++i)
    bounds[i].intensity = static_cast<float>(irradiance[i] / count[i]) * patches_[i].area / kPi;
  tree_ = LightTree(bounds);
}

std::uint32_t BrightPatches::add(const Geometry& geometry, std::uint32_t triangle, std::uint32_t cell) {
  const auto [entry, is_new] =
      of_cell_.try_emplace(key_of(triangle, cell), static_cast<std::uint32_t>(patches_.size()));
  if (!is_new) return entry->second;
  const int n = 1 << level(triangle);
  const float step = 1 / static_cast<float>(n);
  const int square = static_cast<int>(cell / 2);
  const auto i = static_cast<float>(square / n), j = static_cast<float>(square % n);
  Patch patch{triangle, {i * step, j * step}, {step, 0}, {0, step}, geometry.area(triangle) * step * step};
  if (cell % 2) {
    patch.corner = {(i + 1) * step, (j + 1) * step};
    patch.side_a = {-step, 0};
    patch.side_b = {0, -step};
  }
  patches_.push_back(patch);
  return entry->second;
}

std::uint32_t BrightPatches::find_cell(std::uint32_t triangle, Vec2 barycentric) const {
  const auto found = of_cell_.find(key_of(triangle, cell_of(barycentric, level(triangle))));
  return found == of_cell_.end() ? kNone : found->second;
}

float BrightPatches::density(Vec3 from, std::uint32_t patch) const {
  return tree_.probability(from, patch) / patches_[patch].area;
}

BrightPatches::Sample BrightPatches::sample(const Geometry& geometry, Vec3 from, float u, Vec2 v) const {
  LightTree::Descent descent;
  const LightTree::Choice choice = tree_.choose(from, u, descent);
  if (!(choice.probability > 0)) return {};
  const Patch& patch = patches_[choice.light];
  const Vec2 w = square_to_triangle(v);
  const Vec2 b = patch.corner + patch.side_a * w.x + patch.side_b * w.y;
  return {choice.light, point_on(geometry, patch.triangle, b), choice.probability / patch.area};
}

void create_patch_rays(const Scene& scene, const BrightPatches& patches, const GatherPoints& points,
                       std::span<const std::uint32_t> order, const PatchRaySettings& settings, GatherPaths& out) {
  const auto [rays_each, samples_each, seed] = settings;
  for (std::uint32_t n = 0; n < samples_each; ++n)
    for (const std::uint32_t i : order) {
      Sampler sampler(SamplerKind::sobol, seed, hash_combine(points.sequence[i], kBrightPatchStream),
                      points.sample[i] * samples_each + n);
      const Vec2 v = sampler.next2();
      const BrightPatches::Sample s = patches.sample(scene.geometry(), points.position[i], sampler.next1(), v);
      if (s.patch == kNone) continue;
      const Vec3 offset = s.position - points.position[i];
      const float squared = length_squared(offset);
      if (!(squared > 0)) continue;
      const Vec3 direction = offset / std::sqrt(squared);
      const ShadedSurface surface(points.bsdf[i], points.frame[i], points.normal[i]);
      const RGB scattered = surface.evaluate(points.wo[i], direction, kBroad);
      if (is_black(scattered)) continue;
      const Ray ray =
          leave_surface(points.position[i], face_forward(points.normal[i], direction), points.offset[i], direction, 0);
      const std::uint32_t triangle = patches.triangle(s.patch);
      const float cosine = std::abs(dot(scene.diffuse_triangle(triangle).normal, direction));
      if (!(cosine > 0)) continue;
      // Balance heuristic: f cos over the density of all samples.
      const float pdf_patch = s.density * squared / cosine;
      const float pdf_bsdf = surface.pdf(points.wo[i], direction, kBroad);
      const float together = static_cast<float>(samples_each) * pdf_patch + static_cast<float>(rays_each) * pdf_bsdf;
      GatherPath& path =
          add_gather_path(out, ray, points.throughput[i] * scattered * (1 / together), pdf_bsdf, i, rays_each + n);
      path.segment = Segment::to_patch;
      path.patch = s.patch;
    }
}

float patch_weight(const Scene& scene, const BrightPatches& patches, const GatherPath& path, const Hit& hit,
                   std::uint32_t rays_each, std::uint32_t samples_each) {
  const std::uint32_t patch = patches.find(hit.triangle, hit.barycentric);
  if (patch == kNone) return 1;
  const float density = patches.density(path.ray.origin, patch);
  const float cosine = std::abs(dot(scene.diffuse_triangle(hit.triangle).normal, path.ray.direction));
  if (!(density > 0) || !(cosine > 0)) return 1;
  return balance_heuristic(static_cast<float>(rays_each), path.pdf, static_cast<float>(samples_each),
                           density * hit.distance * hit.distance / cosine);
}

}  // namespace glowworm
