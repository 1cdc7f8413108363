#include "import/pbrt/diagnostics.h"

#include <fmt/format.h>

#include <utility>

namespace glowworm {

std::string to_string(const PbrtPlace& place) {
  return to_string(FilePlace{place.file ? *place.file : std::string(), place.line, place.column});
}

std::string in_quotes(std::string_view name) {
  constexpr std::size_t kLongest = 60;
  std::string text = "\"";
  for (const char c : name.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      text += fmt::format("\\x{:02x}", byte);
    } else {
      text += c;
    }
  }
  if (name.size() > kLongest) text += "...";
  return text + "\"";
}

const std::string* PbrtDiagnostics::add_file(std::string name) { return &files_.emplace_back(std::move(name)); }

void PbrtDiagnostics::error(const PbrtPlace& place, const std::string& message, const std::string& remedy) {
  if (full()) return;
  const FilePlace at{place.file ? *place.file : std::string(), place.line, place.column};
  errors_.push_back({at, remedy.empty() ? message : message + "\n  " + remedy});
}

void PbrtDiagnostics::throw_if_errors() const {
  if (errors_.empty()) return;
  std::string text;
  // The place of the first stands in front of the text anyway.
  for (const Problem& error : errors_)
    text += text.empty() ? error.text : "\n" + glowworm::to_string(error.place) + ": " + error.text;
  if (full()) {
    text += fmt::format("\n{} errors: reading stopped", errors_.size());
  } else if (errors_.size() > 1) {
    text += fmt::format("\n{} errors", errors_.size());
  }
  throw Error(errors_.front().place, text);
}

void PbrtDiagnostics::note(const PbrtPlace& place, const std::string& text, std::size_t times) {
  const auto [entry, is_new] = note_index_.try_emplace(text, notes_.size());
  if (is_new) notes_.push_back({text, place, 0});
  notes_[entry->second].count += times;
}

std::vector<std::string> PbrtDiagnostics::notes() const {
  std::vector<std::string> lines;
  for (const Note& note : notes_) {
    std::string where = to_string(note.first);
    if (note.count > 1) where += fmt::format(", and {} more", note.count - 1);
    lines.push_back(where.empty() ? note.text : fmt::format("{} ({})", note.text, where));
  }
  return lines;
}

}  // namespace glowworm
