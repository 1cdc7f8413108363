// Cameras and films of pbrt scenes.
#pragma once
#include <string>
#include <string_view>

#include "core/shutter.h"
#include "core/transform.h"
#include "import/pbrt/context.h"

namespace glowworm {

/// Makes the camera of a Camera directive. @param to_world inverse of the current transform
Camera make_camera(const std::string& kind, const PbrtParameters& parameters, const Transform& to_world);

/// Moves a camera that make_camera() made. @param to_world inverse of the transform at its directive
void place_camera(Camera& camera, const Transform& to_world);

/// Sets the camera's screen window from "frameaspectratio", if given.
void set_frame_aspect(Camera& camera, const PbrtParameters& parameters);

/// When the shutter opens and closes, s; 0 and 1 if not given.
Shutter shutter_of(const PbrtParameters& camera_parameters);
/// Exposure time in seconds, 1 if it is not positive.
float exposure_time(const PbrtParameters& camera_parameters);

/// Reads the supported settings of a directive Sampler, Integrator or PixelFilter, and notes the others.
/// @param kind the directive's type, for example "halton"
void note_render_settings(std::string_view directive, const std::string& kind, const PbrtParameters& parameters,
                          FilmRequest& film);

/// The picture settings of a Film directive. @param exposure_seconds of the camera
FilmRequest make_film(const std::string& kind, const PbrtParameters& parameters, float exposure_seconds);

}  // namespace glowworm
