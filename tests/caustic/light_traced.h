// Caustics by light tracing, photon by photon: a reference without maps, kernels or final gathering.
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/offset_origin.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"
#include "scene/surface.h"
#include "trace/tracer.h"

namespace glowworm {

/// A square of a floor at y = 0, cut into pixels.
struct FloorSquare {
  float x = 0, z = 0;  ///< its middle, metres
  float side = 1;      ///< metres
  int pixels = 64;     ///< along a side
  double pixel_area() const { return static_cast<double>(side) * side / pixels / pixels; }
};

/// Radiant exitance by caustics (light, specular bounces, floor) of each pixel, W m^-2 of luminance.
struct FloorLight {
  std::vector<double> exitance;
  double flux = 0;            ///< W leaving the square
  double standard_error = 0;  ///< of the flux
};

/// Follows light paths [first, last) of `paths` from the emissive triangles to the first surface with a broad lobe;
/// those that had specular bounces alone, at least one, count at a diffuse floor. Returns the sum of squares in
/// standard_error.
inline FloorLight trace_caustic_paths(const Tracer& tracer, const FloorSquare& square, std::uint32_t first,
                                      std::uint32_t last, std::uint32_t paths) {
  const Scene& scene = tracer.scene();
  FloorLight out;
  out.exitance.assign(static_cast<std::size_t>(square.pixels) * static_cast<std::size_t>(square.pixels), 0);
  const auto& emitters = scene.emissive_triangles();
  double squares = 0;
  for (std::uint32_t i = first; i < last; ++i) {
    Sampler sampler(SamplerKind::independent, 99, 7, i);
    const auto number = static_cast<std::size_t>(sampler.next1() * static_cast<float>(emitters.size()));
    const std::uint32_t lamp = emitters[std::min(number, emitters.size() - 1)];
    const SurfacePoint start = surface_point(scene, lamp, square_to_triangle(sampler.next2()));
    const Vec3 n = start.geometric_normal;
    const RGB emitted = scene.emissions()[scene.geometry().emission[lamp]].radiance.value;
    double flux =
        luminance(emitted) * M_PI * scene.geometry().area(lamp) * static_cast<double>(emitters.size()) / paths;
    Ray ray{offset_origin(start.position, n, start.offset), 0,
            Frame::from_normal(n).to_world(square_to_cosine_hemisphere(sampler.next2())),
            std::numeric_limits<float>::infinity()};
    for (int bounce = 0; bounce < 64; ++bounce) {
      const Hit hit = tracer.intersect(ray);
      if (hit.triangle == kNone) break;
      SurfacePoint point = surface_point(scene, hit.triangle, hit.barycentric);
      const Bsdf bsdf = resolve_bsdf(scene, point);
      if (lobes(bsdf) & kBroad) {
        const double u = (point.position.x - square.x) / square.side + 0.5;
        const double v = (point.position.z - square.z) / square.side + 0.5;
        if (bounce == 0 || std::abs(point.position.y) > 1e-4f || u < 0 || u >= 1 || v < 0 || v >= 1) break;
        const double left = flux * luminance(bsdf.diffuse);
        const auto pixel = static_cast<std::size_t>(v * square.pixels) * static_cast<std::size_t>(square.pixels) +
                           static_cast<std::size_t>(u * square.pixels);
        out.exitance[pixel] += left / square.pixel_area();
        out.flux += left;
        squares += left * left;
        break;
      }
      const float u_lobe = sampler.next1();
      const BsdfSample s =
          sample(bsdf, point.frame.to_local(-ray.direction), u_lobe, sampler.next2(), kAllLobes, Transport::flux);
      if (!s.valid) break;
      flux *= luminance(s.weight);
      const Vec3 direction = point.frame.to_world(s.wi);
      const Vec3 side = dot(direction, point.geometric_normal) > 0 ? point.geometric_normal : -point.geometric_normal;
      ray = {offset_origin(point.position, side, point.offset), 0, direction, std::numeric_limits<float>::infinity()};
    }
  }
  out.standard_error = squares;
  return out;
}

/// The caustic of so many light paths, on all threads.
inline FloorLight trace_caustic(const Tracer& tracer, const FloorSquare& square, std::uint32_t paths) {
  constexpr std::uint32_t kChunks = 64;
  std::vector<FloorLight> parts(kChunks);
  parallel_for(0, kChunks, 1, [&](std::size_t chunk, std::size_t) {
    const auto begin = [&](std::uint64_t n) { return static_cast<std::uint32_t>(n * paths / kChunks); };
    parts[chunk] = trace_caustic_paths(tracer, square, begin(chunk), begin(chunk + 1), paths);
  });
  FloorLight out = parts.front();
  for (std::uint32_t chunk = 1; chunk < kChunks; ++chunk) {
    for (std::size_t i = 0; i < out.exitance.size(); ++i) out.exitance[i] += parts[chunk].exitance[i];
    out.flux += parts[chunk].flux;
    out.standard_error += parts[chunk].standard_error;
  }
  out.standard_error = std::sqrt(out.standard_error);
  return out;
}

}  // namespace glowworm
