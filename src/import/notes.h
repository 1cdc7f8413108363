// Notes of an import. Equal notes are counted and reported once.
#pragma once
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace glowworm {

/// Collects notes on features that are not supported and on guesses.
class NoteCounter {
 public:
  /// Counts the note `text` `times` times; 0 times adds nothing.
  void add(const std::string& text, std::size_t times = 1) {
    if (times > 0) counts_[text] += times;
  }
  /// Writes "text", or "text (N times)", for each note in alphabetical order.
  void write_to(std::vector<std::string>& notes) const {
    for (const auto& [text, count] : counts_) {
      notes.push_back(count == 1 ? text : text + " (" + std::to_string(count) + " times)");
    }
  }

 private:
  std::map<std::string, std::size_t> counts_;
};

}  // namespace glowworm
