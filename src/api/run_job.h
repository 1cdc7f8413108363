// Jobs by the public options.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "control/job.h"
#include "glowworm/render.h"
#include "settings/options.h"

namespace glowworm::api {

/// Names for RenderOptions::more of a command.
std::vector<std::string> option_names(Command command);

/// The settings that the options ask for. Bakes and measurements do not use the size, crop, camera and AOVs of a
/// picture. Throws Error for options that make no sense, or that the command does not have.
RenderSettings settings_of(const RenderOptions& options, Command command);

/// Waits for the end, and calls progress(share) ten times a second. Throws the job's error, and what `progress` throws;
/// the caller's destructor of the job then cancels it.
void attend(Job& job, const std::function<void(double)>& progress);

}  // namespace glowworm::api
