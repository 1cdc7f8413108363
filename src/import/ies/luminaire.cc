#include "import/ies/luminaire.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "core/input_file.h"
#include "core/text.h"

namespace glowworm {

namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw Error(
      fmt::format("--light '{}' does not say where the luminaire is", text),
      "Write FILE.ies@X,Y,Z, or FILE.ies@X,Y,Z,DX,DY,DZ[,TURN] with the way it aims (downwards without) and its "
      "turn around that in degrees.");
}

}  // namespace

bool is_photometric_file(const std::string& path) {
  const std::string ending = lower_ending(path);
  return ending == ".ies" || ending == ".ldt";
}

Light read_luminaire(const std::string& path) {
  const std::string text = read_input_file(path);
  Light light;
  light.kind = LightKind::luminaire;
  light.name = std::filesystem::path(path).filename().string();
  light.intensity = RGB(1 / kLuminousEfficacy);
  light.direction = {0, -1, 0};
  light.right = {1, 0, 0};
  try {
    light.table = std::make_shared<const IntensityTable>(lower_ending(path) == ".ldt" ? parse_eulumdat(text, path)
                                                                                      : parse_lm63(text, path));
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.find(path) != std::string::npos) throw;
    throw Error(FilePlace{path}, message);
  }
  return light;
}

bool is_luminaire_text(const std::string& text) {
  const std::size_t at = text.rfind('@');
  return at != std::string::npos && is_photometric_file(text.substr(0, at));
}

Light luminaire_of_text(const std::string& text, bool z_up, Vec3 origin) {
  const std::size_t at = text.rfind('@');
  if (at == std::string::npos) refuse(text);
  const std::vector<double> v = numbers_of<double>(std::string_view(text).substr(at + 1));
  if (v.size() != 3 && v.size() != 6 && v.size() != 7) refuse(text);
  const auto in_scene = [&](std::size_t i) {
    const Vec3d given{v[i], v[i + 1], v[i + 2]};
    return z_up ? y_up_from_z_up(given) : given;
  };
  const Vec3 aim = v.size() > 3 ? narrow(in_scene(3)) : Vec3{0, -1, 0};
  if (!(length_squared(aim) > 0)) refuse(text);
  Light light = read_luminaire(text.substr(0, at));
  light.position = narrow(in_scene(0) - Vec3d(origin));
  light.direction = normalize(aim);
  // Seen along a level aim, x of the table is to the right; straight down or up, it is the scene's x.
  Vec3 right = cross(light.direction, {0, 1, 0});
  right = length(right) > 1e-4f ? normalize(right) : Vec3{1, 0, 0};
  const Vec3 up = cross(right, light.direction);
  const float turn = v.size() > 6 ? static_cast<float>(v[6]) * kPi / 180 : 0;
  light.right = right * std::cos(turn) + up * std::sin(turn);
  return light;
}

}  // namespace glowworm
