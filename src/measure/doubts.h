// What is likely wrong with a measurement before and after it runs.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "measure/measurement.h"

namespace glowworm {

/// The scene as sensors measure it: without the light that shows scenes that have none (Environment::stands_in).
std::shared_ptr<const Scene> lit_by_its_own(const std::shared_ptr<const Scene>& scene);

/// What a user hardly means, a sentence each: a scene without light, a room of more than a hundred metres in height,
/// sensors outside of the room, and lights that hang outside of it or behind a surface where no sensor sees them.
std::vector<std::string> doubts_before(const Sensors& sensors, const Tracer& tracer);

/// A sentence on sensors that measured no light at all, or nothing. @param measured of a scene
std::vector<std::string> doubts_after(const Measurement& measured, const Scene& scene);

}  // namespace glowworm
