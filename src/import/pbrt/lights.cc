#include "import/pbrt/lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/interrupt.h"
#include "core/memory_budget.h"
#include "image/image_file.h"
#include "import/ies/luminaire.h"
#include "import/pbrt/textures.h"
#include "scene/environment.h"
#include "scene/environment_bytes.h"
#include "scene/light_power.h"

namespace glowworm {

namespace {

/// A light's colour: the parameter `name` times the scale, which can be a colour in pbrt-v3.
RGB light_color(PbrtContext& context, const PbrtParameters& parameters, const char* name) {
  const RGB color = color_or(context, parameters, name, PbrtColorUse::illuminant, RGB(1.0f));
  const RGB scaled = color * color_or(context, parameters, "scale", PbrtColorUse::unbounded, RGB(1.0f));
  if (luminance(scaled) >= 0) return scaled;
  parameters.error(fmt::format("the light is negative: ({:g}, {:g}, {:g})", scaled.r, scaled.g, scaled.b),
                   "Give it a positive value.");
  return RGB(0.0f);
}

/// Normalises a vector, or reports an error at the directive.
Vec3 direction_or_error(const PbrtParameters& parameters, Vec3 v) {
  const float l = length(v);
  if (l > 0 && std::isfinite(l)) return v / l;
  parameters.error("the light has no direction: \"from\" and \"to\" are the same",
                   "Give two points apart from each other.");
  return {0, 0, -1};
}

/// The rotation, perhaps mirrored, of `to_world` without its scale.
Transform rotation_of(const PbrtParameters& parameters, const Transform& to_world) {
  Transform out;
  out.x = direction_or_error(parameters, to_world.x);
  out.y = direction_or_error(parameters, to_world.y - out.x * dot(to_world.y, out.x));
  const Vec3 z = cross(out.x, out.y);
  out.z = dot(z, to_world.z) < 0 ? -z : z;
  return out;
}

class LightBuilder {
 public:
  LightBuilder(PbrtContext& context, const PbrtParameters& parameters, const TransformDouble& to_world)
      : context_(context), parameters_(parameters), exact_(to_world), to_world_(to_world.relative_to({0, 0, 0})) {}

  void build(const std::string& kind) {
    if (kind == "point") return point();
    if (kind == "spot") return spot();
    if (kind == "distant") return distant();
    if (kind == "infinite" || kind == "exinfinite") return infinite();
    if (kind == "goniometric") {
      if (is_photometric_file(parameters_.string("filename", ""))) return photometric();
      parameters_.use_all();
      parameters_.note("not supported, read as a point light: goniometric light");
      return point();
    }
    if (kind == "projection") {
      parameters_.use_all();
      return parameters_.note("not supported, left out: projection light");
    }
    parameters_.error(fmt::format("unknown light {}", in_quotes(kind)),
                      "Supported: point, spot, distant and infinite.");
  }

 private:
  /// The name of the light, a parameter of Glowworm that pbrt ignores in an Attribute. Lights without one get numbers.
  std::string name() { return parameters_.string("name", ""); }

  /// The intensity (W sr^-1) of a light. If "power" is given, intensity is scaled to it; `steradians` is the light's
  /// integral over directions divided by its maximum.
  RGB intensity(float steradians) {
    const RGB color = light_color(context_, parameters_, "I");
    const float power = parameters_.real("power", -1);
    return power > 0 ? color * (power / steradians) : color;
  }

  Vec3 place_of(Vec3d point) const { return context_.origin.relative(exact_.point(point)); }

  void point() {
    Light light;
    light.name = name();
    light.kind = LightKind::point;
    light.intensity = intensity(4 * kPi);
    light.position = place_of(parameters_.point3("from", {0, 0, 0}));
    context_.scene.lights.push_back(light);
  }

  /// A photometric file in place of the image: the light aims along its own -z.
  void photometric() {
    Light light;
    try {
      light = read_luminaire(context_.resolve(parameters_.string("filename", ""), parameters_.place()));
    } catch (const Error& error) {
      parameters_.error("the photometric file cannot be read: " + first_line(error.what()),
                        "Put a whole file where the scene says, or leave the light out.");
      return;
    }
    if (const std::string given = name(); !given.empty()) light.name = given;
    light.opening = {};  // pbrt's are points
    light.intensity *= light_color(context_, parameters_, "I");
    light.position = place_of({0, 0, 0});
    light.direction = direction_or_error(parameters_, to_world_.vector({0, 0, -1}));
    light.right = direction_or_error(parameters_, to_world_.vector({1, 0, 0}));
    if (to_world_.determinant() < 0) mirror_luminaire(light);
    const float power = parameters_.real("power", -1);
    const float own = luminance(light_power(light, 0));
    if (power > 0 && own > 0) light.intensity *= power / own;
    context_.scene.lights.push_back(light);
  }

  void spot() {
    Light light;
    light.name = name();
    light.kind = LightKind::spot;
    const float cone = parameters_.real("coneangle", 30);
    const float delta = parameters_.real("conedeltaangle", 5);
    if (!(cone > 0 && cone <= 180) || !(delta >= 0)) {
      parameters_.error("a spot light needs a coneangle between 0 and 180 degrees",
                        "Give \"float coneangle\" and \"float conedeltaangle\".");
      return;
    }
    light.cos_outer = std::cos(cone * kPi / 180);
    light.cos_inner = std::cos(std::max(cone - delta, 0.0f) * kPi / 180);
    if (context_.v3) light.falloff = SpotFalloff::quartic;
    const float steradians =
        2 * kPi * ((1 - light.cos_inner) + (light.cos_inner - light.cos_outer) * mean_spot_falloff(light));
    light.intensity = intensity(steradians);
    const Vec3d from = parameters_.point3("from", {0, 0, 0}), to = parameters_.point3("to", {0, 0, 1});
    light.position = place_of(from);
    light.direction = direction_or_error(parameters_, to_world_.vector(narrow(to - from)));
    context_.scene.lights.push_back(light);
  }

  void distant() {
    Light light;
    light.name = name();
    light.kind = LightKind::directional;
    light.intensity = light_color(context_, parameters_, "L");
    const float illuminance = parameters_.real("illuminance", -1);
    if (illuminance > 0) light.intensity *= illuminance;
    const Vec3d from = parameters_.point3("from", {0, 0, 0}), to = parameters_.point3("to", {0, 0, 1});
    light.direction = direction_or_error(parameters_, to_world_.vector(narrow(to - from)));
    context_.scene.lights.push_back(light);
  }

  void infinite() {
    Environment environment;
    environment.name = name();
    const std::string file = parameters_.string("filename", parameters_.string("mapname", ""));
    static_cast<void>(parameters_.find("samples"));
    if (parameters_.has("portal"))
      parameters_.note("not needed, the whole sky is sampled: portal of an infinite light");
    environment.scale = light_color(context_, parameters_, "L");
    environment.to_world = rotation_of(parameters_, to_world_);
    std::unique_ptr<Reservation> earlier = std::move(context_.sky);
    if (!file.empty()) read_image(environment, file);
    const float illuminance = parameters_.real("illuminance", -1);
    // A hemisphere of radiance 1 gives an irradiance of pi.
    if (illuminance > 0) environment.scale *= illuminance / (kPi * mean_luminance(environment));
    std::optional<Environment>& all = context_.scene.environment;
    if (all) {
      parameters_.note("infinite lights are added up to one");
      if (all->pixels.size() >= environment.pixels.size()) context_.sky = std::move(earlier);
      environment = sum_of(*all, environment);
    }
    all = std::move(environment);
  }

  /// Mean luminance of the image over the hemisphere around the light's +z, weighted by the cosine; 1 for a constant.
  static float mean_luminance(const Environment& environment) {
    if (environment.pixels.empty()) return 1;
    double sum = 0, weight = 0;
    for (int y = 0; y < environment.height; ++y) {
      for (int x = 0; x < environment.width; ++x) {
        const double cosine = cosine_of(environment, x, y);
        if (cosine <= 0) continue;
        const double w = cosine * (environment.mapping == EnvironmentMapping::lat_long
                                       ? std::sin((y + 0.5) / environment.height * kPi)
                                       : 1.0);
        sum += w * luminance(environment.pixels[static_cast<std::size_t>(y) * environment.width + x]);
        weight += w;
      }
    }
    return sum > 0 ? static_cast<float>(sum / weight) : 1;
  }

  /// Cosine to the light's +z at a pixel's centre (for square images: Clarberg, "Fast Equal-Area Mapping of the
  /// (Hemi)Sphere using SIMD", 2008).
  static double cosine_of(const Environment& environment, int x, int y) {
    const double v = (y + 0.5) / environment.height;
    if (environment.mapping == EnvironmentMapping::lat_long) return std::cos(v * kPi);
    const double u = 2 * (x + 0.5) / environment.width - 1;
    const double distance = 1 - (std::fabs(u) + std::fabs(2 * v - 1));
    const double r = 1 - std::fabs(distance);
    return std::copysign(1 - r * r, distance);
  }

  /// The image of a light. If it cannot be read, reports an error and returns null: no colour can replace a sky.
  std::shared_ptr<const TextureImage> needed_image(const std::string& path) {
    try {
      return context_.load_needed_image(path, default_image_options(path), StandIn::magenta);
    } catch (const MemoryError&) {
      throw;
    } catch (const MissingReader&) {
      throw;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      parameters_.error("the image of an infinite light cannot be read: " + first_line(error.what()),
                        "Put the file there, or remove the light.");
      return nullptr;
    }
  }

  /// Square images are equal-area maps, as in pbrt-v4; images of twice that width are lat-long maps.
  void read_image(Environment& environment, const std::string& file) {
    const std::string path = context_.resolve(file, parameters_.place());
    const auto image = needed_image(path);
    if (!image) return;
    environment.width = image->width();
    environment.height = image->height();
    const std::size_t pixels = static_cast<std::size_t>(environment.width) * environment.height;
    context_.sky = std::make_unique<Reservation>(*context_.budget, "sky", environment_bytes(pixels));
    environment.pixels.reserve(pixels);
    for (int y = 0; y < environment.height; ++y) {
      for (int x = 0; x < environment.width; ++x) {
        environment.pixels.push_back(
            image->color({(x + 0.5f) / environment.width, 1 - (y + 0.5f) / environment.height}));
      }
    }
    if (environment.width == environment.height && !context_.v3) {
      environment.mapping = EnvironmentMapping::equal_area;
      return;
    }
    if (!context_.v3) parameters_.note("taken as a lat-long map, since it is not square: image of an infinite light");
    environment.mapping = EnvironmentMapping::lat_long;
    // pbrt's lat-long maps have z up and run from +x towards +y; Environment's have y up and run from +z towards -x.
    environment.to_world = environment.to_world * Transform{{0, -1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0, 0}};
  }

  PbrtContext& context_;
  const PbrtParameters& parameters_;
  TransformDouble exact_;
  Transform to_world_;  ///< for directions
};

float image_luminance(const TextureImage& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      sum += luminance(image.color({(x + 0.5f) / image.width(), (y + 0.5f) / image.height()}));
    }
  }
  return static_cast<float>(sum / (static_cast<double>(image.width()) * image.height()));
}

}  // namespace

void add_light(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
               const TransformDouble& to_world) {
  LightBuilder(context, parameters, to_world).build(kind);
  parameters.note_unused(fmt::format("light {}", in_quotes(kind)));
}

PbrtAreaLight make_area_light(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters) {
  PbrtAreaLight light;
  if (kind != "diffuse" && kind != "area") {
    parameters.error(fmt::format("unknown area light {}", in_quotes(kind)), "The only area light is \"diffuse\".");
    return light;
  }
  light.emission.name = parameters.string("name", "");
  light.emission.radiance.value = light_color(context, parameters, "L");
  light.emission.two_sided = parameters.boolean("twosided", false);
  light.power = std::max(parameters.real("power", 0), 0.0f);
  const std::string file = parameters.string("filename", "");
  if (!file.empty()) {
    light.emission.radiance.texture =
        add_image_texture(context, parameters, file, default_image_options(file), StandIn::none);
    const TextureImage& image = *context.scene.textures[light.emission.radiance.texture].image;
    if (light.power > 0) light.image_luminance = std::max(image_luminance(image), 1e-20f);
  }
  static_cast<void>(parameters.find("samples"));
  static_cast<void>(parameters.find("nsamples"));
  parameters.note_unused("the area light");
  return light;
}

std::uint32_t add_emission(PbrtContext& context, PbrtAreaLight& light, double area) {
  auto& emissions = context.scene.emissions;
  if (light.power <= 0 && light.shared != kNone) return light.shared;
  Emission emission = light.emission;
  if (light.power > 0) {
    const double full = area * kPi * light.image_luminance * (emission.two_sided ? 2 : 1);
    emission.radiance.value *= full > 0 ? static_cast<float>(light.power / full) : 0.0f;
  }
  emissions.push_back(emission);
  const auto index = static_cast<std::uint32_t>(emissions.size() - 1);
  if (light.power <= 0) light.shared = index;
  return index;
}

}  // namespace glowworm
