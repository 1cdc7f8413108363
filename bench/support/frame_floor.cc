#include "support/frame_floor.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <utility>

#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"
#include "density/engine.h"
#include "density/radius.h"
#include "gather/camera_pass.h"
#include "gather/gather_rays.h"
#include "kernels/sobol.h"
#include "photon/emission_block.h"
#include "photon/photon_tracer.h"
#include "points/query_points.h"
#include "scene/surface.h"
#include "session/frame_pass.h"
#include "support/table.h"

namespace glowworm::bench {

namespace {

/// Rays that are traced at once, and numbers that are made at once.
constexpr std::size_t kAtOnce = 4096;
/// Runs of what is measured once for all frames; the least counts.
constexpr int kRuns = 5;
/// k of a session.
constexpr std::uint32_t kNearest = 50;
/// Factor on radii with which no photon is found.
constexpr float kNearlyNothing = 1e-4f;
/// Cells along the longest side of the photons' box, and photons that one piece of work moves.
constexpr std::uint32_t kCells = 32;
constexpr std::size_t kMovedAtOnce = 65536;

template <typename Work>
double least_seconds(Work&& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) least = std::min(least, work());
  return least;
}

double seconds_of(const std::function<void()>& work) { return measure_seconds(1, work).median; }

void intersect(const Tracer& tracer, const std::vector<Ray>& rays, std::vector<Hit>& hits, RayOrder order) {
  parallel_for(0, rays.size(), kAtOnce, [&](std::size_t first, std::size_t last) {
    tracer.intersect(std::span(rays).subspan(first, last - first), std::span(hits).subspan(first, last - first), order);
  });
}

void look_up(const Scene& scene, const std::vector<Hit>& hits) {
  parallel_for(0, hits.size(), kAtOnce, [&](std::size_t first, std::size_t last) {
    Vec3 sum{0, 0, 0};
    for (std::size_t i = first; i < last; ++i) {
      fetch_ahead<false>(scene, i, last, [&](std::size_t at) { return hits[at].triangle; });
      DiffusePoint point;
      if (hits[i].triangle == kNone || !diffuse_point(scene, hits[i].triangle, hits[i].barycentric, point)) continue;
      sum += point.position + point.geometric_normal;
      sum.x += point.reflectance.r;
    }
    // Else the compiler might leave all of it out.
    [[maybe_unused]] const volatile float kept = sum.x + sum.y + sum.z;
  });
}

/// Places, normals, photons and the directions in which paths go on, by the vector kernel.
void scatter(const Scene& scene, const std::vector<Ray>& rays, const std::vector<Hit>& hits,
             const std::vector<float>& numbers) {
  parallel_for(0, rays.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    const auto block = std::make_unique<DiffuseHits>();
    float sum = 0;
    for (std::size_t first = begin; first < end; first += DiffuseHits::kBlock) {
      const std::size_t count = std::min(DiffuseHits::kBlock, end - first);
      // All blocks take the same numbers: making these is counted by itself.
      ArrivedPaths paths;
      paths.roulette = paths.square[0] = paths.square[1] = numbers.data();
      for (const float*& flux : paths.flux) flux = numbers.data();
      block->scatter(scene, std::span(rays).subspan(first, count), std::span(hits).subspan(first, count), 0, count,
                     paths);
      sum += block->position(0).x + block->direction(count - 1).x;
    }
    [[maybe_unused]] const volatile float kept = sum;
  });
}

/// Photons and query points in one spot: all are within the support of all.
double measure_operation() {
  constexpr std::size_t kPhotons = 4096, kPoints = 32768;
  PhotonBatch photons;
  QueryPoints points;
  const auto place = [](std::uint32_t i, std::uint32_t stream) {
    Sampler sampler(SamplerKind::sobol, 0, stream, i);
    const Vec2 u = sampler.next2();
    return Vec3{0.1f * u.x, 0.1f * u.y, 0};
  };
  const Vec3 up{0, 0, 1};
  for (std::uint32_t i = 0; i < kPhotons; ++i) photons.push_back(place(i, 0), up, RGB(1.0f), up);
  for (std::uint32_t i = 0; i < kPoints; ++i) points.push_back(place(i, 1), up, RGB(1.0f), RGB(1.0f), i);
  RadiusPolicy policy;
  policy.kind = RadiusKind::per_photon;
  policy.radii.assign(kPhotons, 1.0f);
  const auto engine = make_engine("blocked");
  Statistics building;
  engine->build(photons, policy, building);
  std::vector<RGB> radiance(kPoints);
  return least_seconds([&] {
    Statistics statistics;
    engine->estimate(points, radiance, statistics);
    return statistics.seconds(Phase::density) / static_cast<double>(statistics.count(Counter::shader_operations));
  });
}

/// Arrays beyond the caches, copied in order.
double measure_byte() {
  constexpr std::size_t kBytes = std::size_t{128} << 20, kPiece = std::size_t{1} << 20;
  std::vector<char> from(kBytes, 1), to(kBytes, 2);
  return least_seconds([&] {
    return seconds_of([&] {
             parallel_for(0, kBytes, kPiece, [&](std::size_t first, std::size_t last) {
               std::memcpy(&to[first], &from[first], last - first);
             });
           }) /
           static_cast<double>(kBytes);
  });
}

}  // namespace

FrameFloor::FrameFloor(const Tracer& tracer, const Camera& camera, int side, std::uint64_t photons)
    : tracer_(tracer), photons_(photons), seconds_an_operation_(measure_operation()), seconds_a_byte_(measure_byte()) {
  PhotonPassSettings settings;
  settings.photons = photons;
  Statistics statistics;
  PhotonPass pass = trace_photons(tracer, settings, statistics);
  emitted_ = pass.emitted;
  for (std::size_t i = 0; i < pass.global.size(); ++i) {
    Sampler sampler(SamplerKind::sobol, 0, 0, static_cast<std::uint32_t>(i));
    const Vec3 p = pass.global.position[i], n = pass.global.normal[i];
    photon_rays_.push_back({offset_origin(p, n, position_rounding(p)), 0,
                            Frame::from_normal(n).to_world(square_to_cosine_hemisphere(sampler.next2())),
                            std::numeric_limits<float>::infinity()});
  }
  map_ = std::move(pass.global);
  RadiusPolicy policy;
  policy.radii = per_photon_radii(map_, kNearest);
  for (float& radius : policy.radii) radius *= kNearlyNothing;
  empty_ = make_engine("blocked");
  empty_->build(map_, policy, statistics);
  Sampler sampler(SamplerKind::independent, 0, 1, 0);
  for (std::size_t i = 0; i < DiffuseHits::kBlock + kDiffuseScatterPadding; ++i) numbers_.push_back(sampler.next1());
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const CameraRay ray =
          generate_ray(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f}, side, side, {0.5f, 0.5f});
      camera_rays_.push_back({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
    }
  CameraPassSettings camera_settings;
  camera_settings.width = camera_settings.height = side;
  SlotRadiance radiance;
  FirstHit first_hit;
  points_ = camera_pass(tracer, camera, {0, 0, side, side, 0, 1}, camera_settings, radiance, first_hit, statistics);
}

void FrameFloor::choose_gather(std::uint32_t rays_each) {
  rays_each_ = rays_each;
  gather_rays_.clear();
  orders_.clear();
  if (rays_each > 0) make_gather_rays();
  make_queries();
}

void FrameFloor::make_gather_rays() {
  // In the portions and the order in which final gathering traces them.
  const std::size_t portion = std::max<std::size_t>(1, 32768 / rays_each_);
  GatherRays rays;
  for (std::size_t first = 0; first < points_.size(); first += portion) {
    orders_.emplace_back();
    coherent_order(points_, first, std::min(first + portion, points_.size()), orders_.back());
    GatherRayMaker maker;
    maker.prepare(points_, orders_.back(), rays_each_, 0);
    rays.clear();
    maker.create(0, rays_each_, rays);
    gather_rays_.insert(gather_rays_.end(), rays.rays.begin(), rays.rays.end());
  }
}

void FrameFloor::make_queries() {
  rays(false);
  const bool gathers = !gather_rays_.empty();
  const std::vector<Ray>& from = gathers ? gather_rays_ : camera_rays_;
  const std::vector<Hit>& hits = gathers ? gather_hits_ : camera_hits_;
  const std::size_t portions = (hits.size() + kQueriesAtOnce - 1) / kQueriesAtOnce;
  queries_.assign(portions, {});
  for (std::size_t i = 0; i < hits.size(); ++i) {
    DiffusePoint point;
    if (hits[i].triangle == kNone || !diffuse_point(tracer_.scene(), hits[i].triangle, hits[i].barycentric, point))
      continue;
    queries_[i * portions / hits.size()].push_back(
        point.position, face_forward(point.geometric_normal, -from[i].direction), point.reflectance, RGB(1.0f), 0);
  }
}

double FrameFloor::search() const {
  double seconds = 0;
  for (const QueryPoints& queries : queries_) {
    Statistics statistics;
    std::vector<RGB> radiance(queries.size());
    seconds += seconds_of([&] { empty_->estimate(queries, radiance, statistics); });
  }
  return seconds;
}

double FrameFloor::map() {
  const std::size_t n = map_.size(), pieces = (n + kMovedAtOnce - 1) / kMovedAtOnce;
  constexpr std::size_t kAllCells = std::size_t{kCells} * kCells * kCells;
  if (moved_.size() < n) moved_ = LargeArray<Row>(n);
  cell_.resize(n);
  return seconds_of([&] {
    std::vector<Box3> parts(pieces);
    parallel_for(0, n, kMovedAtOnce, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) parts[first / kMovedAtOnce].grow(map_.position[i]);
    });
    Box3 box;
    for (const Box3& part : parts) box.grow(part);
    const Vec3 d = box.diagonal();
    const float scale = kCells * (1 - 1e-6f) / std::max({d.x, d.y, d.z, 1e-6f});
    places_.assign(pieces * kAllCells, 0);
    parallel_for(0, n, kMovedAtOnce, [&](std::size_t first, std::size_t last) {
      std::uint32_t* const count = &places_[first / kMovedAtOnce * kAllCells];
      for (std::size_t i = first; i < last; ++i) {
        const Vec3 p = (map_.position[i] - box.min) * scale;
        cell_[i] = (static_cast<std::uint32_t>(p.x) * kCells + static_cast<std::uint32_t>(p.y)) * kCells +
                   static_cast<std::uint32_t>(p.z);
        ++count[cell_[i]];
      }
    });
    std::uint32_t place = 0;
    for (std::size_t cell = 0; cell < kAllCells; ++cell)
      for (std::size_t piece = 0; piece < pieces; ++piece) {
        std::uint32_t& of_piece = places_[piece * kAllCells + cell];
        place += std::exchange(of_piece, place);
      }
    parallel_for(0, n, kMovedAtOnce, [&](std::size_t first, std::size_t last) {
      std::uint32_t* const places = &places_[first / kMovedAtOnce * kAllCells];
      for (std::size_t i = first; i < last; ++i)
        moved_[places[cell_[i]]++] = {map_.position[i], map_.normal[i], map_.direction[i], map_.flux[i]};
    });
  });
}

double FrameFloor::rays(bool anew) {
  photon_hits_.resize(photon_rays_.size());
  camera_hits_.resize(camera_rays_.size());
  gather_hits_.resize(gather_rays_.size());
  return seconds_of([&] {
    if (anew) intersect(tracer_, photon_rays_, photon_hits_, RayOrder::incoherent);
    intersect(tracer_, camera_rays_, camera_hits_, RayOrder::coherent);
    intersect(tracer_, gather_rays_, gather_hits_, RayOrder::incoherent);
  });
}

double FrameFloor::surfaces(bool anew) const {
  return seconds_of([&] {
    if (anew) scatter(tracer_.scene(), photon_rays_, photon_hits_, numbers_);
    look_up(tracer_.scene(), camera_hits_);
    look_up(tracer_.scene(), gather_hits_);
  });
}

double FrameFloor::emission() const {
  return seconds_of([&] {
    parallel_for(0, static_cast<std::size_t>(emitted_), kAtOnce, [&](std::size_t begin, std::size_t end) {
      const auto block = std::make_unique<EmissionBlock>();
      float sum = 0;
      for (std::size_t first = begin; first < end; first += EmissionBlock::kBlock) {
        const std::size_t count = std::min(EmissionBlock::kBlock, end - first);
        for (std::size_t i = 0; i < count; ++i)
          block->set_numbers(i, {numbers_[i], numbers_[i + 1], numbers_[i + 2], numbers_[i + 3], numbers_[i + 4]}, 1);
        block->emit(tracer_.scene(), count);
        sum += block->origin(0).x + block->direction(count - 1).x;
      }
      [[maybe_unused]] const volatile float kept = sum;
    });
  });
}

double FrameFloor::numbers(bool anew) const {
  const auto pairs = static_cast<std::size_t>(3 * emitted_ + 2 * photons_);
  return seconds_of([&] {
    parallel_for(0, orders_.size(), 1, [&](std::size_t i, std::size_t) {
      static thread_local GatherRays rays;
      static thread_local GatherRayMaker maker;
      rays.clear();
      maker.prepare(points_, orders_[i], rays_each_, 0);
      maker.create(0, rays_each_, rays);
    });
    if (!anew) return;
    parallel_for(0, pairs, kAtOnce, [&](std::size_t first, std::size_t last) {
      std::uint32_t index[kAtOnce];
      float x[kAtOnce], y[kAtOnce];
      for (std::size_t i = 0; i < last - first; ++i) index[i] = static_cast<std::uint32_t>(first + i);
      sobol_pairs(Sampler::pair_key(0, 0, 0), index, last - first, x, y);
    });
  });
}

double FrameFloor::bytes(std::uint64_t query_points, bool anew) const {
  const std::uint64_t moved = query_points * QueryPoints::kBytesEach + (anew ? photons_ * PhotonBatch::kBytesEach : 0);
  return seconds_a_byte_ * static_cast<double>(moved);
}

}  // namespace glowworm::bench
