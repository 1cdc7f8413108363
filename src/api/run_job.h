// Jobs by the public options.
#pragma once
#include <functional>

#include "glowworm/render.h"
#include "render/job.h"

namespace glowworm::api {

/// The settings that the options ask for. Throws Error for options that make no sense.
RenderSettings settings_of(const RenderOptions& options);

/// Waits for the end, and calls progress(share) ten times a second. Throws the job's error, and what `progress` throws;
/// the caller's destructor of the job then cancels it.
void attend(Job& job, const std::function<void(double)>& progress);

}  // namespace glowworm::api
