#include "core/names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <string_view>
#include <utility>

#include "core/error.h"

namespace glowworm {

namespace {

/// Number of letters to insert, delete or replace to turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = std::exchange(row[j + 1], std::min({replaced, row[j] + 1, row[j + 1] + 1}));
    }
  }
  return row.back();
}

}  // namespace

std::string did_you_mean(const std::string& text, const std::vector<std::string>& names) {
  constexpr std::size_t kMaxMistakes = 2;
  std::size_t least = kMaxMistakes + 1;
  std::string nearest;
  for (const std::string& name : names)
    if (const std::size_t distance = edit_distance(text, name); text.size() > kMaxMistakes && distance < least) {
      least = distance;
      nearest = name;
    }
  return nearest.empty() ? "" : fmt::format("Did you mean '{}'? ", nearest);
}

std::size_t name_index(const std::string& what, const std::string& text, const std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  if (names.empty()) throw Error(fmt::format("{} '{}' is not known: there is none", what, text));
  throw Error(fmt::format("{} '{}' is not known", what, text),
              fmt::format("{}Choose from: {}.", did_you_mean(text, names), fmt::join(names, ", ")));
}

void number_repeated(std::vector<std::string>& names) {
  std::map<std::string, int> seen, used;
  for (const std::string& name : names) ++seen[name];
  for (std::string& name : names)
    if (seen[name] > 1) name += fmt::format(" {}", ++used[name]);
}

}  // namespace glowworm
