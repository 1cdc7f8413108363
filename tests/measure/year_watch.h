// What the work of a year tells of its progress.
#pragma once
#include <vector>

#include "measure/find_year.h"

namespace glowworm {

/// Waits for Jobs, and appends the shares of the work that are told to be done.
inline YearWatch recording(std::vector<double>& done) {
  return {[&done](Job& job, YearProgress part) {
            done.push_back(part.before);
            job.wait();
            done.push_back(part.before + part.share);
          },
          [&done](double share) { done.push_back(share); }};
}

}  // namespace glowworm
