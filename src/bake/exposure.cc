#include <algorithm>
#include <array>
#include <limits>

#include "bake/light.h"
#include "bake/source_texture.h"
#include "image/tone_map.h"
#include "scene/light_sampling.h"

namespace glowworm {

namespace {

/// The texels that places of a scene show.
class ShownTexels {
 public:
  ShownTexels(const Scene& scene, const BakeLayout& layout)
      : layout_(layout), where_(places_of_faces(layout.charts, layout.faces.size())) {
    for (auto& side : face_) side.assign(scene.geometry().triangle_count(), kNone);
    for (std::uint32_t f = 0; f < layout.faces.size(); ++f) face_[layout.faces[f].back][layout.faces[f].triangle] = f;
  }

  /// The texel at a place of one side of a triangle; map.face.size() if that has none.
  std::size_t at(std::uint32_t triangle, bool back, Vec2 barycentric) const {
    std::uint32_t face = face_[back][triangle];
    // Baked files show surfaces with texels on one side from both.
    if (face == kNone) face = face_[!back][triangle];
    if (face == kNone) return layout_.texels.face.size();
    const FacePlace place = where_[face];
    const std::array<Vec2, 3>& c = layout_.charts[place.chart].corners[place.index];
    const Vec2 p = c[0] * (1 - barycentric.x - barycentric.y) + c[1] * barycentric.x + c[2] * barycentric.y;
    const ChartPlace& chart = layout_.atlas.places[place.chart];
    const Vec2 texel = chart.texel(p);
    const int last = layout_.atlas.side - 1;
    return layout_.texels.index(std::clamp(static_cast<int>(texel.x), 0, last),
                                std::clamp(static_cast<int>(texel.y), 0, last) + chart.atlas * layout_.atlas.side);
  }

 private:
  const BakeLayout& layout_;
  std::vector<FacePlace> where_;
  std::vector<std::uint32_t> face_[2];  ///< of each triangle's front and back; kNone: without texels
};

}  // namespace

float automatic_exposure(const Scene& scene, const Tracer& tracer, const BakeLayout& layout, std::span<const RGB> light,
                         TexelLight what) {
  constexpr int kLongerSide = 128;  // Pixels.
  const FilmRequest& film = scene.film();
  const float width = film.width > 0 ? static_cast<float>(film.width) : 1;
  const float height = film.height > 0 ? static_cast<float>(film.height) : 1;
  const float scale = kLongerSide / std::max(width, height);
  const int columns = std::max(static_cast<int>(width * scale), 1),
            rows = std::max(static_cast<int>(height * scale), 1);
  const auto radiance = [&](std::uint32_t triangle, Vec2 barycentric, RGB texel) {
    if (what == TexelLight::radiance) return texel;
    if (what == TexelLight::tint) return texel * kInversePi;
    return texel * base_color(scene, triangle, barycentric, true) * kInversePi;
  };
  std::vector<RGB> seen;
  bool sees_texels = false;
  const ShownTexels texels(scene, layout);
  const Camera& camera = scene.camera("");
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const Vec2 pixel{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
      const CameraRay ray = generate_ray(camera, pixel, columns, rows, {0.5f, 0.5f});
      if (ray.is_blind()) continue;
      const Hit hit = tracer.intersect({ray.origin, 0, ray.direction, std::numeric_limits<float>::infinity()});
      if (hit.triangle == kNone) {
        seen.push_back(environment_radiance(scene, ray.direction));
        continue;
      }
      const bool back = dot(scene.geometry().normal(hit.triangle), ray.direction) > 0;
      const std::size_t texel = texels.at(hit.triangle, back, hit.barycentric);
      if (texel == light.size()) continue;
      seen.push_back(radiance(hit.triangle, hit.barycentric, light[texel]));
      sees_texels = true;
    }
  if (sees_texels) return automatic_exposure(seen);
  seen.clear();
  for (std::size_t i = 0; i < light.size(); ++i) {
    const std::uint32_t face = layout.texels.face[i];
    if (face != kNone) seen.push_back(radiance(layout.faces[face].triangle, layout.texels.barycentric[i], light[i]));
  }
  return automatic_exposure(seen);
}

}  // namespace glowworm
