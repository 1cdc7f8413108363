// The public header glowworm/density.h.
#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "density/engine.h"
#include "density/radius.h"
#include "glowworm/density.h"

namespace glowworm::api {

namespace {

// The public structs have the same layout as the private ones.
static_assert(sizeof(Vec3) == sizeof(glowworm::Vec3) && sizeof(Rgb) == sizeof(RGB));

glowworm::Vec3 inner(Vec3 v) { return {v.x, v.y, v.z}; }

void check_positions(std::span<const Vec3> position, const char* what) {
  for (std::size_t i = 0; i < position.size(); ++i)
    if (!is_finite(inner(position[i])))
      throw Error(std::string("the position of ") + what + " " + std::to_string(i) + " is not finite");
}

void check_length(std::size_t length, std::size_t wanted, const char* what) {
  if (length != wanted)
    throw Error(std::string("there are ") + std::to_string(length) + " " + what + " for " + std::to_string(wanted) +
                " positions");
}

/// Points of a lookup: enough of them lie close together, and their arrays stay small.
constexpr std::size_t kPointsAtOnce = std::size_t{1} << 21;

/// Direction of photons and points that have none: all normals agree.
constexpr glowworm::Vec3 kAnyNormal{0, 0, 1};

/// NaN fails, too.
void check_unit(std::span<const Vec3> normal, const char* what) {
  constexpr float kTolerance = 1e-3f;
  for (std::size_t i = 0; i < normal.size(); ++i)
    if (const float found = length(inner(normal[i])); !(std::abs(found - 1) <= kTolerance))
      throw Error(
          std::string("the normal of ") + what + " " + std::to_string(i) + " has length " + std::to_string(found),
          "Give unit vectors.");
}

void check_flux(std::span<const Rgb> flux) {
  for (std::size_t i = 0; i < flux.size(); ++i)
    if (!is_finite(RGB(flux[i].r, flux[i].g, flux[i].b)))
      throw Error("the flux of photon " + std::to_string(i) + " is not finite");
}

/// The private shapes are the same in the same order.
KernelShape shape_of(Kernel kernel) {
  if (static_cast<std::size_t>(kernel) >= std::size(kKernelShapes))
    throw Error("there is no kernel number " + std::to_string(static_cast<int>(kernel)),
                "Give a value of the enumeration Kernel.");
  return static_cast<KernelShape>(kernel);
}

PhotonBatch batch_of(const PhotonArrays& photons) {
  check_positions(photons.position, "photon");
  check_length(photons.flux.size(), photons.position.size(), "fluxes");
  if (!photons.normal.empty()) check_length(photons.normal.size(), photons.position.size(), "normals");
  check_flux(photons.flux);
  check_unit(photons.normal, "photon");
  PhotonBatch batch;
  batch.reserve(photons.position.size());
  for (std::size_t i = 0; i < photons.position.size(); ++i) {
    const glowworm::Vec3 normal = photons.normal.empty() ? kAnyNormal : inner(photons.normal[i]);
    batch.push_back(inner(photons.position[i]), normal, {photons.flux[i].r, photons.flux[i].g, photons.flux[i].b},
                    normal);
  }
  return batch;
}

}  // namespace

struct DensityIndex::Implementation {
  std::unique_ptr<DensityEngine> engine;
  std::size_t count = 0;
  bool normals = false;
  std::mutex mutex;
  std::vector<std::unique_ptr<QueryPoints>> idle;  ///< of calls that have ended: memory used before costs less

  /// The points of a call, with memory of an earlier call where there is some.
  std::unique_ptr<QueryPoints> take_points() {
    const std::lock_guard lock(mutex);
    if (idle.empty()) return std::make_unique<QueryPoints>();
    std::unique_ptr<QueryPoints> points = std::move(idle.back());
    idle.pop_back();
    return points;
  }
  void give_back(std::unique_ptr<QueryPoints> points) {
    const std::lock_guard lock(mutex);
    idle.push_back(std::move(points));
  }

  Implementation(const PhotonArrays& photons, RadiusPolicy policy, Kernel kernel, Engine asked)
      : count(photons.position.size()), normals(!photons.normal.empty()) {
    const EngineTraits& traits = engine_traits(engine_name(asked));
    if (traits.takes_nearest)
      throw Error(std::string("engine '") + traits.name + "' takes the nearest photons, whatever their radii",
                  "Choose another one.");
    engine = make_engine(traits.name);
    for (const float radius : policy.radii)
      if (!(radius > 0) || !std::isfinite(radius)) throw Error("a photon's radius must be greater than 0 and finite");
    policy.kernel = shape_of(kernel);
    Statistics statistics;
    const PhotonBatch batch = batch_of(photons);
    engine->build(batch, batch.flux, policy, statistics);
  }
};

std::vector<std::string> kernel_names() { return glowworm::kernel_names(); }

std::vector<std::string> engine_names() {
  std::vector<std::string> names = glowworm::engine_names();
  names.insert(names.begin(), "auto");
  return names;
}

std::vector<float> photon_radii(std::span<const Vec3> position, std::uint32_t k) {
  if (k == 0) throw Error("radii for 0 photons were asked for", "Ask for 1 or more.");
  const std::vector<Rgb> flux(position.size());
  return per_photon_radii(batch_of({position, flux, {}}), k);
}

DensityIndex::DensityIndex(const PhotonArrays& photons, float radius, Kernel kernel, Engine engine) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = radius;
  policy.radii.assign(photons.position.size(), radius);
  implementation_ = std::make_unique<Implementation>(photons, std::move(policy), kernel, engine);
}

DensityIndex::DensityIndex(const PhotonArrays& photons, std::span<const float> radii, Kernel kernel, Engine engine) {
  check_length(radii.size(), photons.position.size(), "radii");
  RadiusPolicy policy;
  policy.radii.assign(radii.begin(), radii.end());
  implementation_ = std::make_unique<Implementation>(photons, std::move(policy), kernel, engine);
}

DensityIndex::~DensityIndex() = default;
DensityIndex::DensityIndex(DensityIndex&&) noexcept = default;
DensityIndex& DensityIndex::operator=(DensityIndex&&) noexcept = default;

std::size_t DensityIndex::photon_count() const { return implementation_->count; }

std::vector<Rgb> DensityIndex::sum(std::span<const Vec3> position, std::span<const Vec3> normal) const {
  std::vector<Rgb> out(position.size());
  sum(position, normal, out);
  return out;
}

void DensityIndex::sum(std::span<const Vec3> position, std::span<const Vec3> normal, std::span<Rgb> out) const {
  check_length(out.size(), position.size(), "sums");
  check_positions(position, "point");
  if (!normal.empty()) check_length(normal.size(), position.size(), "normals");
  check_unit(normal, "point");
  const std::size_t count = position.size();
  std::fill(out.begin(), out.end(), Rgb{});
  // An index without photons does not know whether they have normals.
  if (photon_count() == 0) return;
  if (!normal.empty()) {
    if (!implementation_->normals)
      throw Error("points with normals are asked of photons without", "Give the photons normals, or leave both out.");
  } else if (implementation_->normals && !position.empty()) {
    throw Error("points without normals are asked of photons that have them", "Give normals to both or to neither.");
  }
  const auto* places = reinterpret_cast<const glowworm::Vec3*>(position.data());
  const auto* normals = reinterpret_cast<const glowworm::Vec3*>(normal.data());
  std::unique_ptr<QueryPoints> points = implementation_->take_points();
  Statistics statistics;
  for (std::size_t first = 0; first < count; first += kPointsAtOnce) {
    const std::size_t n = std::min(kPointsAtOnce, count - first);
    points->position.assign(places + first, places + first + n);
    if (normal.empty())
      points->normal.assign(n, kAnyNormal);
    else
      points->normal.assign(normals + first, normals + first + n);
    // With a Lambertian reflectance of pi the radiance is the sum itself.
    points->reflectance.assign(n, RGB(kPi));
    points->bsdf.assign(n, kLambertianQuery);
    implementation_->engine->estimate(*points, {reinterpret_cast<RGB*>(&out[first]), n}, statistics);
  }
  implementation_->give_back(std::move(points));
}

void set_threads(int threads) {
  constexpr int kMostThreads = 1024;  // as of --threads
  if (threads < 0 || threads > kMostThreads)
    throw Error(std::to_string(threads) + " threads were asked for",
                "Give 1 to " + std::to_string(kMostThreads) + ", or 0: one for each hardware thread.");
  set_thread_count(threads);
}

}  // namespace glowworm::api

namespace glowworm {

std::string engine_name(api::Engine engine) {
  const std::vector<std::string> names = api::engine_names();
  if (static_cast<std::size_t>(engine) >= names.size())
    throw Error("there is no engine number " + std::to_string(static_cast<int>(engine)),
                "Give a value of the enumeration Engine.");
  return names[static_cast<std::size_t>(engine)];
}

}  // namespace glowworm
