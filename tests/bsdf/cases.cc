#include "bsdf/cases.h"

namespace glowworm {

Bsdf glass(float alpha, float eta) {
  Bsdf b;
  b.kind = BsdfKind::dielectric;
  b.specular = b.transmission = RGB(1.0f);
  b.eta = RGB(eta);
  b.alpha_x = b.alpha_y = alpha;
  return b;
}

Bsdf silver(float alpha) {
  Bsdf b;
  b.kind = BsdfKind::conductor;
  b.eta = {0.155f, 0.117f, 0.138f};
  b.k = {4.83f, 3.12f, 2.15f};
  b.alpha_x = b.alpha_y = alpha;
  return b;
}

Bsdf coated_diffuse(RGB albedo, float alpha, float thickness) {
  Bsdf b;
  b.kind = BsdfKind::coated_diffuse;
  b.diffuse = albedo;
  b.alpha_x = b.alpha_y = alpha;
  b.coat_thickness = thickness;
  return b;
}

Bsdf coated_silver(float base_alpha, float coat_alpha, float thickness) {
  Bsdf b = silver(base_alpha);
  b.kind = BsdfKind::coated_conductor;
  b.coat_alpha = coat_alpha;
  b.coat_thickness = thickness;
  return b;
}

Bsdf metallic_roughness(RGB color, float metallic, float alpha) {
  Bsdf b;
  b.kind = BsdfKind::metallic_roughness;
  b.diffuse = color;
  b.specular = RGB(1.0f);
  b.metallic = metallic;
  b.alpha_x = b.alpha_y = alpha;
  return b;
}

std::vector<BsdfCase> bsdf_cases() {
  std::vector<BsdfCase> cases;
  const auto add = [&cases](const char* name, const Bsdf& bsdf) { cases.push_back({name, bsdf}); };
  Bsdf b;
  b.diffuse = {0.8f, 0.5f, 0.1f};
  add("lambertian", b);
  b.transmission = {0.1f, 0.3f, 0.2f};
  add("lambertian on both sides", b);
  for (const float alpha : {0.0f, 0.02f, 0.1f, 0.4f, 1.0f}) {
    const std::string tail = " of alpha " + std::to_string(alpha);
    add(("silver" + tail).c_str(), silver(alpha));
    add(("glass" + tail).c_str(), glass(alpha));
    add(("coated diffuse" + tail).c_str(), coated_diffuse({0.8f, 0.4f, 0.05f}, alpha, 0.01f));
    add(("coated silver under alpha 0," + tail).c_str(), coated_silver(alpha, 0));
    add(("coated silver of alpha 0.2 under" + tail).c_str(), coated_silver(0.2f, alpha, 0.01f));
    add(("glTF plastic" + tail).c_str(), metallic_roughness({0.9f, 0.2f, 0.1f}, 0, alpha));
    add(("glTF metal" + tail).c_str(), metallic_roughness({0.9f, 0.6f, 0.1f}, 1, alpha));
    b = metallic_roughness({0.9f, 0.8f, 0.7f}, 0.2f, alpha);
    b.transmission_weight = 0.7f;
    add(("glTF glass" + tail).c_str(), b);
    b.thin = true;
    b.coat = 0.6f;
    b.coat_alpha = 0.05f;
    add(("glTF lacquered pane" + tail).c_str(), b);
    b.thin = false;
    add(("glTF lacquered glass" + tail).c_str(), b);
  }
  b = silver(0.1f);
  b.alpha_y = 0.5f;
  add("brushed silver", b);
  b.use_reflectance = true;
  b.specular = {0.9f, 0.5f, 0.2f};
  add("brushed metal by reflectance", b);
  b = glass(0.05f);
  b.alpha_y = 0.3f;
  b.specular = {0.9f, 0.5f, 0.2f};
  b.transmission = {0.2f, 0.7f, 0.9f};
  add("brushed tinted glass", b);
  add("bubble in glass", glass(0.2f, 1 / 1.5f));
  b = coated_diffuse({0.2f, 0.9f, 0.5f}, 0.1f);
  b.alpha_y = 0.4f;
  b.coat_bounces = 5;
  add("brushed coated diffuse", b);
  b = metallic_roughness({0.3f, 0.8f, 0.7f}, 0.5f, 0.3f);
  b.coat = 1;
  b.alpha_y = 0.1f;
  b.specular = {1, 0.5f, 0};
  b.specular_weight = 0.5f;
  add("glTF lacquered half metal", b);
  for (const float alpha : {0.0f, 0.3f}) {
    const std::string tail = " of alpha " + std::to_string(alpha);
    b = metallic_roughness({0.9f, 0.9f, 0.9f}, 0, alpha);
    b.coat = 0.8f;
    b.coat_alpha = alpha;
    b.coat_normal = normalize({0.4f, -0.2f, 0.8f});
    add(("glTF coat of another normal" + tail).c_str(), b);
    b = metallic_roughness({0.9f, 0.5f, 0.2f}, 0.3f, alpha);
    b.iridescence = 0.9f;
    b.film_thickness = 420;
    add(("glTF film" + tail).c_str(), b);
    b.transmission_weight = 1;
    add(("glTF film on glass" + tail).c_str(), b);
    b.thin = true;
    add(("glTF bubble" + tail).c_str(), b);
  }
  b = metallic_roughness({0.9f, 0.8f, 0.7f}, 0, 0.4f);
  b.sheen = {1, 0.8f, 0.5f};
  b.sheen_alpha = 0.09f;
  add("glTF cloth", b);
  b.sheen_alpha = 0.8f;
  b.coat = 0.5f;
  add("glTF lacquered felt", b);
  b.diffuse_transmission = 0.6f;
  b.transmission = {0.2f, 0.9f, 0.1f};
  add("glTF curtain", b);
  b.sheen = RGB(0.0f);
  b.coat = 0;
  add("glTF leaf", b);
  b = glass(0);
  b.kind = BsdfKind::thin_dielectric;
  add("pane", b);
  return cases;
}

std::vector<Vec3> viewers() {
  return {{0, 0, 1}, normalize({0.3f, 0.5f, 0.8f}), normalize({-0.9f, 0.2f, 0.15f}), normalize({0.5f, -0.4f, -0.6f})};
}

}  // namespace glowworm
