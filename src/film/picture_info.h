// Metadata of a render that its picture needs besides the film.
#pragma once
#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "film/earlier_frames.h"
#include "settings/settings.h"

namespace glowworm {

/// Everything but the film that make_image() needs, so that a picture can be made without the scene.
struct PictureInfo {
  RenderSettings settings;  ///< resolved
  std::string scene;        ///< its name
  float scale = 1;          ///< factor on the image, by the scene's file
  Vec3 origin;              ///< Scene::origin(), which positions and matrices are relative to
  double seconds = 0;       ///< wall time of the render
  /// What photons add to the square of the relative error (maps/photon_noise.h); 0 where that was not measured.
  double photon_variance = 0;
  /// Names of Geometry::objects and of the scene's materials; empty where no layer needs them.
  std::vector<std::string> objects, materials;
  std::vector<std::string> light_groups;                  ///< names of the film's groups of lights
  std::map<std::string, std::array<float, 16>> matrices;  ///< Image::matrices, relative to origin
  std::shared_ptr<const EarlierFrames> earlier;           ///< whose light the picture uses again; null: none
  std::string view;                                       ///< kRadianceView; empty: none
};

/// Whether a file may hold this number as PictureInfo::photon_variance.
inline bool is_variance(double value) { return value >= 0 && std::isfinite(value); }

}  // namespace glowworm
