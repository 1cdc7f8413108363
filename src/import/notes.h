// Notes of an import, with counts: each thing is said once.
#pragma once
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace glowworm {

/// Collects what a file asks for and is not done, or had to be guessed.
class NoteCounter {
 public:
  /// Counts one more (or `times` more) of what `text` says; nothing where times is 0.
  void add(const std::string& text, std::size_t times = 1) {
    if (times > 0) counts_[text] += times;
  }
  /// Adds "text", or "text (N times)", for each text in alphabetical order.
  void write_to(std::vector<std::string>& notes) const {
    for (const auto& [text, count] : counts_) {
      notes.push_back(count == 1 ? text : text + " (" + std::to_string(count) + " times)");
    }
  }

 private:
  std::map<std::string, std::size_t> counts_;
};

}  // namespace glowworm
