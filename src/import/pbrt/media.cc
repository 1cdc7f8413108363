#include "import/pbrt/media.h"

#include <fmt/format.h>

#include <utility>

#include "core/error.h"
#include "import/pbrt/cloud.h"
#include "import/pbrt/colors.h"
#include "import/pbrt/medium_presets.h"
#include "import/pbrt/transforms.h"
#include "import/voxel_grid.h"
#include "scene/scene_checks.h"

namespace glowworm {

namespace {

/// The coefficients of grids, where the file gives none.
constexpr MediumPreset kOne{{}, RGB(1.0f), RGB(1.0f)};

/// Builds the medium of one directive.
class MediumBuilder {
 public:
  MediumBuilder(PbrtContext& context, const PbrtParameters& parameters) : context_(context), parameters_(parameters) {}

  Medium build(const TransformDouble& to_world) {
    place(to_world);
    const std::string kind = parameters_.string("type", context_.v3 ? "" : "homogeneous");
    medium_.g = parameters_.real("g", 0);
    if (kind == "homogeneous") {
      homogeneous();
    } else if (kind == "uniformgrid" || kind == "heterogeneous") {
      uniform_grid();
    } else if (kind == "rgbgrid") {
      rgb_grid();
    } else if (kind == "cloud") {
      cloud();
    } else if (kind == "nanovdb") {
      file_grid();
    } else {
      parameters_.error(fmt::format("unknown type of medium {}", in_quotes(kind)),
                        "Supported: homogeneous, uniformgrid, rgbgrid, cloud, nanovdb and heterogeneous.");
    }
    return std::move(medium_);
  }

 private:
  void place(const TransformDouble& to_world) {
    if (!is_invertible(to_world)) {
      parameters_.error("the transform of the medium cannot be inverted", "A scale of 0?");
      return;
    }
    to_scene_ = to_world;
    to_scene_.translation = to_scene_.translation - Vec3d(context_.origin.origin());
    medium_.to_medium = inverse(to_scene_).relative_to({0, 0, 0});
  }

  RGB color(const char* name, PbrtColorUse use, RGB otherwise) {
    return color_or(context_, parameters_, name, use, otherwise);
  }

  /// Reads sigma_a and sigma_s, in units of the file as everything else. A preset stands before them in pbrt-v4, behind
  /// them in pbrt-v3. @param otherwise where the file gives neither
  void coefficients(const MediumPreset& otherwise) {
    const std::string name = parameters_.string("preset", "");
    const MediumPreset* const preset = name.empty() ? &otherwise : find_medium_preset(name);
    if (!preset)
      return parameters_.error(fmt::format("unknown preset {} of a medium", in_quotes(name)),
                               "Known: " + medium_preset_names() + ".");
    if (!name.empty())
      parameters_.note("coefficients per millimetre, as in pbrt taken per unit of the file: preset of a medium");
    medium_.sigma_a = preset->sigma_a;
    medium_.sigma_s = preset->sigma_s;
    if (name.empty() || context_.v3) {
      medium_.sigma_a = color("sigma_a", PbrtColorUse::unbounded, medium_.sigma_a);
      medium_.sigma_s = color("sigma_s", PbrtColorUse::unbounded, medium_.sigma_s);
    }
    scale();
  }
  void scale() {
    const float scale = parameters_.real("scale", 1);
    medium_.sigma_a *= scale;
    medium_.sigma_s *= scale;
  }

  /// The factor on emission. Old files for pbrt-v4 name it LeScale.
  float emission_scale() { return parameters_.real("Lescale", parameters_.real("LeScale", 1)); }
  /// The luminance that pbrt-v4's pictures give emission of 1 by temperatures and by grids of colours. It scales the
  /// spectra of lights, and of Le elsewhere, to luminance 1, but not these (pbrt-v4, media.cpp and film.h).
  static RGB unscaled_emission() { return RGB(static_cast<float>(luminance_of_constant_spectrum())); }

  void homogeneous() {
    medium_.emission = color("Le", PbrtColorUse::illuminant, RGB(0.0f)) * emission_scale();
    coefficients(*find_medium_preset("Wholemilk"));  // the default of pbrt
  }

  void bounds() {
    Box3 box;
    box.grow(narrow(parameters_.point3("p0", {0, 0, 0})));
    box.grow(narrow(parameters_.point3("p1", {1, 1, 1})));
    medium_.bounds = box;
  }
  /// Reads bounds and number of cells of a grid.
  void bounds(MediumGridValues& grid) {
    bounds();
    grid.size = {parameters_.integer("nx", 1), parameters_.integer("ny", 1), parameters_.integer("nz", 1)};
  }

  std::vector<float> numbers(const char* name) {
    const std::span<const double> given = parameters_.numbers(name, PbrtType::real);
    return {given.begin(), given.end()};
  }
  std::vector<RGB> colors(const char* name) {
    const std::span<const double> given = parameters_.numbers(name, PbrtType::rgb);
    std::vector<RGB> out;
    for (std::size_t i = 0; i + 2 < given.size(); i += 3)
      out.emplace_back(static_cast<float>(given[i]), static_cast<float>(given[i + 1]),
                       static_cast<float>(given[i + 2]));
    return out;
  }

  void finish(MediumGridValues grid) {
    try {
      medium_.grid = std::make_shared<const MediumGrid>(std::move(grid));
    } catch (const Error& error) {
      parameters_.error(error.what(), "");
    }
  }

  /// A density for each cell, and emission by a factor or a temperature for each cell.
  void uniform_grid() {
    MediumGridValues grid;
    bounds(grid);
    grid.density = numbers("density");
    coefficients(context_.v3 ? *find_medium_preset("Wholemilk") : kOne);
    const std::vector<float> scales = numbers(parameters_.find("Lescale") ? "Lescale" : "LeScale"),
                             temperatures = numbers("temperature");
    if (grid.density.empty() && temperatures.empty())
      return parameters_.error("a grid without density", "Give \"float density\", one value for each cell.");
    medium_.emission = color("Le", PbrtColorUse::illuminant, RGB(0.0f));
    if (!is_black(medium_.emission)) {
      for (const float scale : scales) grid.emission.emplace_back(scale);
      if (!temperatures.empty()) parameters_.error("a medium has both Le and temperature", "Give one of them.");
    } else if (!temperatures.empty()) {
      medium_.emission = unscaled_emission();
      black_bodies(temperatures, scales, grid.emission);
    }
    finish(std::move(grid));
  }

  /// Emission of black bodies, whose spectra are 1 at their peak as in pbrt-v4.
  void black_bodies(const std::vector<float>& temperatures, const std::vector<float>& scales, std::vector<RGB>& out) {
    constexpr float kLeast = 100, kMost = 1e7f;  // K: pbrt-v4 shows nothing colder
    const float offset = parameters_.real("temperatureoffset", parameters_.real("temperaturecutoff", 0));
    const float factor = parameters_.real("temperaturescale", 1);
    if (!scales.empty() && scales.size() != temperatures.size())
      return parameters_.error(
          fmt::format("{} values of LeScale for {} temperatures", scales.size(), temperatures.size()),
          "Give one for each.");
    if (!temperatures.empty())
      parameters_.note("colours are interpolated between cells, not temperatures: medium with temperatures");
    for (std::size_t i = 0; i < temperatures.size(); ++i) {
      const float kelvin = (temperatures[i] - offset) * factor;
      const float scale = scales.empty() ? 1 : scales[i];
      if (kelvin > kLeast) {
        const RGB color = blackbody_rgb_of_peak(std::min(kelvin, kMost)) * scale;
        // Red of low temperatures lies outside the triangle of colours.
        out.push_back({std::max(color.r, 0.0f), std::max(color.g, 0.0f), std::max(color.b, 0.0f)});
      } else {
        out.emplace_back(kelvin <= kLeast ? 0.0f : kelvin);  // NaN stays, for the check
      }
    }
  }

  void rgb_grid() {
    MediumGridValues grid;
    bounds(grid);
    grid.sigma_a = colors("sigma_a");
    grid.sigma_s = colors("sigma_s");
    grid.emission = colors("Le");
    if (grid.sigma_a.empty() && grid.sigma_s.empty())
      return parameters_.error("a grid without coefficients", "Give \"rgb sigma_a\" or sigma_s for each cell.");
    medium_.sigma_a = medium_.sigma_s = RGB(1.0f);
    scale();
    medium_.emission = grid.emission.empty() ? RGB(0.0f) : unscaled_emission() * emission_scale();
    finish(std::move(grid));
  }

  void cloud() {
    bounds();
    coefficients(kOne);
    PbrtCloud cloud;
    cloud.density = parameters_.real("density", cloud.density);
    cloud.wispiness = parameters_.real("wispiness", cloud.wispiness);
    cloud.frequency = parameters_.real("frequency", cloud.frequency);
    for (const float value : {cloud.density, cloud.wispiness, cloud.frequency})
      if (!(value >= 0 && value <= 1e6f))
        return parameters_.error(fmt::format("a number of a cloud is {:g}", value), "Give 0 to a million.");
    parameters_.note("its noise is another than pbrt's, so its shape is: medium \"cloud\"");
    finish(cloud_grid(cloud, *medium_.bounds, *context_.budget));
  }

  /// A grid of a NanoVDB or OpenVDB file. The medium's own coordinates count its voxels.
  void file_grid() {
    coefficients(kOne);
    const std::string path = context_.resolve(parameters_.string("filename", ""), parameters_.place());
    try {
      VoxelGrid read = read_voxel_grid(path, parameters_.string("gridname", "density"), *context_.budget);
      const TransformDouble of_voxels = to_scene_ * read.to_world;
      if (!is_invertible(of_voxels)) return parameters_.error("the transform of the grid cannot be inverted", "");
      place_medium(read, of_voxels, medium_);
      MediumGridValues grid;
      grid.size = read.size;
      file_temperatures(path, read, grid);
      grid.density = std::move(read.values);
      finish(std::move(grid));
    } catch (const MemoryError&) {
      throw;
    } catch (const Error& error) {
      parameters_.error(error.what(), "");
    }
  }

  /// Emission by the temperatures of a file, at the cells of its density.
  void file_temperatures(const std::string& path, const VoxelGrid& density, MediumGridValues& grid) {
    const std::string name = parameters_.string("temperaturename", "temperature");
    const float scale = emission_scale();
    if (!has_voxel_grid(path, name, *context_.budget)) return black_bodies({}, {}, grid.emission);
    const VoxelGrid read = read_voxel_grid(path, name, *context_.budget);
    const TransformDouble map = inverse(read.to_world) * density.to_world;
    std::vector<float> kelvin;
    kelvin.reserve(grid.cell_count());
    for (int z = 0; z < grid.size[2]; ++z)
      for (int y = 0; y < grid.size[1]; ++y)
        for (int x = 0; x < grid.size[0]; ++x)
          kelvin.push_back(read.at(map.point(Vec3d(x + density.first[0], y + density.first[1], z + density.first[2]))));
    medium_.emission = unscaled_emission() * scale;
    black_bodies(kelvin, {}, grid.emission);
  }

  PbrtContext& context_;
  const PbrtParameters& parameters_;
  TransformDouble to_scene_;
  Medium medium_;
};

}  // namespace

Medium make_medium(PbrtContext& context, const PbrtParameters& parameters, const TransformDouble& to_world) {
  return MediumBuilder(context, parameters).build(to_world);
}

std::uint32_t PbrtMediumTable::next_index() {
  context_.scene.media.emplace_back();
  return static_cast<std::uint32_t>(context_.scene.media.size() - 1);
}

void PbrtMediumTable::define(const std::string& name, const PbrtParameters& parameters,
                             const TransformDouble& to_world) {
  Medium medium = make_medium(context_, parameters, to_world);
  medium.name = name;
  try {
    check_medium(medium, 0);
  } catch (const Error& error) {
    parameters.error(error.what(), "");
  }
  Name& entry = names_[name];
  if (entry.defined)
    context_.diagnostics.note(parameters.place(),
                              fmt::format("defined again, later uses take the new one: medium {}", in_quotes(name)));
  if (entry.defined || !entry.first_use.file) entry.index = next_index();
  entry.defined = true;
  entry.first_use = parameters.place();
  context_.scene.media[entry.index] = std::move(medium);
}

std::uint32_t PbrtMediumTable::by_name(const std::string& name, const PbrtPlace& place) {
  if (name.empty()) return kNone;
  Name& entry = names_[name];
  if (!entry.defined && !entry.first_use.file) {
    entry.index = next_index();
    entry.first_use = place;
  }
  return entry.index;
}

PbrtMediumSides PbrtMediumTable::sides(const std::string& inside, const std::string& outside, const PbrtPlace& place) {
  const PbrtMediumSides sides{by_name(inside, place), by_name(outside, place)};
  return sides.inside == sides.outside ? PbrtMediumSides() : sides;
}

void PbrtMediumTable::finish() {
  for (const auto& [name, entry] : names_) {
    if (entry.defined) continue;
    context_.diagnostics.error(entry.first_use, fmt::format("there is no medium {}", in_quotes(name)),
                               "Define it by MakeNamedMedium.");
  }
}

}  // namespace glowworm
