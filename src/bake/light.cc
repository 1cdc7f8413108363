#include "bake/light.h"

#include <algorithm>

#include "bake/fill.h"
#include "bake/source_texture.h"
#include "core/parallel.h"
#include "film/filtered.h"
#include "image/tone_map.h"

namespace glowworm {

namespace {

/// Shares of light that leave a place of a surface towards the viewer.
struct BakedShares {
  RGB reflected, transmitted;
};

BakedShares baked_shares(const Scene& scene, std::uint32_t triangle, Vec2 barycentric) {
  DiffusePoint diffuse;
  if (diffuse_point(scene, triangle, barycentric, diffuse)) return {diffuse.reflectance, RGB(0.0f)};
  SurfacePoint point = surface_point(scene, triangle, barycentric);
  const Bsdf bsdf = resolve_bsdf(scene, point);
  return {clamp(albedo(bsdf, {0, 0, 1}, kAllLobes & ~kDiffuseTransmission), 0, 1),
          clamp(albedo(bsdf, {0, 0, 1}, kDiffuseTransmission), 0, 1)};
}

RGB share_from_behind(const BakedShares& shares) {
  RGB out(0.0f);
  for (int c = 0; c < 3; ++c)
    if (shares.transmitted[c] > 0) out[c] = shares.transmitted[c] / (shares.reflected[c] + shares.transmitted[c]);
  return out;
}

/// Calls place(face, barycentric) for two by two places of a texel's square; for one where its face ends before.
/// @return the number of places
template <typename Place>
int for_each_place(const BakeLayout& layout, std::size_t texel, Place&& place) {
  const TexelMap& map = layout.texels;
  const BakeFace face = layout.faces[map.face[texel]];
  const Vec2 here = map.barycentric[texel];
  const std::size_t below = texel + static_cast<std::size_t>(map.width);
  const bool has_right = texel + 1 < map.face.size() && map.face[texel + 1] == map.face[texel];
  const bool has_below = below < map.face.size() && map.face[below] == map.face[texel];
  if (!has_right || !has_below) {
    place(face, here);
    return 1;
  }
  const Vec2 across = (map.barycentric[texel + 1] - here) * 0.25f, down = (map.barycentric[below] - here) * 0.25f;
  for (int i = 0; i < 4; ++i) {
    const Vec2 at = here + across * (i % 2 ? 1.0f : -1.0f) + down * (i / 2 ? 1.0f : -1.0f);
    place(face, at.x < 0 || at.y < 0 || at.x + at.y > 1 ? here : at);
  }
  return 4;
}

/// The light of a place of a surface, from its irradiance in W m^-2.
RGB light_of_place(const Scene& scene, BakeFace face, Vec2 barycentric, RGB irradiance, const ShownLight& shown) {
  constexpr float kMinAlbedo = 0.01f;
  const RGB reflectance = baked_albedo(scene, face.triangle, barycentric);
  RGB emitted;
  if (shown.what != TexelLight::irradiance && scene.geometry().emission[face.triangle] != kNone) {
    const SurfacePoint point = surface_point(scene, face.triangle, barycentric);
    emitted = emitted_radiance(scene, point, face.back ? -point.geometric_normal : point.geometric_normal);
  }
  if (shown.what == TexelLight::radiance) return reflectance * irradiance * kInversePi + emitted;
  const RGB base = base_color(scene, face.triangle, barycentric, shown.keeps_source);
  const RGB lacking = (reflectance - base) * irradiance + kPi * emitted;
  for (int c = 0; c < 3; ++c) irradiance[c] += lacking[c] / std::max(base[c], kMinAlbedo);
  return irradiance;
}

/// The mean over the square of a texel.
RGB light_of_texel(const Scene& scene, const BakeLayout& layout, std::size_t texel, RGB irradiance,
                   const ShownLight& shown) {
  RGB sum;
  const int places = for_each_place(layout, texel, [&](BakeFace face, Vec2 barycentric) {
    sum += light_of_place(scene, face, barycentric, irradiance, shown);
  });
  return sum / static_cast<float>(places);
}

/// Thresholds in [0, 1) that are even over any few neighbours (J. Jimenez, "Next Generation Post Processing in Call of
/// Duty: Advanced Warfare", SIGGRAPH 2014).
float gradient_noise(std::size_t x, std::size_t y) {
  const double inner = 0.06711056 * static_cast<double>(x) + 0.00583715 * static_cast<double>(y);
  const double outer = 52.9829189 * (inner - std::floor(inner));
  return static_cast<float>(outer - std::floor(outer));
}

/// The sRGB code of a value. Of coarse codes, one of the two neighbours, so that their mean is the value.
std::uint8_t dithered_code(float value, float threshold) {
  constexpr float kFine = 96;  // Steps of 2.5%.
  const float code = 255 * srgb_encode(value), below = std::floor(code);
  if (code >= kFine) return to_byte(code / 255);
  const float low = srgb_decode(static_cast<std::uint8_t>(below));
  const float high = srgb_decode(static_cast<std::uint8_t>(below + 1));
  return static_cast<std::uint8_t>(below + (value - low > threshold * (high - low) ? 1.0f : 0.0f));
}

/// The least scale that keeps nearly all light, of the brightest components of texels.
float automatic_scale(std::vector<float> peaks) {
  constexpr double kBright = 0.995;
  constexpr double kClippedLight = 1e-3;   // Share of all light: small bright places, such as caustics, keep theirs.
  constexpr float kLeast = 4, kMost = 64;  // Times `bright`; above it, codes of other places would be too coarse.
  if (peaks.empty()) return 0;
  double light = 0;
  for (const float p : peaks) light += p;
  const auto at = peaks.begin() + static_cast<std::ptrdiff_t>(kBright * static_cast<double>(peaks.size() - 1));
  std::nth_element(peaks.begin(), at, peaks.end());
  const float bright = *at;
  std::sort(at, peaks.end(), std::greater<>());
  double above = 0;  // light of the texels before i
  auto i = at;
  for (; i + 1 != peaks.end(); ++i) {
    above += *i;
    const double clipped = above - static_cast<double>(i + 1 - at) * *(i + 1);
    if (clipped > kClippedLight * light) break;
  }
  return std::max(std::min(*at, kLeast * bright), std::min(*i, kMost * bright));
}

constexpr float kEnough = 4;  ///< times white: two stops, for viewers with tone curves

/// The least scale from this on that has a level which ends at kEnough times white.
float with_level_above_white(float scale, float white) {
  float level = kEnough * white;
  if (scale < level || !(level > 0)) return scale;
  while (level < scale) level *= 4;
  return level;
}

/// The brightest component that the codes of each chart should hold.
std::vector<float> chart_peaks(const BakeLayout& layout, const std::vector<RGB>& light, const LightRange& range) {
  constexpr double kDark = 0.05;  // Share of texels.
  struct Peak {
    float whole = 0, enough = 0;
    std::size_t texels = 0, dark = 0;
  };
  std::vector<Peak> peaks(layout.charts.size());
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (layout.texels.face[i] == kNone) continue;
    Peak& peak = peaks[layout.texels.chart[i]];
    const float texel = max_component(light[i]), enough = range.enough(i);
    peak.whole = std::max(peak.whole, texel);
    peak.enough = std::max(peak.enough, std::min(texel, enough));
    ++peak.texels;
    peak.dark += kEnough * texel < enough;
  }
  std::vector<float> out;
  for (const Peak& p : peaks)
    out.push_back(static_cast<double>(p.dark) > kDark * static_cast<double>(p.texels) ? p.enough : p.whole);
  return out;
}

}  // namespace

RGB baked_albedo(const Scene& scene, std::uint32_t triangle, Vec2 barycentric) {
  const BakedShares shares = baked_shares(scene, triangle, barycentric);
  return clamp(shares.reflected + shares.transmitted, 0, 1);
}

bool is_translucent(const Scene& scene, std::uint32_t material) {
  const Material& m = scene.materials()[material];
  if (m.kind == MaterialKind::mix) return is_translucent(scene, m.mix_a) || is_translucent(scene, m.mix_b);
  if (is_black(m.transmittance.value)) return false;
  return m.kind == MaterialKind::diffuse ||
         (m.kind == MaterialKind::metallic_roughness && m.diffuse_transmission.value > 0);
}

RGB share_from_behind(const Scene& scene, std::uint32_t triangle, Vec2 barycentric) {
  return share_from_behind(baked_shares(scene, triangle, barycentric));
}

RGB share_from_behind(const Scene& scene, const BakeLayout& layout, std::size_t texel) {
  BakedShares sum;
  for_each_place(layout, texel, [&](BakeFace face, Vec2 barycentric) {
    const BakedShares here = baked_shares(scene, face.triangle, barycentric);
    sum.reflected += here.reflected;
    sum.transmitted += here.transmitted;
  });
  return share_from_behind(sum);
}

void TexelIrradiance::take(const Film& film, const PointGrid& grid, const RenderSettings& settings, int first_row,
                           int end_row) {
  const bool indirect_only = settings.indirect_only;
  const std::vector<RGB> picture =
      (filters(settings)
           ? filtered_texels(film, indirect_only, {first_row - film.bounds().y0, end_row - film.bounds().y0})
           : unfiltered_picture(film, indirect_only))
          .radiance;
  const auto width = static_cast<std::size_t>(grid.width);
  const std::size_t before = static_cast<std::size_t>(film.bounds().y0) * width;
  for (std::size_t i = static_cast<std::size_t>(first_row) * width; i < static_cast<std::size_t>(end_row) * width;
       ++i) {
    value[i] = picture[i - before];
    known[i] = grid.has(i) && film.sample_count(i - before) > 0;
  }
}

std::vector<RGB> light_of_texels(const Scene& scene, const BakeLayout& layout, TexelIrradiance irradiance,
                                 ShownLight shown) {
  std::vector<RGB> light = std::move(irradiance.value);
  fill_gaps(layout.texels, std::move(irradiance.known), light);
  parallel_for_each(light.size(), 4096, [&](std::size_t i) {
    if (layout.texels.face[i] == kNone) return;
    const std::uint32_t triangle = layout.faces[layout.texels.face[i]].triangle;
    if (shown.what == TexelLight::irradiance && !is_translucent(scene, scene.geometry().material[triangle])) return;
    light[i] = light_of_texel(scene, layout, i, light[i], shown);
  });
  std::vector<std::uint8_t> covered(light.size(), 0);
  for (std::size_t i = 0; i < light.size(); ++i) covered[i] = layout.texels.face[i] != kNone;
  fill_gaps(layout.texels, covered, light);
  close_seams(find_seams(scene.geometry(), layout.faces, layout.charts, layout.atlas), light);
  return light;
}

float LightRange::enough(std::size_t texel) const {
  return kEnough * white / (albedo ? std::max(albedo(texel), 1e-3f) : 1);
}

EncodedLight encode_light(const BakeLayout& layout, const std::vector<RGB>& light, const LightRange& range) {
  EncodedLight out;
  std::vector<float> peaks;
  for (std::size_t i = 0; i < light.size(); ++i)
    if (layout.texels.face[i] != kNone) peaks.push_back(max_component(light[i]));
  out.scale = range.scale > 0 ? range.scale : with_level_above_white(automatic_scale(peaks), range.white);
  if (!(out.scale > 0)) out.scale = 1;
  for (const float peak : chart_peaks(layout, light, range)) {
    int level = 0;
    while (level + 1 < kLightLevels && peak <= out.scale_of_level(level + 1)) ++level;
    out.level.push_back(static_cast<std::uint8_t>(level));
  }
  std::size_t clipped = 0;
  for (std::size_t i = 0; i < light.size(); ++i)
    clipped += layout.texels.face[i] != kNone &&
               max_component(light[i]) > 1.0001f * out.scale_of_level(out.level[layout.texels.chart[i]]);
  out.clipped = peaks.empty() ? 0 : static_cast<double>(clipped) / static_cast<double>(peaks.size());
  out.codes.reserve(3 * light.size());
  const auto width = static_cast<std::size_t>(layout.texels.width);
  for (std::size_t i = 0; i < light.size(); ++i) {
    const std::uint32_t chart = layout.texels.chart[i];
    const float whole = out.scale_of_level(chart != kNone ? out.level[chart] : 0);
    for (int c = 0; c < 3; ++c)
      out.codes.push_back(dithered_code(std::clamp(light[i][c] / whole, 0.0f, 1.0f),
                                        gradient_noise(i % width + 5 * static_cast<std::size_t>(c), i / width)));
  }
  return out;
}

RgbmLight encode_rgbm(std::span<const RGB> light) {
  RgbmLight out;
  float peak = 0;
  for (const RGB& texel : light) peak = std::max(peak, max_component(texel));
  if (peak > 0) out.range = peak;
  out.codes.reserve(4 * light.size());
  for (const RGB& texel : light) {
    const RGB shown = clamp(texel / out.range, 0, 1);
    const float multiplier = std::max(std::ceil(255 * max_component(shown)), 1.0f);
    for (int c = 0; c < 3; ++c)
      out.codes.push_back(static_cast<std::uint8_t>(std::min(std::round(shown[c] * 255 * 255 / multiplier), 255.0f)));
    out.codes.push_back(static_cast<std::uint8_t>(multiplier));
  }
  return out;
}

}  // namespace glowworm
