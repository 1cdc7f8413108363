// What a program of tables is asked for on its command line.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "support/recording.h"

namespace glowworm::bench {

/// Names of parts, and of scenes: "builtin:NAME" or a path. Nothing of a kind asks for all of that kind.
class Arguments {
 public:
  Arguments(int argc, char** argv) {
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word.find_first_of(":/.") == std::string::npos)
        parts_.insert(word);
      else
        scenes_.push_back(word);
    }
  }

  bool wants(const std::string& part) const { return parts_.empty() || parts_.contains(part); }
  /// Scenes that were named, or all of table_scenes().
  std::vector<std::string> scenes() const { return scenes_.empty() ? table_scenes() : scenes_; }
  /// Scenes that were named, or the atrium.
  std::vector<std::string> scenes_or_atrium() const {
    return scenes_.empty() ? std::vector<std::string>{"builtin:atrium"} : scenes_;
  }

 private:
  std::set<std::string> parts_;
  std::vector<std::string> scenes_;
};

}  // namespace glowworm::bench
