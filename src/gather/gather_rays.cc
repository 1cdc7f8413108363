#include "gather/gather_rays.h"

#include <algorithm>
#include <cmath>

#include "core/offset_origin.h"
#include "core/random.h"
#include "core/warp.h"
#include "kernels/diffuse_rays.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

/// Share of the guided density in weights against light samples. Guided rays meet a lamp by chance; light samples miss
/// it only where something is in the way. So light samples keep more weight than the densities alone would give them.
constexpr float kGuidedWeight = 0.25f;

/// The cells into which the square of directions is divided: columns * rows = count, as nearly square as possible.
struct Strata {
  std::uint32_t columns, rows;
  explicit Strata(std::uint32_t count) : columns(1), rows(count) {
    for (std::uint32_t c = 1; c * c <= count; ++c)
      if (count % c == 0) columns = c;
    rows = count / columns;
    // A prime count has no factors near its square root, and one long row would stratify badly: use no cells.
    if (columns * 4 < rows) columns = rows = 0;
  }
  bool usable() const { return columns > 0; }
};

/// The random numbers of the rays of one stratum.
DiffuseRayCell numbers_of_cell(std::uint32_t rays_each, std::uint32_t cell, std::uint32_t seed) {
  const Strata strata(rays_each);
  DiffuseRayCell numbers;
  numbers.seed = seed;
  if (!strata.usable()) {
    numbers.sequence_salt = kGatherStream;
    numbers.sample_stride = rays_each;
    numbers.sample_offset = cell;
    return numbers;
  }
  numbers.sequence_salt = cell;
  numbers.side[0] = 1 / static_cast<float>(strata.columns);
  numbers.side[1] = 1 / static_cast<float>(strata.rows);
  numbers.low[0] = static_cast<float>(cell % strata.columns) * numbers.side[0];
  numbers.low[1] = static_cast<float>(cell / strata.columns) * numbers.side[1];
  return numbers;
}

/// Cell of a unit vector in a grid of 2^bits x 2^bits over the octahedron (Cigolle et al., "A Survey of Efficient
/// Representations for Independent Unit Vectors", JCGT 3(2), 2014).
std::uint32_t octahedral_cell(Vec3 d, int bits) {
  const float scale = 1 / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  float x = d.x * scale, y = d.y * scale;
  if (d.z < 0) {
    const float folded = (1 - std::abs(y)) * std::copysign(1.0f, x);
    y = (1 - std::abs(x)) * std::copysign(1.0f, y);
    x = folded;
  }
  const int side = 1 << bits;
  const auto along = [&](float v) {
    return static_cast<std::uint32_t>(
        std::clamp(static_cast<int>((v + 1) * 0.5f * static_cast<float>(side)), 0, side - 1));
  };
  return along(y) << bits | along(x);
}

}  // namespace

GatherDensity::GatherDensity(const GatherPoints& points, std::size_t point, const GatherGuide* guide)
    : points_(&points), guide_(guide), point_(point) {
  const Bsdf& bsdf = points.bsdf[point];
  if (!guide || guide->empty() || !GatherGuide::guides(bsdf)) return;
  const Vec3 normal = face_forward(points.frame[point].n, points.normal[point]);
  region_ = guide->region(points.position[point], normal);
  if (region_ == kNone) return;
  frame_ = GatherGuide::frame(normal);
  view_ = ShadedSurface(bsdf, points.frame[point], points.normal[point]).local_view(points.wo[point]);
  if (is_lambertian(bsdf)) return;
  const float diffuse = luminance(albedo(bsdf, view_, kDiffuseReflection)),
              all = luminance(albedo(bsdf, view_, kBroad));
  diffuse_share_ = all > 0 ? std::min(diffuse / all, 1.0f) : 1.0f;
}

float GatherDensity::guided_pdf(Vec3 w) const {
  const Vec3 local = frame_.to_local(w);
  float sum = 0;
  if (local.z > 0)
    sum =
        diffuse_share_ * cosine_hemisphere_pdf(local.z) * guide_->density(region_, disk_to_square({local.x, local.y}));
  if (diffuse_share_ < 1)
    sum +=
        (1 - diffuse_share_) * glowworm::pdf(points_->bsdf[point_], view_, points_->frame[point_].to_local(w), kGlossy);
  return sum;
}

float GatherDensity::weighing_pdf(Vec3 direction) const {
  const Vec3 side = points_->normal[point_];
  const float even =
      ShadedSurface(points_->bsdf[point_], points_->frame[point_], side).pdf(points_->wo[point_], direction, kBroad);
  const float cosine = dot(direction, side);
  if (region_ == kNone || !(cosine > 0)) return even;
  const Vec3 mirrored = direction - side * (2 * cosine);
  const float guided = guided_pdf(direction) + (dot(mirrored, frame_.n) > 0 ? guided_pdf(mirrored) : 0.0f);
  return std::lerp(even, guided, kGuidedWeight);
}

void coherent_order(const GatherPoints& points, std::size_t first, std::size_t last,
                    std::vector<std::uint32_t>& order) {
  constexpr int kNormalBits = 5;
  std::vector<std::uint64_t> keys;
  keys.reserve(last - first);
  for (std::size_t i = first; i < last; ++i) {
    const Frame& frame = points.frame[i];
    // A stratum is a cell of directions around the normal on the viewer's side.
    const bool below = dot(points.normal[i], frame.n) < 0;
    const std::uint64_t cell = octahedral_cell(below ? -frame.n : frame.n, kNormalBits);
    keys.push_back(cell << 32 | i);
  }
  std::sort(keys.begin(), keys.end());
  order.clear();
  for (const std::uint64_t key : keys) order.push_back(static_cast<std::uint32_t>(key));
}

void GatherRayMaker::prepare(const GatherPoints& points, std::span<const std::uint32_t> order, std::uint32_t rays_each,
                             std::uint32_t seed, const GatherGuide* guide) {
  points_ = &points;
  guide_ = guide && !guide->empty() ? guide : nullptr;
  order_ = order;
  rays_each_ = rays_each;
  seed_ = seed;
  const std::size_t padded = order.size() + kDiffuseRayPadding;
  sequence_.resize(padded);
  sample_.resize(padded);
  for (auto* arrays : {&normal_, &direction_})
    for (std::vector<float>& array : *arrays) array.resize(padded);
  for (std::vector<float>& array : frame_) array.resize(padded);
  cosine_.resize(padded);
  for (std::vector<float>& array : square_) array.resize(padded);
  region_.assign(order.size(), kNone);
  factor_.assign(order.size(), 1.0f);
  origin_.resize(order.size());
  weight_.resize(order.size());
  diffuse_.resize(order.size());
  density_.resize(order.size());
  first_point_ = order.empty() ? 0 : *std::min_element(order.begin(), order.end());
  any_square_ = false;
  for (std::size_t place = 0; place < order.size(); ++place) {
    const std::uint32_t i = order[place];
    diffuse_[place] = is_lambertian(points.bsdf[i]);
    density_[i - first_point_] = GatherDensity(points, i, guide_);
    region_[place] = density_[i - first_point_].region();
    sequence_[place] = points.sequence[i];
    sample_[place] = points.sample[i];
    if (diffuse_[place]) prepare_diffuse(place);
    any_square_ |= diffuse_[place] || region_[place] != kNone;
  }
}

void GatherRayMaker::prepare_diffuse(std::size_t place) {
  const std::uint32_t i = order_[place];
  const Frame frame = GatherGuide::frame(face_forward(points_->frame[i].n, points_->normal[i]));
  const Vec3 axes[3] = {frame.s, frame.t, frame.n};
  const RGB reflectance = points_->bsdf[i].diffuse;
  // A black surface has no rays: if the normal is zero, no direction is on its side.
  const Vec3 normal = max_component(reflectance) > 0 ? points_->normal[i] : Vec3{0, 0, 0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t which = 0; which < 3; ++which) frame_[3 * which + axis][place] = axes[which][axis];
    normal_[axis][place] = normal[axis];
  }
  origin_[place] = offset_origin(points_->position[i], points_->normal[i], points_->offset[i]);
  weight_[place] = points_->throughput[i] * reflectance * (1.0f / static_cast<float>(rays_each_));
}

void GatherRayMaker::create(std::uint32_t first, std::uint32_t last, GatherPaths& out) {
  DiffuseRayPoints points{order_.size(), sequence_.data(), sample_.data(), {}, {}};
  for (std::size_t i = 0; i < 9; ++i) points.frame[i] = frame_[i].data();
  for (std::size_t i = 0; i < 3; ++i) points.normal[i] = normal_[i].data();
  const DiffuseRays made{{direction_[0].data(), direction_[1].data(), direction_[2].data()}, cosine_.data()};
  const DiffuseSquare square{square_[0].data(), square_[1].data()};
  out.reserve(out.size() + order_.size() * (last - first));
  for (std::uint32_t cell = first; cell < last; ++cell) {
    if (any_square_) {
      diffuse_squares(points, numbers_of_cell(rays_each_, cell, seed_), square);
      if (guide_) guide_->warp(region_, square, factor_.data());
      diffuse_rays(points, square, made);
    }
    for (std::size_t place = 0; place < order_.size(); ++place) {
      if (!diffuse_[place])
        region_[place] == kNone ? add_other(place, cell, out) : add_guided(place, cell, out);
      else if (cosine_[place] > 0)
        add_gather_path(out, diffuse_ray(place), weight_[place] * factor_[place], cosine_hemisphere_pdf(cosine_[place]),
                        order_[place], cell);
    }
  }
}

Ray GatherRayMaker::diffuse_ray(std::size_t place) const {
  const Vec3 direction{direction_[0][place], direction_[1][place], direction_[2][place]};
  return {origin_[place], 0, direction, std::numeric_limits<float>::infinity()};
}

/// Adds one ray of a point with any BSDF.
void GatherRayMaker::add_other(std::size_t place, std::uint32_t cell, GatherPaths& out) const {
  const GatherPoints& points = *points_;
  const std::uint32_t i = order_[place];
  const Vec2 in_cell = gather_square(points.sequence[i], points.sample[i], rays_each_, cell, seed_);
  const ShadedSurface surface(points.bsdf[i], points.frame[i], points.normal[i]);
  const ScatteredRay s =
      surface.sample(points.wo[i], gather_ray_number(points, i, cell, seed_, kLobeStream), in_cell, kBroad);
  if (!s.valid || is_black(s.weight)) return;
  const Ray ray = leave_surface(points.position[i], s.side, points.offset[i], s.direction, 0);
  add_gather_path(out, ray, points.throughput[i] * s.weight * (1.0f / static_cast<float>(rays_each_)), s.pdf, i, cell);
}

/// Adds one ray of a point that reflects diffusely and otherwise. Both kinds of rays together have one density, so that
/// no weight has a peak where the other kind is likely. Directions are those of the BSDF, before those on the wrong
/// side of the surface are mirrored (bsdf/shaded_surface.h).
void GatherRayMaker::add_guided(std::size_t place, std::uint32_t cell, GatherPaths& out) const {
  const GatherPoints& points = *points_;
  const std::uint32_t i = order_[place];
  const Bsdf& bsdf = points.bsdf[i];
  const Frame& frame = points.frame[i];
  const Vec3 side = points.normal[i];
  const ShadedSurface surface(bsdf, frame, side);
  const GatherDensity& density = this->density(i);
  const float share = density.diffuse_share(), u = gather_ray_number(points, i, cell, seed_, kLobeStream);
  Vec3 w;
  if (u < share) {
    w = density.frame().to_world(square_to_cosine_hemisphere({square_[0][place], square_[1][place]}));
  } else {
    const Vec2 in_cell = gather_square(points.sequence[i], points.sample[i], rays_each_, cell, seed_);
    const BsdfSample s = sample(bsdf, density.view(), (u - share) / (1 - share), in_cell, kGlossy, Transport::radiance);
    if (!s.valid) return;
    w = frame.to_world(s.wi);
  }
  const Vec3 local = frame.to_local(w);
  const RGB weight = evaluate(bsdf, density.view(), local, kBroad) * (std::abs(local.z) / density.guided_pdf(w));
  if (!is_finite(weight) || is_black(weight)) return;
  const float behind = std::min(dot(w, side), 0.0f);
  const Vec3 direction = w - side * (2 * behind);
  add_gather_path(out, leave_surface(points.position[i], side, points.offset[i], direction, 0),
                  points.throughput[i] * weight * (1.0f / static_cast<float>(rays_each_)),
                  surface.pdf(points.wo[i], direction, kBroad), i, cell);
}

Vec2 gather_square(std::uint32_t sequence, std::uint32_t sample, std::uint32_t rays_each, std::uint32_t cell,
                   std::uint32_t seed) {
  const DiffuseRayCell numbers = numbers_of_cell(rays_each, cell, seed);
  Sampler sampler(SamplerKind::sobol, seed, hash_combine(sequence, numbers.sequence_salt),
                  sample * numbers.sample_stride + numbers.sample_offset);
  const Vec2 u = sampler.next2();
  return {u.x * numbers.side[0] + numbers.low[0], u.y * numbers.side[1] + numbers.low[1]};
}

float gather_ray_number(const GatherPoints& points, std::size_t point, std::uint32_t stratum, std::uint32_t seed,
                        std::uint32_t what) {
  const std::uint32_t key = hash_combine(hash_combine(seed ^ what, points.sequence[point]), stratum);
  return to_unit_float(hash_combine(key, points.sample[point]));
}

}  // namespace glowworm
