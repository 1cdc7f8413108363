// Materials as scene files describe them. bsdf.h has their form at a point.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "core/rgb.h"
#include "scene/texture.h"

namespace glowworm {

class MeasuredBsdf;

enum class MaterialKind : std::uint8_t {
  diffuse,             ///< Lambertian reflection: reflectance; transmission if transmittance is not black
  conductor,           ///< metal: eta + ik, or Schlick's F0 = reflectance with use_reflectance
  dielectric,          ///< glass: eta, roughness; reflectance and transmittance tint the two
  thin_dielectric,     ///< a pane without thickness: eta
  coated_diffuse,      ///< a diffuse base under a dielectric coat of eta and roughness
  coated_conductor,    ///< a conductor under a dielectric coat
  metallic_roughness,  ///< glTF 2.0, appendix B: base colour, metallic, roughness, specular, clearcoat, transmission
  mix,                 ///< one of two other materials, chosen by amount
  interface,           ///< parts two media; light passes straight through, and its emission is added
  measured,            ///< scatters by matrices
};

/// In place of the index of a medium: the scene does not say which medium is on that side of a surface.
inline constexpr std::uint32_t kUnnamed = kNone - 1;

/// The kind's name, as enumerated.
const char* name(MaterialKind kind);

/// A material of the scene. Each kind reads only the inputs listed for it.
struct Material {
  std::string name;
  MaterialKind kind = MaterialKind::diffuse;

  ColorInput reflectance{RGB(0.5f)};    ///< diffuse albedo, base colour, or reflectance at normal incidence
  ColorInput transmittance{RGB(0.0f)};  ///< diffuse transmission, or the tint of light that a dielectric transmits;
                                        ///< thin_dielectric: transmittance of its interior at normal incidence
  RGB eta{1.5f}, k{0.0f};               ///< conductor's complex index of refraction, relative to the outside
  bool use_reflectance = false;         ///< conductor by reflectance (F0) instead of eta and k
  float ior = 1.5f;                     ///< dielectrics and coats: index inside over index outside
  FloatInput roughness_u{0.0f}, roughness_v{0.0f};  ///< GGX alpha along and across the tangent; 0 is smooth
  FloatInput coat_roughness{0.0f};                  ///< GGX alpha of the coat (coated_conductor, clearcoat)
  float coat_thickness = 0.01f;                     ///< pbrt-v4 coated materials: thickness in scene units
  /// Maximum number of reflections at the base under a coat. pbrt-v4's random walk of "maxdepth" steps (default 10)
  /// counts each passage of the coat.
  std::uint8_t coat_bounces = 5;
  FloatInput metallic{0.0f};  ///< metallic_roughness
  FloatInput specular{1.0f};  ///< KHR_materials_specular factor
  ColorInput specular_color{RGB(1.0f)};
  FloatInput clearcoat{0.0f};     ///< KHR_materials_clearcoat factor
  FloatInput transmission{0.0f};  ///< KHR_materials_transmission factor
  bool thin = false;              ///< transmission does not bend rays (glTF without volume)
  ColorInput sheen{RGB(0.0f)};    ///< KHR_materials_sheen colour
  FloatInput sheen_roughness{0.0f};
  FloatInput anisotropy{0.0f};      ///< KHR_materials_anisotropy strength; roughness_u applies across the direction
  float anisotropy_rotation = 0;    ///< radians, from the tangent towards the bitangent
  ColorInput anisotropy_direction;  ///< (direction + 1) / 2 in red and green, if texture is not kNone
  FloatInput iridescence{0.0f};     ///< KHR_materials_iridescence factor
  float iridescence_ior = 1.3f;     ///< of the film
  float least_film = 0;             ///< thickness of the film in nm if `film` is 0
  FloatInput film{400.0f};          ///< nm in addition to least_film
  FloatInput diffuse_transmission{0.0f};  ///< KHR_materials_diffuse_transmission factor; transmittance is its colour
  ColorInput
      coat_normal_map;  ///< like normal_map, for the clearcoat; without it, the clearcoat has the vertices' normal
  float coat_normal_scale = 1;
  float dispersion = 0;  ///< KHR_materials_dispersion: 20 / Abbe number

  /// Media on the sides of a surface, indices into SceneDescription::media: inside is the side that normals point away
  /// from. kNone is vacuum.
  std::uint32_t inside = kUnnamed, outside = kUnnamed;

  std::uint32_t mix_a = kNone, mix_b = kNone;  ///< mix: materials at amount 0 and 1
  FloatInput mix_amount{0.5f};

  std::shared_ptr<const MeasuredBsdf> measured;  ///< measured: never null
  /// measured: towards azimuth 90 degrees of its front, with y up; about -z where it lies along the normal
  Vec3 measured_up{0, 1, 0};

  /// Cameras do not see the back of the surface. All other light is reflected and stopped on both sides.
  bool single_sided = false;
  /// Cameras do not see the surface: the rays that they send pass it. All other light meets it.
  bool unseen = false;

  FloatInput alpha{1.0f};   ///< presence of the surface: 0 lets every ray pass
  float alpha_cutoff = -1;  ///< >= 0: present if alpha >= cutoff; otherwise present with probability alpha
  ColorInput normal_map;    ///< tangent-space normals, stored as (n + 1) / 2, if texture is not kNone
  float normal_scale = 1;
  FloatInput bump;  ///< displacement in metres along the normal, if texture is not kNone
};

/// All inputs of a material that a texture may drive.
std::array<const ColorInput*, 7> color_inputs(const Material& material);
std::array<const FloatInput*, 15> float_inputs(const Material& material);

}  // namespace glowworm
