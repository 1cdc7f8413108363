// Small scenes and pictures for session tests.
#pragma once
#include <memory>
#include <string>

#include "builtin/builtin.h"
#include "session/session.h"

namespace glowworm {

inline std::shared_ptr<const Scene> test_scene(const std::string& name) {
  return std::make_shared<const Scene>(builtin_scene(name));
}

/// The first state of a session, made small enough to take no time.
inline ViewState small_state(const Session& session) {
  ViewState state = session.initial_state();
  state.width = 32;
  state.height = 24;
  state.photons = 4000;
  state.gather = 4;
  state.filter = false;  // Most tests look at the samples themselves.
  return state;
}

inline double mean_luminance(const ViewFrame& frame) {
  double sum = 0;
  for (const RGB& light : frame.image.light) sum += luminance(light);
  return sum / static_cast<double>(frame.image.size());
}

/// Root of the mean squared difference of luminance, over the mean.
inline double relative_difference(const ViewFrame& a, const ViewFrame& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.image.size(); ++i) {
    const double d = luminance(a.image.light[i]) - luminance(b.image.light[i]);
    sum += d * d;
  }
  return std::sqrt(sum / static_cast<double>(a.image.size())) / mean_luminance(b);
}

}  // namespace glowworm
