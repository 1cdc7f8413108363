#include "import/pbrt/material_table.h"

#include <fmt/format.h>

#include <utility>

#include "import/mesh_tools.h"
#include "import/texture_nodes.h"

namespace glowworm {

namespace {

bool is_absent(const Material& material) {
  const bool parts_nothing =
      material.kind == MaterialKind::interface && material.inside == kUnnamed && material.outside == kUnnamed;
  return parts_nothing || (material.alpha.value == 0 && material.alpha.texture == kNone);
}

/// The product of two alphas.
FloatInput product(std::vector<TextureNode>& textures, const FloatInput& a, const FloatInput& b) {
  FloatInput out = a.texture == kNone ? b : a;
  out.value = a.value * b.value;
  if (a.texture != kNone && b.texture != kNone) out.texture = add_product_node(textures, a.texture, b.texture);
  return out;
}

}  // namespace

PbrtMaterialTable::PbrtMaterialTable(PbrtContext& context) : context_(context), held_(*context.budget, "materials", 0) {
  const std::uint32_t standard = next_index();
  context_.scene.materials[standard].name = "default";
  known_[standard] = true;
}

std::uint32_t PbrtMaterialTable::next_index() {
  held_.grow(material_bytes());
  context_.scene.materials.emplace_back();
  known_.push_back(false);
  return static_cast<std::uint32_t>(context_.scene.materials.size() - 1);
}

std::uint32_t PbrtMaterialTable::add(const std::string& kind, const PbrtParameters& parameters) {
  const auto find = [this](const std::string& name, const PbrtPlace& place) { return by_name(name, place); };
  Material material = make_material(context_, kind, parameters, find);
  material.name = kind;
  const std::uint32_t index = next_index();
  context_.scene.materials[index] = std::move(material);
  known_[index] = true;
  return index;
}

void PbrtMaterialTable::define(const std::string& name, const std::string& kind, const PbrtParameters& parameters) {
  const auto find = [this](const std::string& other, const PbrtPlace& place) { return by_name(other, place); };
  Material material = make_material(context_, kind, parameters, find);
  material.name = name;
  Name& entry = names_[name];
  if (entry.defined) {
    context_.diagnostics.note(parameters.place(),
                              fmt::format("defined again, later uses take the new one: material {}", in_quotes(name)));
  }
  if (entry.defined || !entry.first_use.file) entry.index = next_index();
  entry.defined = true;
  entry.first_use = parameters.place();
  context_.scene.materials[entry.index] = std::move(material);
  known_[entry.index] = true;
}

std::function<void()> PbrtMaterialTable::restorer(const std::string& name) {
  const auto entry = names_.find(name);
  if (entry == names_.end() || !entry->second.defined) return nullptr;
  return [this, name, older = entry->second] { names_[name] = older; };
}

std::uint32_t PbrtMaterialTable::by_name(const std::string& name, const PbrtPlace& place) {
  Name& entry = names_[name];
  if (!entry.defined && !entry.first_use.file) {
    entry.index = next_index();
    entry.first_use = place;
  }
  return entry.index;
}

std::uint32_t PbrtMaterialTable::on_shape(std::uint32_t material, const FloatInput& alpha, const PbrtMediumSides& media,
                                          bool unseen) {
  const bool is_plain = media.inside == kUnnamed && media.outside == kUnnamed;
  if (alpha.texture == kNone && alpha.value >= 1 && is_plain && !unseen) return material;
  for (const Variant& variant : variants_) {
    if (variant.base == material && variant.alpha.texture == alpha.texture && variant.alpha.value == alpha.value &&
        variant.media.inside == media.inside && variant.media.outside == media.outside && variant.unseen == unseen) {
      return variant.index;
    }
  }
  variants_.push_back({material, next_index(), alpha, media, unseen});
  known_.back() = true;
  return variants_.back().index;
}

bool PbrtMaterialTable::may_be_textured(std::uint32_t index) const {
  const Material& material = context_.scene.materials[index];
  if (!known_[index] || material.kind == MaterialKind::mix) return true;
  for (const ColorInput* input : {&material.reflectance, &material.transmittance, &material.normal_map}) {
    if (input->texture != kNone) return true;
  }
  for (const FloatInput* input :
       {&material.roughness_u, &material.roughness_v, &material.coat_roughness, &material.bump, &material.alpha}) {
    if (input->texture != kNone) return true;
  }
  return false;
}

void PbrtMaterialTable::check_mixes() {
  auto& materials = context_.scene.materials;
  enum : unsigned char { unseen, open, done };
  std::vector<unsigned char> state(materials.size(), unseen);
  for (std::uint32_t root = 0; root < materials.size(); ++root) {
    std::vector<std::uint32_t> path(1, root);
    while (!path.empty()) {
      const std::uint32_t at = path.back();
      const bool is_mix = materials[at].kind == MaterialKind::mix;
      if (state[at] == open || state[at] == done || !is_mix) {
        state[at] = done;
        path.pop_back();
        continue;
      }
      state[at] = open;
      for (const std::uint32_t part : {materials[at].mix_a, materials[at].mix_b}) {
        if (part == kNone || state[part] == done) continue;
        if (state[part] == open) {
          const auto name = names_.find(materials[at].name);
          context_.diagnostics.error(name == names_.end() ? PbrtPlace() : name->second.first_use,
                                     fmt::format("the mix {} contains itself", in_quotes(materials[part].name)),
                                     "Mix materials that do not contain it.");
          materials[at].kind = MaterialKind::diffuse;
          break;
        }
        path.push_back(part);
      }
    }
  }
}

namespace {

/// The triangles of a mesh that are present, with their objects.
Geometry without_absent(Geometry mesh, const std::vector<Material>& materials) {
  Geometry kept;
  std::size_t count = 0;
  std::uint32_t object = kNone;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (is_absent(materials[mesh.material[t]])) continue;
    if (const std::uint32_t own = mesh.object_of(static_cast<std::uint32_t>(t)); own != object) {
      object = own;
      kept.objects.push_back({static_cast<std::uint32_t>(count), mesh.objects[own].name});
    }
    mesh.triangles[count] = mesh.triangles[t];
    mesh.material[count] = mesh.material[t];
    // pbrt's interfaces do not emit.
    const bool is_interface = materials[mesh.material[t]].kind == MaterialKind::interface;
    mesh.emission[count] = is_interface ? kNone : mesh.emission[t];
    ++count;
  }
  mesh.triangles.resize(count);
  mesh.material.resize(count);
  mesh.emission.resize(count);
  append_mesh(kept, mesh, "scene", 0, kNone);
  return kept;
}

/// Adds the instances of `all` to `kept`, without triangles that are absent.
void keep_instances(const Geometry& all, const std::vector<Material>& materials, Geometry& kept) {
  std::vector<std::uint32_t> number;  // of each mesh in `kept`
  for (const auto& mesh : all.meshes) {
    auto present = std::make_shared<const Geometry>(without_absent(*mesh, materials));
    number.push_back(present->triangles.empty() ? kNone : static_cast<std::uint32_t>(kept.meshes.size()));
    if (!present->triangles.empty()) kept.meshes.push_back(std::move(present));
  }
  auto object = all.instance_objects.begin();
  for (std::size_t i = 0; i < all.instances.size(); ++i) {
    const bool is_new = object != all.instance_objects.end() && object->first_triangle == i;
    Instance instance = all.instances[i];
    instance.mesh = number[instance.mesh];
    if (instance.mesh != kNone) {
      if (is_new) kept.instance_objects.push_back({static_cast<std::uint32_t>(kept.instances.size()), object->name});
      kept.instances.push_back(instance);
    }
    if (is_new) ++object;
  }
}

}  // namespace

void PbrtMaterialTable::remove_absent() {
  const auto& materials = context_.scene.materials;
  bool any = false;
  for (const Material& material : materials)
    any = any || is_absent(material) || material.kind == MaterialKind::interface;
  if (!any) return;
  Geometry& geometry = context_.scene.geometry;
  Geometry kept;
  keep_instances(geometry, materials, kept);
  const std::size_t before = geometry.triangles.size();
  Geometry present = without_absent(std::exchange(geometry, {}), materials);
  present.meshes = std::move(kept.meshes);
  present.instances = std::move(kept.instances);
  present.instance_objects = std::move(kept.instance_objects);
  geometry = std::move(present);
  if (geometry.triangles.size() < before) {
    context_.scene.notes.push_back(
        fmt::format("{} triangles of an \"interface\" material that parts no media or with an alpha of 0 were removed",
                    before - geometry.triangles.size()));
  }
}

void PbrtMaterialTable::finish() {
  for (const auto& [name, entry] : names_) {
    if (entry.defined) continue;
    context_.diagnostics.error(entry.first_use, fmt::format("there is no material {}", in_quotes(name)),
                               "Define it by MakeNamedMaterial.");
  }
  for (const Variant& variant : variants_) {
    Material material = context_.scene.materials[variant.base];
    material.inside = variant.media.inside;
    material.outside = variant.media.outside;
    material.unseen = variant.unseen;
    if (!is_absent(material)) material.alpha = product(context_.scene.textures, material.alpha, variant.alpha);
    context_.scene.materials[variant.index] = std::move(material);
  }
  check_mixes();
  if (context_.diagnostics.error_count() == 0) remove_absent();
}

}  // namespace glowworm
