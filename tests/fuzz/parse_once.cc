#include "fuzz/parse_once.h"

#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>

#include "core/error.h"
#include "import/assimp/import.h"
#include "import/obj/reader.h"
#include "import/pbrt/builder.h"
#include "import/pbrt/parser.h"
#include "import/pbrt/spectrum.h"
#include "import/ply/reader.h"
#include "import/rad/reader.h"
#include "import/stl/reader.h"
#include "import/window/bsdf_xml.h"

namespace glowworm::fuzz {

namespace {

class GreyImage : public TextureImage {
  RGB color(Vec2) const override { return RGB(0.5f); }
  float alpha(Vec2) const override { return 0.5f; }
  bool has_alpha() const override { return true; }
  int width() const override { return 2; }
  int height() const override { return 2; }
};

void require(bool condition) {
  if (!condition) std::abort();
}

void check_geometry(const SceneDescription& scene) {
  const Geometry& g = scene.geometry;
  require(g.normals.size() == g.positions.size() && g.uvs.size() == g.positions.size());
  require(g.material.size() == g.triangles.size() && g.emission.size() == g.triangles.size());
  for (const Vec3& p : g.positions) require(is_finite(p));
  for (std::size_t t = 0; t < g.triangles.size(); ++t) {
    for (const std::uint32_t vertex : g.triangles[t]) require(vertex < g.positions.size());
    require(g.material[t] < scene.materials.size());
    require(g.emission[t] == kNone || g.emission[t] < scene.emissions.size());
  }
}

void check_materials(const SceneDescription& scene) {
  const auto is_node = [&](std::uint32_t id) { return id == kNone || id < scene.textures.size(); };
  for (std::size_t i = 0; i < scene.textures.size(); ++i) {
    const TextureNode& node = scene.textures[i];
    for (const std::uint32_t child : {node.child_a, node.child_b, node.child_amount}) {
      require(child == kNone || child < i);
    }
  }
  for (const Material& m : scene.materials) {
    for (const ColorInput* input : {&m.reflectance, &m.transmittance, &m.normal_map}) require(is_node(input->texture));
    for (const FloatInput* input :
         {&m.roughness_u, &m.roughness_v, &m.coat_roughness, &m.mix_amount, &m.alpha, &m.bump}) {
      require(is_node(input->texture));
    }
    require(is_finite(m.reflectance.value) && is_finite(m.eta) && is_finite(m.k) && m.ior > 0);
    if (m.kind == MaterialKind::mix) require(m.mix_a < scene.materials.size() && m.mix_b < scene.materials.size());
  }
  for (const Light& light : scene.lights) require(std::fabs(length(light.direction) - 1) < 1e-3f);
}

}  // namespace

void expect_consistent(const SceneDescription& scene) {
  check_geometry(scene);
  check_materials(scene);
}

void parse_scene(std::string_view text) {
  CoordinateOrigin origin;
  PbrtContext context(origin);
  context.main_file = "/nonexistent/fuzz.pbrt";
  context.budget = std::make_shared<MemoryBudget>(kBudget);
  context.load_image = [](const std::string&, const TextureOptions&, StandIn) -> std::shared_ptr<const TextureImage> {
    return std::make_shared<GreyImage>();
  };
  context.load_needed_image = context.load_image;
  context.v3 = is_pbrt_v3(text);
  PbrtBuilder builder(context);
  try {
    parse_pbrt_text(text, context.main_file, context.diagnostics, *context.budget,
                    [&](PbrtDirective& d) { builder.take(d); });
    builder.finish();
    static_cast<void>(context.diagnostics.notes());
    context.diagnostics.throw_if_errors();
  } catch (const Error&) {
    return;
  }
  expect_consistent(context.scene);
}

void parse_mesh(std::string_view bytes) {
  MemoryBudget budget(kBudget);
  try {
    CoordinateOrigin origin;
    const PlyMesh mesh = read_near(origin, [&] { return parse_ply(bytes, "fuzz.ply", budget, origin); });
    require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
    require(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size());
    for (const auto& corners : mesh.triangles) {
      for (const std::uint32_t vertex : corners) require(vertex < mesh.positions.size());
    }
  } catch (const Error&) {
  }
}

void parse_obj_and_mtl(std::string_view text) {
  MemoryBudget budget(kBudget);
  ObjFiles files;
  files.library = [&](const std::string&) { return std::string(text); };
  files.texture = [](const PhongTexture&, const TextureOptions&, StandIn) { return std::make_shared<GreyImage>(); };
  NoteCounter notes;
  try {
    CoordinateOrigin origin;
    expect_consistent(read_near(origin, [&] { return parse_obj(text, "fuzz.obj", files, notes, budget, origin); }));
  } catch (const Error&) {
  }
}

void parse_stl_mesh(std::string_view bytes) {
  MemoryBudget budget(kBudget);
  try {
    CoordinateOrigin origin;
    const Geometry mesh = read_near(origin, [&] { return parse_stl(bytes, "fuzz.stl", budget, origin); });
    require(mesh.normals.size() == mesh.positions.size() && mesh.uvs.size() == mesh.positions.size());
    require(mesh.positions.size() == 3 * mesh.triangles.size());
  } catch (const Error&) {
  }
}

void parse_rad_scene(std::string_view text) {
  MemoryBudget budget(kBudget);
  NoteCounter notes;
  const RadFileReader no_file = [](std::string&, const std::string&) -> std::string { throw Error("no file"); };
  try {
    CoordinateOrigin origin;
    expect_consistent(read_near(origin, [&] { return parse_rad(text, "fuzz.rad", no_file, notes, budget, origin); }));
  } catch (const Error&) {
  }
}

void parse_window(std::string_view text) {
  try {
    std::vector<std::string> notes;
    const auto measured = parse_bsdf_xml(text, "fuzz.xml", notes);
    for (const bool back : {false, true})
      for (const bool passes : {false, true}) {
        const float albedo = measured->albedo(back, passes, {0.6f, 0, 0.8f});
        require(albedo >= 0 && albedo <= 1.001f);
      }
  } catch (const Error&) {
  }
}

void parse_hand_over(std::string_view bytes) {
  ImportOptions options;
  options.budget = loading_budget(kBudget);
  try {
    CoordinateOrigin origin;
    expect_consistent(read_near(origin, [&] { return build_assimp_scene(bytes, "fuzz.dae", options, origin); }));
  } catch (const Error&) {
  }
}

void parse_spectrum(std::string_view text) {
  try {
    const SampledSpectrum spectrum = parse_spd(text, "fuzz.spd");
    static_cast<void>(reflectance_rgb(spectrum));
    static_cast<void>(illuminant_rgb(spectrum));
    static_cast<void>(conductor_rgb(spectrum, spectrum));
  } catch (const Error&) {
  }
}

}  // namespace glowworm::fuzz
