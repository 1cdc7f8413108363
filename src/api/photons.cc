// The public header glowworm/photons.h.
#include "glowworm/photons.h"

#include <algorithm>
#include <string>
#include <utility>

#include "api/checks.h"
#include "api/scene_implementation.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "core/offset_origin.h"
#include "core/parallel.h"
#include "density/engine.h"
#include "gather/final_gather.h"
#include "maps/photon_maps.h"
#include "photon/photon_tracer.h"
#include "scene/surface.h"
#include "settings/settings.h"
#include "transport/vertex.h"

namespace glowworm::api {

struct Photons::Implementation {
  PhotonBatch batch;
  std::uint64_t emitted = 0;
};

namespace {

/// A scope for an interrupt that may be null.
class MaybeInterrupted {
 public:
  explicit MaybeInterrupted(const Interrupt* interrupt) : scope_(interrupt ? *interrupt : never_) {}

 private:
  Interrupt never_;
  CancellationScope scope_;
};

// The public structs have the same layout as the private ones.
static_assert(sizeof(Vec3) == sizeof(glowworm::Vec3) && sizeof(Rgb) == sizeof(RGB));
std::span<const Vec3> outer(const LargeVector<glowworm::Vec3>& v) {
  return {reinterpret_cast<const Vec3*>(v.data()), v.size()};
}
}  // namespace

Photons::Photons(std::shared_ptr<const Implementation> implementation) : implementation_(std::move(implementation)) {}

std::size_t Photons::size() const { return implementation_->batch.size(); }
std::span<const Vec3> Photons::positions() const { return outer(implementation_->batch.position); }
std::span<const Vec3> Photons::directions() const { return outer(implementation_->batch.direction); }
std::span<const Vec3> Photons::normals() const { return outer(implementation_->batch.normal); }
std::span<const Rgb> Photons::flux() const {
  const auto& flux = implementation_->batch.flux;
  return {reinterpret_cast<const Rgb*>(flux.data()), flux.size()};
}
std::uint64_t Photons::emitted() const { return implementation_->emitted; }

Photons trace_photons(const Scene& scene, const PhotonOptions& options) {
  PhotonPassSettings settings;
  settings.photons = options.photons;
  settings.seed = options.seed;
  if (options.caustic) settings.choice = PhotonChoice::caustic;
  settings.on_all_surfaces = true;
  Statistics statistics;
  const MaybeInterrupted scope(options.interrupt);
  PhotonPass pass = glowworm::trace_photons(*scene.implementation().tracer, settings, statistics);
  auto out = std::make_shared<Photons::Implementation>();
  out->batch = std::move(options.caustic ? pass.caustic : pass.global);
  out->emitted = pass.emitted;
  for (glowworm::Vec3& p : out->batch.position) p = narrow(scene.implementation().scene->outside(p));
  return Photons(std::move(out));
}

struct PhotonMap::Implementation {
  Implementation(const Scene& s, const PhotonMapOptions& options) : scene(s), budget(default_memory_bytes()) {
    if (options.photons == 0 || options.nearest == 0)
      throw Error("a photon map of no photons was asked for", "Ask for 1 or more, and for estimates of 1 or more.");
    PhotonMapSettings settings;
    settings.photons = options.photons;
    settings.seed = options.seed;
    settings.nearest = options.nearest;
    if (static_cast<std::size_t>(options.kernel) >= std::size(kKernelShapes))
      throw Error("there is no kernel number " + std::to_string(static_cast<int>(options.kernel)),
                  "Give a value of the enumeration Kernel.");
    settings.kernel = static_cast<KernelShape>(options.kernel);
    settings.engine = engine_traits(engine_name(options.engine)).name;
    if (options.boundary_correction) settings.correction = BoundaryCorrection::estimates;
    settings.kept = false;
    settings.on_all_surfaces = true;
    Statistics statistics;
    const MaybeInterrupted scope(options.interrupt);
    maps.update(tracer(), settings, statistics);
  }

  const glowworm::Tracer& tracer() const { return *scene.implementation().tracer; }

  /// Sums of the engine's estimates. A point may have several query points; QueryPoints::gather_point is its index.
  std::vector<Rgb> estimate(const QueryPoints& queries, std::size_t points) const {
    std::vector<Rgb> out(points);
    // Without photons there is no light, and no engine.
    if (maps.empty()) return out;
    std::vector<RGB> found(queries.size());
    Statistics statistics;
    maps.engines().front()->estimate(queries, found, statistics);
    maps.correct(tracer(), queries, found);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      Rgb& sum = out[queries.gather_point[i]];
      sum = {sum.r + found[i].r, sum.g + found[i].g, sum.b + found[i].b};
    }
    return out;
  }

  Scene scene;
  MemoryBudget budget;
  PhotonMaps maps{budget};
};

namespace {

void check_points(std::span<const Vec3> position, std::span<const Vec3> normal) {
  check_lengths(normal.size(), position.size(), "normals", "points");
  check_finite(position, "point");
  check_unit(normal, "normal");
}

/// The first hit of each point's ray from its normal's side back on the point. Throws Error for a point that is not on
/// a surface.
std::vector<Hit> surfaces_at(const glowworm::Tracer& tracer, std::span<const Vec3> position,
                             std::span<const Vec3> normal) {
  const glowworm::Scene& scene = tracer.scene();
  // How far from a surface a point may lie.
  const float reach = std::max(1e-4f * scene.radius(), position_rounding(scene.origin()));
  std::vector<Hit> hits(position.size());
  constexpr std::size_t kBlock = 1024;
  parallel_for(0, position.size(), kBlock, [&](std::size_t first, std::size_t last) {
    std::vector<Ray> rays;
    for (std::size_t i = first; i < last; ++i) {
      const glowworm::Vec3 n = normalize(inner(normal[i]));
      rays.push_back({scene.inside(inner(position[i])) + n * reach, 0, -n, 2 * reach});
    }
    tracer.intersect(rays, std::span(hits).subspan(first, last - first), RayOrder::incoherent);
  });
  for (std::size_t i = 0; i < hits.size(); ++i)
    if (hits[i].triangle == kNone)
      throw Error("point " + std::to_string(i) + " is not on a surface of the scene",
                  "Give places where rays hit; irradiance() takes any point.");
  return hits;
}

}  // namespace

PhotonMap::PhotonMap(const Scene& scene, const PhotonMapOptions& options)
    : implementation_(std::make_shared<const Implementation>(scene, options)) {}

std::size_t PhotonMap::size() const { return implementation_->maps.global_count(); }
std::uint64_t PhotonMap::emitted() const { return implementation_->maps.pass().emitted; }

std::vector<Rgb> PhotonMap::irradiance(std::span<const Vec3> position, std::span<const Vec3> normal) const {
  check_points(position, normal);
  const glowworm::Scene& scene = implementation_->tracer().scene();
  QueryPoints queries;
  queries.reserve(position.size());
  // With a Lambertian reflectance of pi the radiance is the irradiance.
  for (std::size_t i = 0; i < position.size(); ++i)
    queries.push_back(scene.inside(inner(position[i])), normalize(inner(normal[i])), RGB(kPi), RGB(1.0f),
                      static_cast<std::uint32_t>(i));
  return implementation_->estimate(queries, position.size());
}

std::vector<Rgb> PhotonMap::radiance(std::span<const Vec3> position, std::span<const Vec3> normal) const {
  check_points(position, normal);
  const glowworm::Tracer& tracer = implementation_->tracer();
  const std::vector<Hit> hits = surfaces_at(tracer, position, normal);
  QueryPoints queries;
  queries.reserve(position.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const glowworm::Vec3 towards = normalize(inner(normal[i]));
    Vertex vertex{surface_point(tracer.scene(), hits[i].triangle, hits[i].barycentric), towards, {}};
    vertex.bsdf = resolve_bsdf(tracer.scene(), vertex.point);
    add_query(queries, vertex, RGB(1.0f), static_cast<std::uint32_t>(i));
  }
  return implementation_->estimate(queries, position.size());
}

}  // namespace glowworm::api
