// The public header glowworm/photons.h.
#include "glowworm/photons.h"

#include <utility>

#include "api/scene_implementation.h"
#include "photon/photon_tracer.h"

namespace glowworm::api {

struct Photons::Implementation {
  PhotonBatch batch;
  std::uint64_t emitted = 0;
};

namespace {
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
  Statistics statistics;
  PhotonPass pass = glowworm::trace_photons(*scene.implementation().tracer, settings, statistics);
  auto out = std::make_shared<Photons::Implementation>();
  out->batch = std::move(options.caustic ? pass.caustic : pass.global);
  out->emitted = pass.emitted;
  return Photons(std::move(out));
}

}  // namespace glowworm::api
