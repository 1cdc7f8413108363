#include "import/ies/luminaire.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/error.h"
#include "core/input_file.h"
#include "core/text.h"

namespace glowworm {

namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw Error(
      fmt::format("--light '{}' does not say where the luminaire is", text),
      "Write FILE.ies@X,Y,Z, or FILE.ies@X,Y,Z,DX,DY,DZ[,TURN] with the way it aims (downwards without) and its "
      "turn around that in degrees; behind that, ,scale=F ,maintenance=F ,lamps=NAME or ,opening=off.");
}

/// Takes the changes from the end of a text, from the last to the first.
void take_changes(std::string& text, LuminaireText& out) {
  for (std::size_t equals; (equals = text.rfind('=')) != std::string::npos && equals > text.rfind('@');) {
    const std::size_t comma = text.rfind(',', equals);
    if (comma == std::string::npos || comma < text.rfind('@')) refuse(text);
    const std::string key = text.substr(comma + 1, equals - comma - 1), value = text.substr(equals + 1);
    const std::vector<float> number = numbers_of<float>(value);
    if ((key == "scale" || key == "maintenance") && number.size() == 1 && number[0] >= 0)
      out.factor *= number[0];
    else if (key == "lamps" && !value.empty())
      out.lamps = value;
    else if (key == "opening" && (value == "off" || value == "on"))
      out.point = value == "off";
    else
      refuse(text);
    text.resize(comma);
  }
}

/// The side of the table's x for an aim (unit, y up).
Vec3 right_of(TablePole pole, Vec3 aim) {
  if (pole != TablePole::forward) {
    const Vec3 right = cross(aim, {0, 1, 0});
    return length(right) > 1e-4f ? normalize(right) : Vec3{1, 0, 0};
  }
  // The shortest turn of (0, -1, 0) to the aim, of x. Straight up, any turn is the shortest: that around z is taken.
  const float share = aim.x / std::max(1 - aim.y, 1e-6f);
  return normalize(Vec3{1 - aim.x * share, share * (1 - aim.y), -aim.z * share});
}

}  // namespace

bool is_photometric_file(const std::string& path) {
  const std::string ending = lower_ending(path);
  return ending == ".ies" || ending == ".ldt";
}

PhotometricFile read_photometric_file(const std::string& path, const std::string& lamps) {
  const std::string text = read_input_file(path);
  try {
    if (lower_ending(path) == ".ldt") return parse_eulumdat(text, path, lamps);
    if (!lamps.empty() && lamps != "1") throw Error({path}, "an IES file has one set of lamps", "Leave lamps= out.");
    return parse_lm63(text, path);
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.find(path) != std::string::npos) throw;
    throw Error(FilePlace{path}, message);
  }
}

Light read_luminaire(const std::string& path, const std::string& lamps) {
  PhotometricFile file = read_photometric_file(path, lamps);
  Light light;
  light.kind = LightKind::luminaire;
  light.name = std::filesystem::path(path).filename().string();
  light.intensity = RGB(1 / kLuminousEfficacy);
  light.direction = {0, -1, 0};
  light.right = {1, 0, 0};
  light.table = std::make_shared<const IntensityTable>(std::move(file.table));
  light.opening = file.opening;
  return light;
}

void mirror_luminaire(Light& light) { light.table = std::make_shared<const IntensityTable>(light.table->mirrored()); }

bool is_luminaire_text(const std::string& text) {
  const std::size_t at = text.rfind('@');
  return at != std::string::npos && is_photometric_file(text.substr(0, at));
}

LuminaireText parse_luminaire_text(const std::string& text) {
  LuminaireText out;
  std::string rest = text;
  take_changes(rest, out);
  const std::size_t at = rest.rfind('@');
  if (at == std::string::npos) refuse(text);
  const std::vector<double> v = numbers_of<double>(std::string_view(rest).substr(at + 1));
  if (v.size() != 3 && v.size() != 6 && v.size() != 7) refuse(text);
  out.path = rest.substr(0, at);
  out.place = {v[0], v[1], v[2]};
  out.aimed = v.size() > 3;
  if (out.aimed) out.aim = {v[3], v[4], v[5]};
  if (v.size() > 6) out.turn = v[6];
  if (!(length_squared(narrow(out.aim)) > 0)) refuse(text);
  return out;
}

Light luminaire_of_text(const std::string& text, bool z_up, Vec3 origin) {
  const LuminaireText parsed = parse_luminaire_text(text);
  const auto in_scene = [&](Vec3d given) { return z_up ? y_up_from_z_up(given) : given; };
  Light light = read_luminaire(parsed.path, parsed.lamps);
  light.intensity *= parsed.factor;
  if (parsed.point) light.opening = {};
  light.position = narrow(in_scene(parsed.place) - Vec3d(origin));
  light.direction = normalize(narrow(parsed.aimed ? in_scene(parsed.aim) : parsed.aim));
  const Vec3 right = right_of(light.table->pole(), light.direction), up = cross(right, light.direction);
  const float turn = static_cast<float>(parsed.turn) * kPi / 180;
  light.right = right * std::cos(turn) + up * std::sin(turn);
  return light;
}

}  // namespace glowworm
