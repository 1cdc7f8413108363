// Baked light against the path tracer at the same points, its exposure, and its codes.
#include "bake/light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "bake/bands.h"
#include "bake_stage.h"
#include "bake_testing.h"
#include "builtin/builtin.h"
#include "core/parallel.h"
#include "film/filtered.h"
#include "image/tone_map.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// Root mean square of the difference over the root mean square of the reference, over texels with points.
double relative_rmse(const PointGrid& grid, const std::vector<RGB>& light, const std::vector<RGB>& reference) {
  double error = 0, square = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (!grid.has(i)) continue;
    for (int c = 0; c < 3; ++c) {
      const double d = static_cast<double>(light[i][c]) - reference[i][c];
      error += d * d;
      square += static_cast<double>(reference[i][c]) * reference[i][c];
    }
  }
  return std::sqrt(error / square);
}

TEST(SlowBakedLight, AgreesWithThePathTracerAtTheSamePoints) {
  const BakeStage cornell(builtin_scene("cornell"), {48, 0});
  RenderSettings gathering = by_gathering(8, 32, 500'000);
  gathering.filter = Filtering::off;  // With so few texels, the filter blurs the edges of shadows.
  const std::vector<RGB> baked = cornell.light(gathering, TexelLight::irradiance);
  RenderSettings paths = by_paths(512);
  const std::vector<RGB> one = cornell.light(paths, TexelLight::irradiance);
  paths.seed = 1;
  const std::vector<RGB> two = cornell.light(paths, TexelLight::irradiance);
  // Each of the references has noise of its own, which their difference tells.
  const double first = relative_rmse(*cornell.grid, baked, one), noise = relative_rmse(*cornell.grid, two, one);
  EXPECT_LT(noise, 0.1);
  EXPECT_LT(first * first - noise * noise / 2, 0.03 * 0.03);
  for (std::size_t i = 0; i < baked.size(); ++i)
    if (cornell.layout.texels.face[i] != kNone) {
      EXPECT_GT(luminance(baked[i]), 0) << "texel " << i;
    }
}

TEST(BakedLight, IsAlbedoTimesIrradianceOverPi) {
  const BakeStage cornell(builtin_scene("cornell"), {32, 0});
  const RenderSettings settings = by_gathering(1, 4);
  const std::vector<RGB> irradiance = cornell.light(settings, TexelLight::irradiance);
  const std::vector<RGB> radiance = cornell.light(settings, TexelLight::radiance);
  const Scene& scene = *cornell.stage.scene;
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    if (cornell.layout.texels.face[i] == kNone) continue;
    const BakeFace face = cornell.layout.faces[cornell.layout.texels.face[i]];
    const RGB albedo = scene.materials()[scene.geometry().material[face.triangle]].reflectance.value;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(radiance[i][c], irradiance[i][c] * albedo[c] / kPi, 1e-4f + 1e-3f * radiance[i][c]);
  }
}

TEST(BakedLight, IsTheSameForAnyNumberOfThreads) {
  const BakeStage cornell(builtin_scene("cornell"), {32, 0});
  const RenderSettings settings = by_gathering(2, 4);
  set_thread_count(3);
  const std::vector<RGB> three = cornell.light(settings, TexelLight::radiance);
  set_thread_count(1);
  const std::vector<RGB> one = cornell.light(settings, TexelLight::radiance);
  set_thread_count(0);
  EXPECT_TRUE(three == one);
}

TEST(BakedLight, HasThePhotonsOfOneMapInAllBands) {
  const BakeStage cornell(builtin_scene("cornell"), {256, 0});
  RenderSettings settings = by_gathering(1, 4, 5'000);
  std::vector<std::uint64_t> emitted;
  const auto bake = [&](std::uint64_t memory) {
    settings.memory_bytes = memory;
    emitted.clear();
    return bake_points(cornell.stage.scene, cornell.stage.tracer, cornell.grid, settings, std::nullopt,
                       [&](const BandRun& run) {
                         run.job.wait();
                         emitted.push_back(run.job.statistics().count(Counter::photons_emitted));
                         return std::exception_ptr();
                       })
        .irradiance.value;
  };
  const std::vector<RGB> whole = bake(std::uint64_t{1} << 30);
  ASSERT_EQ(emitted.size(), 1u);
  const std::uint64_t photons = emitted[0];
  EXPECT_TRUE(bake(std::uint64_t{64} << 20) == whole);
  ASSERT_GT(emitted.size(), 1u);
  EXPECT_EQ(emitted[0], photons);
  for (std::size_t i = 1; i < emitted.size(); ++i) EXPECT_EQ(emitted[i], 0u);
}

TEST(BakedLight, GuidesGatherRaysToTheLight) {
  const BakeStage cornell(builtin_scene("cornell"), {96, 0});
  RenderSettings settings = by_gathering(4, 16);
  settings.filter = Filtering::off;
  const auto error = [&](bool guided) {
    PointGrid grid = *cornell.grid;
    EXPECT_TRUE(grid.learns);
    grid.learns = guided;
    Job job(cornell.stage.scene, cornell.stage.tracer, settings, nullptr, 0, std::make_shared<const PointGrid>(grid));
    job.wait();
    return relative_error(unfiltered_picture(job.snapshot(), false));
  };
  EXPECT_LT(error(true), 0.93 * error(false));
}

TEST(BakedLight, StaysInItsRoom) {
  const BakeStage rooms(two_rooms(), {96, 0});
  const std::vector<RGB> light = rooms.light(by_gathering(16, 16), TexelLight::irradiance);
  const TexelMap& map = rooms.layout.texels;
  std::size_t dark = 0, within = 0, lit_within = 0;
  double mean = 0, lit = 0;
  float brightest = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (map.face[i] == kNone) continue;
    const SurfacePoint p =
        surface_point(*rooms.stage.scene, rooms.layout.faces[map.face[i]].triangle, map.barycentric[i]);
    if (p.position.x < 1.99f) {
      mean += luminance(light[i]);
      ++lit;
      EXPECT_GT(luminance(light[i]), 0);
    }
    if (p.position.x > 2.01f && p.position.x < 2.19f && rooms.layout.faces[map.face[i]].triangle < 12 &&
        p.position.z > 0.1f && p.position.z < 1.9f) {
      ++within;
      lit_within += rooms.grid->has(i);
    }
    if (p.position.x > 2.21f) {
      ++dark;
      brightest = std::max(brightest, luminance(light[i]));
    }
  }
  EXPECT_GT(dark, 1000u);
  EXPECT_GT(within, 10u);
  // Where rays cannot tell the end of the wall from the room's wall at the same place, a texel may be missed. The
  // filter spreads the light that one ray in thousands finds from there.
  EXPECT_LT(lit_within, within / 20);
  EXPECT_GT(mean / lit, 0.1);
  EXPECT_LT(brightest, 1e-4 * mean / lit) << brightest;
}

TEST(BakedLight, HasWhatSurfacesEmit) {
  const RGB faint{0.02f, 0.03f, 0.01f};
  const BakeStage room(room_with_panel(faint, false), {64, 0});
  const std::vector<RGB> irradiance = room.light(by_gathering(1, 4), TexelLight::irradiance);
  const std::vector<RGB> radiance = room.light(by_gathering(1, 4), TexelLight::radiance);
  const std::vector<RGB> tint = room.light(by_gathering(1, 4), TexelLight::tint);
  const Geometry& g = room.stage.scene->geometry();
  std::size_t texels = 0;
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const std::uint32_t f = room.layout.texels.face[i];
    if (f == kNone || g.material[room.layout.faces[f].triangle] != 1) continue;
    ++texels;
    const RGB emitted = room.layout.faces[f].back ? RGB() : faint;
    const RGB expected = RGB{0.5f, 0.25f, 0} * irradiance[i] * kInversePi + emitted;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[i][c], expected[c], 1e-3f * expected[c] + 1e-5f);
    for (int c = 0; c < 2; ++c)
      EXPECT_NEAR(RGB({0.5f, 0.25f, 0})[c] * tint[i][c] * kInversePi, expected[c], 1e-3f * expected[c]);
  }
  EXPECT_GT(texels, 20u);
}

/// Sheets beside each other that let diffuse light through: paper, a leaf of glTF, and a random mix of paper and an
/// opaque surface.
SceneDescription translucent_sheets() {
  SceneDescription d;
  d.materials.resize(4);
  Material &paper = d.materials[0], &leaf = d.materials[1], &opaque = d.materials[2], &mix = d.materials[3];
  paper.reflectance.value = {0.75f, 0.5f, 0};
  paper.transmittance.value = {0.25f, 0.5f, 1};
  leaf.kind = MaterialKind::metallic_roughness;
  leaf.reflectance.value = leaf.transmittance.value = RGB(1.0f);
  leaf.roughness_u.value = leaf.roughness_v.value = 1;
  leaf.diffuse_transmission.value = 0.5f;
  opaque.reflectance.value = RGB(1.0f);
  mix.kind = MaterialKind::mix;
  mix.mix_a = 0;
  mix.mix_b = 2;
  for (const std::uint32_t material : {0u, 1u, 3u})
    add_quad(d, {2 * static_cast<float>(material), 0, 0}, {1, 0, 0}, {0, 1, 0}, material);
  return d;
}

/// The mean light of the texels of a material on one side, and its number.
struct MeanTexel {
  RGB light;
  std::size_t texels = 0;
};

MeanTexel mean_texel(const BakeStage& bake, const std::vector<RGB>& light, std::uint32_t material, bool back) {
  MeanTexel out;
  for (std::size_t i = 0; i < light.size(); ++i) {
    const std::uint32_t f = bake.layout.texels.face[i];
    if (f == kNone || bake.layout.faces[f].back != back) continue;
    if (bake.stage.scene->geometry().material[bake.layout.faces[f].triangle] != material) continue;
    out.light += light[i];
    ++out.texels;
  }
  out.light = out.light / static_cast<float>(std::max<std::size_t>(out.texels, 1));
  return out;
}

TEST(BakedLight, OfTranslucentSheetsFillsAFurnace) {
  SceneDescription d = translucent_sheets();
  d.environment.emplace();
  const BakeStage sheets(std::move(d), {64, 0});
  for (const RenderSettings& settings : {by_gathering(16, 16), by_paths(256)}) {
    const std::vector<RGB> light = sheets.light(settings, TexelLight::radiance);
    for (const std::uint32_t material : {0u, 1u, 3u})
      for (const bool back : {false, true}) {
        const MeanTexel mean = mean_texel(sheets, light, material, back);
        EXPECT_GT(mean.texels, 100u);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean.light[c], 1, 0.005f) << material << back << c;
      }
  }
}

/// A sun behind the sheets: its irradiance times a reflectance or a transmittance over pi is exact.
TEST(BakedLight, ComesThroughTranslucentSheets) {
  constexpr float kSun = 2;
  SceneDescription d = translucent_sheets();
  Light sun;
  sun.kind = LightKind::directional;
  sun.direction = {0, 0, 1};
  sun.intensity = RGB(kSun);
  d.lights.push_back(sun);
  const BakeStage sheets(std::move(d), {64, 0});
  const std::vector<RGB> radiance = sheets.light(by_gathering(1, 1), TexelLight::radiance);
  const std::vector<RGB> irradiance = sheets.light(by_gathering(1, 1), TexelLight::irradiance);
  const std::vector<RGB> tint = sheets.light(by_gathering(1, 1), TexelLight::tint);
  const Material& paper = sheets.stage.scene->materials()[0];
  for (const bool back : {false, true}) {
    const RGB share = back ? paper.reflectance.value : paper.transmittance.value;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(mean_texel(sheets, radiance, 0, back).light[c], kSun * share[c] * kInversePi, 1e-3f);
      // What a lightmap or a colour of vertices shows on the base colour.
      const float base = paper.reflectance.value[c];
      if (!(base > 0)) continue;
      EXPECT_NEAR(base * mean_texel(sheets, irradiance, 0, back).light[c], kSun * share[c], 4e-3f);
      EXPECT_NEAR(base * mean_texel(sheets, tint, 0, back).light[c], kSun * share[c], 4e-3f);
    }
    const RGB mixed = (share + RGB(back ? 1.0f : 0.0f)) * 0.5f;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(mean_texel(sheets, radiance, 3, back).light[c], kSun * mixed[c] * kInversePi, 0.03f);
  }
}

TEST(BakedLight, ShowsMetalThatATexturePolishes) {
  const RGB color{0.5f, 0.25f, 0.125f};
  SceneDescription d = two_rooms();
  Material metal;
  metal.kind = MaterialKind::metallic_roughness;
  metal.reflectance.value = color;
  metal.metallic.value = 1;
  metal.roughness_u = metal.roughness_v = {0.01f, static_cast<std::uint32_t>(d.textures.size())};
  d.textures.emplace_back();
  d.materials.push_back(metal);
  const std::uint32_t material = static_cast<std::uint32_t>(d.materials.size()) - 1;
  add_quad(d, {1, 0.5f, 1}, {0, 1, 0}, {0.5f, 0, 0}, material);
  const Stage stage(std::move(d));
  ASSERT_TRUE(is_bakeable(*stage.scene, material));
  const auto triangle = static_cast<std::uint32_t>(stage.scene->geometry().triangle_count() - 1);
  const RGB albedo = baked_albedo(*stage.scene, triangle, {0.3f, 0.3f});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(albedo[c], color[c], 0.1f * color[c]);
}

/// Two rooms, of which the camera sees the one with the lamp. @param other radiance of a lamp of the other one
SceneDescription rooms_with_camera(float other) {
  SceneDescription d = two_rooms();
  d.cameras.push_back(look_at({0.3f, 1, 1.7f}, {1.8f, 0.6f, 0.3f}, {0, 1, 0}, 70));
  add_quad(d, {2.7f, 1.9f, 0.5f}, {1, 0, 0}, {0, 0, 1}, 0, add_emission(d, RGB(other)));
  return d;
}

TEST(BakedLight, IsExposedForTheFirstCamera) {
  float dim = 0;
  for (const float other : {0.05f, 50.0f}) {
    const BakeStage rooms(rooms_with_camera(other), {64, 0});
    const Scene& scene = *rooms.stage.scene;
    const float own = automatic_exposure(pixels(rooms.stage.render(by_path(32, 64))));
    const float white = std::log2(luminance(scene.materials()[0].reflectance.value));
    for (const TexelLight what : {TexelLight::irradiance, TexelLight::radiance, TexelLight::tint})
      EXPECT_NEAR(
          automatic_exposure(scene, *rooms.stage.tracer, rooms.layout, rooms.light(by_gathering(2, 8), what), what),
          own + (what == TexelLight::tint ? white : 0), 0.1f);
    EXPECT_NEAR(own, dim != 0 ? dim : own, 0.1f);
    dim = own;
  }
}

TEST(BakedLight, IsExposedForTheEnvironmentThatTheCameraSees) {
  SceneDescription d;
  d.materials.resize(1);
  d.materials[0].reflectance.value = RGB(0.02f);
  d.environment.emplace().scale = RGB(5.0f);
  d.cameras.push_back(look_at({0, 2, 2}, {0, 0, 0}, {0, 1, 0}, 40));
  add_quad(d, {-0.5f, 0, 0.5f}, {1, 0, 0}, {0, 0, -1});
  const BakeStage sheet(std::move(d), {32, 0});
  const float own = automatic_exposure(pixels(sheet.stage.render(by_path(32, 16))));
  EXPECT_NEAR(automatic_exposure(*sheet.stage.scene, *sheet.stage.tracer, sheet.layout,
                                 sheet.light(by_gathering(4, 8), TexelLight::radiance), TexelLight::radiance),
              own, 0.2f);
}

TEST(BakedLight, IsExposedForAllTexelsIfTheCameraSeesNone) {
  SceneDescription d = two_rooms();
  d.cameras.push_back(look_at({0, 9, 0}, {0, 20, 0}, {1, 0, 0}, 40));
  const BakeStage rooms(std::move(d), {32, 0});
  const std::vector<RGB> even(rooms.layout.texels.face.size(), RGB(0.09f));
  EXPECT_NEAR(automatic_exposure(*rooms.stage.scene, *rooms.stage.tracer, rooms.layout, even, TexelLight::radiance), 1,
              1e-3f);
}

TEST(BakedLight, IsEncodedWithinACode) {
  const BakeStage cornell(builtin_scene("cornell"), {32, 0});
  const std::vector<RGB> light = cornell.light(by_gathering(1, 4), TexelLight::radiance);
  const EncodedLight encoded = encode_light(cornell.layout, light);
  const TexelMap& map = cornell.layout.texels;
  std::vector<int> peak(cornell.layout.charts.size(), 0);
  for (std::size_t i = 0; i < light.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const int level = map.chart[i] != kNone ? encoded.level[map.chart[i]] : 0;
      const float shown = std::min(light[i][c] / encoded.scale_of_level(level), 1.0f);
      const int code = encoded.codes[3 * i + static_cast<std::size_t>(c)];
      EXPECT_NEAR(code, 255 * srgb_encode(shown), code > 96 ? 0.51f : 1);
      if (map.face[i] != kNone) peak[map.chart[i]] = std::max(peak[map.chart[i]], code);
    }
  // A quarter of the scale is code 137, so each chart uses half of the codes.
  EXPECT_GE(*std::min_element(peak.begin(), peak.end()), 137);
  EXPECT_GT(*std::max_element(encoded.level.begin(), encoded.level.end()), 0);
  EXPECT_LT(encoded.clipped, 0.005);
}

TEST(BakedLight, KeepsTheLightOfSmallBrightPlaces) {
  const BakeStage cornell(builtin_scene("cornell"), {128, 0});
  std::vector<RGB> light(cornell.layout.texels.face.size(), RGB(1));
  const ChartPlace& place = cornell.layout.atlas.places[0];
  // Of thousands of texels, nine have some percent of the light, as below a lens.
  for (int i = 0; i < 9; ++i)
    light[cornell.layout.texels.index(place.x0 + kGutter + i % 3, place.y0 + kGutter + i / 3)] = RGB(30);
  const EncodedLight encoded = encode_light(cornell.layout, light);
  EXPECT_NEAR(encoded.scale, 30, 0.03 * 30);
  // One texel may be an error, and is not worth the codes of the others.
  for (int i = 1; i < 9; ++i)
    light[cornell.layout.texels.index(place.x0 + kGutter + i % 3, place.y0 + kGutter + i / 3)] = RGB(1);
  light[cornell.layout.texels.index(place.x0 + kGutter, place.y0 + kGutter)] = RGB(1e6f);
  EXPECT_LE(encode_light(cornell.layout, light).scale, 64);
}

TEST(BakedLight, DecodesFromRgbmWithinHalfACode) {
  std::vector<RGB> light{{0, 0, 0}, {40, 20, 1e-3f}, {1e-4f, 0, 0}};
  for (int i = 1; i < 1000; ++i) {
    const float x = static_cast<float>(i) / 1000;
    light.push_back(RGB{x, 1 - x, x * x} * std::exp2(10 * x - 6));
  }
  const RgbmLight encoded = encode_rgbm(light);
  EXPECT_EQ(encoded.range, 40);
  for (std::size_t i = 0; i < light.size(); ++i) {
    const std::uint8_t* code = &encoded.codes[4 * i];
    const float whole = encoded.range * static_cast<float>(code[3]) / 255;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(whole * static_cast<float>(code[c]) / 255, light[i][c], whole * 0.501f / 255) << i;
    // The multiplier is the least, so that steps are fine.
    EXPECT_LE(whole - encoded.range / 255, max_component(light[i])) << i;
  }
}

TEST(BakedLight, KeepsTheMeanOfDarkPlacesBesideBrightOnes) {
  const BakeStage cornell(builtin_scene("cornell"), {128, 0});
  const RGB dark{0.6e-3f, 1e-3f, 0.2e-3f};  // of which 1e-3 is code 3.3, and 0.2e-3 code 0.7
  std::vector<RGB> light(cornell.layout.texels.face.size(), dark);
  for (const ChartPlace& place : cornell.layout.atlas.places)
    for (int y = 0; y < 2; ++y) light[cornell.layout.texels.index(place.x0 + kGutter + y, place.y0 + kGutter)] = RGB(1);
  const EncodedLight encoded = encode_light(cornell.layout, light, {1});
  RGB sum;
  double count = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    const std::uint32_t chart = cornell.layout.texels.chart[i];
    if (light[i] == RGB(1) || chart == kNone || encoded.level[chart] != 0) continue;
    for (int c = 0; c < 3; ++c) sum[c] += srgb_decode(encoded.codes[3 * i + static_cast<std::size_t>(c)]);
    ++count;
  }
  ASSERT_GT(count, 1000);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(static_cast<double>(sum[c]) / count, dark[c], 0.02 * dark[c]);
}

/// The light that codes show.
RGB decoded(const BakeLayout& layout, const EncodedLight& encoded, std::size_t texel) {
  const float scale = encoded.scale_of_level(encoded.level[layout.texels.chart[texel]]);
  RGB out;
  for (int c = 0; c < 3; ++c) out[c] = scale * srgb_decode(encoded.codes[3 * texel + static_cast<std::size_t>(c)]);
  return out;
}

TEST(BakedLight, KeepsTheColoursOfDarkPlacesBesideBrightOnes) {
  const BakeStage cornell(builtin_scene("cornell"), {128, 0});
  const std::vector<std::uint32_t>& chart = cornell.layout.texels.chart;
  const RGB dark{0.1f, 0.06f, 0.02f}, bright(200);
  std::vector<RGB> light(cornell.layout.texels.face.size(), dark);
  const ChartPlace& mixed = cornell.layout.atlas.places[0];
  for (int y = 0; y < mixed.height / 2; ++y)
    for (int x = 0; x < mixed.width; ++x) light[cornell.layout.texels.index(mixed.x0 + x, mixed.y0 + y)] = bright;
  for (std::size_t i = 0; i < light.size(); ++i)
    if (chart[i] == 1) light[i] = bright;
  // As radiance, and as irradiance of surfaces of which half the light shows.
  for (const float albedo : {1.0f, 0.5f}) {
    const EncodedLight encoded =
        encode_light(cornell.layout, light, {0, 0.5f * albedo, [=](std::size_t) { return albedo; }});
    for (std::size_t i = 0; i < light.size(); ++i) {
      if (cornell.layout.texels.face[i] == kNone) continue;
      const RGB shown = decoded(cornell.layout, encoded, i);
      if (light[i] == dark)
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(shown[c], dark[c], 0.04f * dark.r) << "chart " << chart[i];
      else if (chart[i] == 1)  // Nothing dark is beside.
        ASSERT_NEAR(shown.g, bright.g, 0.01f * bright.g);
      else
        ASSERT_GE(shown.g, 2.0f) << "two stops above white";
    }
  }
}

}  // namespace
}  // namespace glowworm
