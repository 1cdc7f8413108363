// From the film of a bake to the numbers of textures.
#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "bake/layout.h"
#include "film/film.h"
#include "settings/settings.h"

namespace glowworm {

/// Quantity of a baked texture.
enum class TexelLight {
  irradiance,  ///< W m^-2; where light comes through, what the base colour of the file is multiplied by to show it
  radiance,    ///< of a diffuse surface: albedo times irradiance over pi, and what it emits, W sr^-1 m^-2
  tint         ///< what the base colour of the file is multiplied by to show that: radiance times pi over it, W m^-2
};

/// A quantity, and the kind of file that shows it.
struct ShownLight {
  TexelLight what = TexelLight::radiance;
  bool keeps_source = false;  ///< the file is a glTF file with light (base_color())
  ShownLight(TexelLight quantity, bool is_gltf = false) : what(quantity), keeps_source(is_gltf) {}
};

/// Irradiance of texels as Jobs compute it, one entry for each of layout.texels. For translucent surfaces, the mean of
/// both sides by share_from_behind().
struct TexelIrradiance {
  std::vector<RGB> value;           ///< W m^-2
  std::vector<std::uint8_t> known;  ///< whether the texel has a value

  explicit TexelIrradiance(std::size_t texels) : value(texels), known(texels, 0) {}
  /// Takes rows of texels out of a film, filtered where the settings say so.
  /// @param film of a Job of these settings over `grid`, made by texel_points()
  void take(const Film& film, const PointGrid& grid, const RenderSettings& settings, int first_row, int end_row);
};

/// Light of all texels, one for each texel of layout.texels: gaps filled and seams closed.
std::vector<RGB> light_of_texels(const Scene& scene, const BakeLayout& layout, TexelIrradiance irradiance,
                                 ShownLight shown);

/// Share of the light on a surface that leaves it towards the viewer: that it reflects, seen along its normal, and that
/// it transmits diffusely from behind. Baked textures show all of it as diffuse; without its specular lobes, polished
/// metal would be black.
RGB baked_albedo(const Scene& scene, std::uint32_t triangle, Vec2 barycentric);

/// Whether diffuse light comes through a surface.
bool is_translucent(const Scene& scene, std::uint32_t material);

/// PointGrid::from_behind at a place of a surface, or of a texel of it: the transmitted part of baked_albedo().
RGB share_from_behind(const Scene& scene, std::uint32_t triangle, Vec2 barycentric);
RGB share_from_behind(const Scene& scene, const BakeLayout& layout, std::size_t texel);

/// The exposure in stops of a picture by the scene's first camera, as the texels and the environment show it. Texels
/// that this camera does not see, such as the insides of objects, count only if it sees none at all. Tints are exposed
/// as on white surfaces, because files clip them at 1.
/// @param light of all texels; @param what it is
float automatic_exposure(const Scene& scene, const Tracer& tracer, const BakeLayout& layout, std::span<const RGB> light,
                         TexelLight what);

/// Levels of brightness of charts; each is a quarter of the one before.
inline constexpr int kLightLevels = 6;

/// What codes should hold.
struct LightRange {
  float scale = 0;                                       ///< of charts of level 0; 0: chosen
  float white = std::numeric_limits<float>::infinity();  ///< light that shows as white on a white surface
  std::function<float(std::size_t texel)> albedo = {};   ///< what shown light is multiplied by; empty: 1

  /// Light that shows so far above white that more of it looks the same.
  float enough(std::size_t texel) const;
};

/// Codes of textures, in sRGB. A texel is its code times the scale of its chart, so that dark rooms have fine steps.
struct EncodedLight {
  float scale = 1;                  ///< of charts of level 0
  std::vector<std::uint8_t> level;  ///< one a chart
  std::vector<std::uint8_t> codes;  ///< three a texel, of all atlases
  double clipped = 0;               ///< share of covered texels brighter than the scale of their chart

  float scale_of_level(int l) const { return std::ldexp(scale, -2 * l); }
};

/// Chooses a scale that keeps nearly all texels below it, and for each chart the last level that holds all its texels;
/// then rounds to codes. Charts that also have places darker than white hold no more than range.enough(), or these
/// would have a few coarse codes, whose rounding shows as specks. Dark codes are dithered, so that surfaces keep their
/// mean.
EncodedLight encode_light(const BakeLayout& layout, const std::vector<RGB>& light, const LightRange& range = {});

/// Light as 8-bit RGBM: red, green, blue and a multiplier for each texel, all linear. A texel shows
/// range * (R / 255, G / 255, B / 255) * (M / 255), in steps of M / 255^2 of the range.
struct RgbmLight {
  float range = 1;                  ///< the brightest component
  std::vector<std::uint8_t> codes;  ///< four a texel
};

/// Rounds to the nearest codes, with the least multiplier that holds each texel. Nothing is clipped.
RgbmLight encode_rgbm(std::span<const RGB> light);

}  // namespace glowworm
