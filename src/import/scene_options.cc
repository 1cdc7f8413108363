#include <fmt/format.h>

#include "core/error.h"
#include "core/names.h"
#include "core/text.h"
#include "import/haze.h"
#include "import/material_text.h"
#include "import/scene_changes.h"
#include "import/sky_text.h"
#include "import/volume_text.h"

namespace glowworm {

namespace {

/// Parses a number between two bounds. Throws Error that names the option.
float parse_number(const char* name, const std::string& text, float least, float most) {
  const std::vector<float> value = numbers_of<float>(text);
  if (value.size() != 1 || value[0] < least || value[0] > most)
    throw Error(fmt::format("{} '{}' is not a number from {:g} to {:g}", name, text, least, most));
  return value[0];
}

constexpr SceneOption kSceneOptions[] = {
    {"--environment", "FILE|R,G,B",
     "Replace the scene's environment light: a lat-long image (.exr, .hdr), a square "
     "equal-area image, or a radiance (W sr^-1 m^-2)",
     [](SceneChanges& c, const std::string& text) { parse_environment(text, c); }},
    {"--sky", "cie:TYPE,...|perez:...|epw:FILE,...",
     "A sky in place of the environment: cie:TYPE[,ALTITUDE,AZIMUTH[,LUX[,GROUND]]] is a CIE general sky (1-15) or "
     "overcast (16); perez:DIRECT,DIFFUSE,MONTH,DAY,HOUR,LATITUDE,LONGITUDE,ZONE[,GROUND] has W m^-2; "
     "epw:FILE,MONTH,DAY,HOUR[,GROUND] an hour (1-24) of a weather file; -z is north",
     [](SceneChanges& c, const std::string& text) {
       check_sky(text);
       c.sky = text;
     }},
    {"--environment-turn", "DEGREES [0]", "Rotate the environment to the left; with --sky, its sun, too",
     [](SceneChanges& c, const std::string& text) {
       c.environment_turn = parse_number("--environment-turn", text, -3600, 3600);
     }},
    {"--environment-scale", "F [1]", "Multiply the environment's radiance",
     [](SceneChanges& c, const std::string& text) {
       c.environment_scale = parse_number("--environment-scale", text, 0, 1e9f);
     }},
    {"--studio-light", "on|off [on]", "Light a scene without lights as in a studio",
     [](SceneChanges& c, const std::string& text) {
       c.studio_light = name_index("--studio-light", text, {"off", "on"}) == 1;
     }},
    {"--material", "NAME,tau=T[,rho=R]|NAME,bsdf=FILE",
     "Make a material a pane of glass that transmits T and reflects R at normal incidence, or give it the matrices of "
     "an XML file of BSDF data, whose front is the side of the room (WINDOW's back); may be repeated",
     [](SceneChanges& c, const std::string& text) {
       check_material_text(text);
       c.materials.push_back(text);
     },
     true},
    {"--lamp-openings", "on|off [on]",
     "Give luminaires the luminous opening of their photometric files: it shines as far as it is seen, and lets all "
     "other light pass; off: they are points",
     [](SceneChanges& c, const std::string& text) {
       c.luminous_openings = name_index("--lamp-openings", text, {"off", "on"}) == 1;
     }},
    {"--instances", "keep|expand [keep]",
     "Keep one copy of a mesh that the file places many times, or copy it each time",
     [](SceneChanges& c, const std::string& text) {
       c.expand_instances = name_index("--instances", text, {"keep", "expand"}) == 1;
     }},
    {"--haze", "VISIBILITY", "Haze around the scene, for example 200m or 2km: the distance at which contrast is 2%",
     [](SceneChanges& c, const std::string& text) { c.visibility = length_of_text("--haze", text); }},
    {"--volume", "FILE[,scale=S][,albedo=A]",
     "Smoke around the surfaces: the grid 'density' of a .vdb or .nvdb file, in the axes and the unit of the scene "
     "file. S [1] times density is the extinction per unit, of which A [0.5] is scattered",
     [](SceneChanges& c, const std::string& text) {
       check_volume_text(text);
       c.volume = text;
     }},
    {"--up", "y|z [y; z of .rad]",
     "Axis of the file that points up; places and directions of other options have it, too",
     [](SceneChanges& c, const std::string& text) {
       if (text != "y" && text != "z") throw Error(fmt::format("--up '{}' is neither y nor z", text));
       c.z_up = text == "z";
     }},
    {"--scale", "M [1]", "Metres per unit of the file; lights keep their power",
     [](SceneChanges& c, const std::string& text) { c.metres_per_unit = parse_number("--scale", text, 1e-9f, 1e9f); }},
    {"--fov", "DEGREES", "Angle of view along the picture's shorter side",
     [](SceneChanges& c, const std::string& text) { c.field_of_view = parse_number("--fov", text, 0.01f, 360); }},
    {"--projection", "perspective|fisheye|hemispherical|panorama",
     "How all cameras see: fisheye is equidistant (Radiance's -vta), hemispherical its -vth, panorama equirectangular; "
     "these show 180 degrees along the shorter side, unless --fov says otherwise",
     [](SceneChanges& c, const std::string& text) {
       constexpr CameraKind kKinds[] = {CameraKind::perspective, CameraKind::fisheye, CameraKind::hemispherical,
                                        CameraKind::panorama};
       c.projection = kKinds[name_index("--projection", text, {"perspective", "fisheye", "hemispherical", "panorama"})];
     }},
    {"--animation", "NAME", "Animation of a glTF file, by name or number, for --at and --frames",
     [](SceneChanges& c, const std::string& text) { c.moment.animation = text; }},
    {"--at", "SECONDS [0]", "Moment of the animation that is shown",
     [](SceneChanges& c, const std::string& text) { c.moment.seconds = parse_number("--at", text, 0, 1e9f); }},
    {"--view-file", "FILE", "Cameras of a Radiance file of views (.vf), 'view 1' and so on, before those of the scene",
     [](SceneChanges& c, const std::string& text) { c.view_file = text; }},
    {"--look-at", "X,Y,Z,X,Y,Z", "Place the scene's first camera: eye and target (m)",
     [](SceneChanges& c, const std::string& text) { c.look_at = parse_look_at(text); }},
};

}  // namespace

std::span<const SceneOption> scene_options() { return kSceneOptions; }

}  // namespace glowworm
