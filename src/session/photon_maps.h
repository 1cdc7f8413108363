// The photon maps of a session: traced, measured and indexed in steps, of which only those are redone whose input
// changed.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/statistics.h"
#include "density/engine.h"
#include "density/radius.h"
#include "gather/radius_grid.h"
#include "photon/photon_tracer.h"
#include "session/interrupt.h"
#include "trace/tracer.h"

namespace glowworm {

/// What maps are wanted. Light itself is not in it: whoever changes it calls PhotonMaps::forget().
struct PhotonMapSettings {
  std::uint64_t photons = 500'000;  ///< in the global map
  std::uint32_t nearest = 50;       ///< k: photons that an estimate should catch
  std::string engine = kAutomaticEngine;
  KernelShape kernel = KernelShape::epanechnikov;
  std::uint32_t seed = 0, pass = 0;  ///< name the photons
  float radius_scale = 1;            ///< factor on the radii
  bool corrected = false;            ///< makes up for kernels that reach over edges (render/boundary.h); seconds
  bool diagnosed = false;            ///< an index that counts photons, for false colours
  bool corners = false;              ///< wants radii()
  /// How emission is guided; null: by power alone. Two guides are the same where they are one object.
  std::shared_ptr<const EmissionGuide> guide;
};

/// What the diagnosing index sums for a query point of Lambertian reflectance pi: r photons per m^2, g the same times
/// their radii, b shader operations.
struct PhotonDiagnosis {
  float density = 0;            ///< photons per m^2
  float mean_radius = 0;        ///< metres; 0 where there is no photon
  float shader_operations = 0;  ///< photons within their radius
};
PhotonDiagnosis photon_diagnosis(RGB sum);

/// Global and caustic map, and engines over them.
class PhotonMaps {
 public:
  /// Brings the maps to what is wanted; does nothing where they are that already. Throws Cancelled where the interrupt
  /// is requested; steps that were done until then are kept.
  void update(const Tracer& tracer, const PhotonMapSettings& settings, const Interrupt& interrupt,
              Statistics& statistics);
  /// The light has changed: nothing may be kept.
  void forget();

  bool empty() const { return pass_.global.size() == 0; }
  const PhotonPass& photons() const { return pass_; }
  const DensityEngine& engine() const { return *engine_; }
  /// Over the caustic map; null where there are no caustics.
  const DensityEngine* caustic_engine() const { return caustic_engine_.get(); }
  /// Over counts instead of flux; null unless PhotonMapSettings::diagnosed.
  const DensityEngine* diagnosis() const { return diagnosis_.get(); }
  /// Radii by place, for the second gather in corners; up to date where PhotonMapSettings::corners.
  const RadiusGrid& radii() const { return radius_grid_; }
  /// Bytes of the photons, without the engines' indices.
  std::uint64_t bytes() const;

 private:
  void trace(const Tracer& tracer, Statistics& statistics);
  void measure(Statistics& statistics);
  void correct(const Tracer& tracer, Statistics& statistics);
  void index(Statistics& statistics);
  void diagnose(Statistics& statistics);
  void lay_grid(Statistics& statistics);
  RadiusPolicy global_policy() const;
  RadiusPolicy caustic_policy() const;

  PhotonMapSettings settings_;
  bool traced_ = false, measured_ = false, corrected_ = false, indexed_ = false, gridded_ = false;
  PhotonPass pass_;
  PhotonRadii radii_, caustic_radii_;             // for a radius_scale of 1
  std::vector<float> factors_, caustic_factors_;  // of correction
  std::unique_ptr<DensityEngine> engine_, caustic_engine_, diagnosis_;
  RadiusGrid radius_grid_;
};

}  // namespace glowworm
