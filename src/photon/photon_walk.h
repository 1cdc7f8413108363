// What light paths leave between surfaces: photons in media, and segments that pass points in air.
#pragma once
#include <vector>

#include "core/box.h"
#include "photon/light_paths.h"
#include "trace/tracer.h"
#include "transport/light_images.h"
#include "transport/medium.h"

namespace glowworm {

/// The box outside of which media that fill all space keep fewer photons: around surfaces, lamps without size that have
/// a place, and what the picture needs. Empty where there are no surfaces.
/// @param importance of the pass, or null
Box3 looked_at_box(const Scene& scene, const PhotonImportance* importance);

/// Takes the light paths of a pass from surface to surface.
class PhotonWalk {
 public:
  /// Both must outlive the walk.
  PhotonWalk(const Tracer& tracer, const PhotonPassSettings& pass);

  /// Takes a path to the next surface, or out of the scene, however often media scatter it on its way. It ends there if
  /// its throughput is black.
  /// @param hit of the path's ray; becomes that of its last ray @param bounce surfaces so far @param chunk takes what
  /// the path leaves, and its flux balance
  void cross(LightPath& path, Hit& hit, int bounce, PhotonChunk& chunk) const;

 private:
  void keep_part(const LightPath& path, const Hit& hit, const MediumSample& sample, bool arrives,
                 PhotonChunk& chunk) const;
  bool is_from_image(const LightPath& path) const;
  void keep_segment(const LightPath& path, MediumSpan piece, RGB flux, RGB absorption, PhotonChunk& chunk) const;
  void keep_weakened(const Medium& medium, const LightPath& path, float length, RGB weight, PhotonChunk& chunk) const;
  bool is_wanted_in_media(const LightPath& path) const;
  MediumSample cross_piece(const Medium* medium, LightPath& path, float length, Sampler& sampler,
                           PhotonChunk& chunk) const;
  void store(const Medium& medium, const LightPath& path, float length, RGB scattered, float u,
             PhotonChunk& chunk) const;
  float share_kept(const LightPath& path, const Medium& medium, Vec3 position) const;
  bool scatter(LightPath& path, float distance, float before, int bounce, Sampler& sampler, PhotonChunk& chunk) const;

  const Tracer& tracer_;
  const Scene& scene_;
  const PhotonPassSettings& pass_;
  const Box3 looked_at_;
  /// Of each light source those from which it brings no photons to discs, because rays find them; empty: from all.
  const std::vector<ImagedLight> images_;
  const bool crosses_media_;
  const bool names_media_;  // surfaces say which medium is around a path that they stop
};

}  // namespace glowworm
