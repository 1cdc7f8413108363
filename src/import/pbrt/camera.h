// Cameras and films of pbrt scenes.
#pragma once
#include <string>
#include <string_view>

#include "core/transform.h"
#include "import/pbrt/context.h"

namespace glowworm {

/// The camera of a Camera directive. @param to_world inverse of the transform in force there
Camera make_camera(const std::string& kind, const PbrtParameters& parameters, const Transform& to_world);

/// Gives the camera the screen window that a "frameaspectratio" stands for, if it has one.
void set_frame_aspect(Camera& camera, const PbrtParameters& parameters);

/// Seconds that the shutter is open, 1 where the file does not say.
float exposure_time(const PbrtParameters& camera_parameters);

/// Takes what is used of a directive Sampler, Integrator or PixelFilter, and notes what is not.
/// @param kind the directive's type, as "halton"
void note_render_settings(std::string_view directive, const std::string& kind, const PbrtParameters& parameters,
                          FilmRequest& film);

/// The picture that a Film directive asks for. @param exposure_seconds of the camera
FilmRequest make_film(const std::string& kind, const PbrtParameters& parameters, float exposure_seconds);

}  // namespace glowworm
