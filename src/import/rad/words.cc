#include "import/rad/words.h"

#include <fmt/format.h>

#include <cmath>

#include "core/lines.h"

namespace glowworm {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f'; }

constexpr const char* kForm = "A primitive is: modifier type name, then a count and words, 0, a count and numbers.";

}  // namespace

RadWords::RadWords(std::string_view text, FilePlace place)
    : rest_(without_byte_order_mark(text)), place_(std::move(place)) {}

char RadWords::take() {
  const char c = rest_.front();
  rest_.remove_prefix(1);
  if (c == '\n') ++place_.line;
  return c;
}

void RadWords::skip_blanks() {
  while (!rest_.empty() && is_blank(rest_.front())) take();
}

RadWords::Item RadWords::next() {
  for (skip_blanks(); !rest_.empty() && rest_.front() == '#'; skip_blanks())
    while (!rest_.empty() && rest_.front() != '\n') take();
  if (rest_.empty()) return Item::none;
  return rest_.front() == '!' ? Item::command : Item::primitive;
}

std::string RadWords::command() {
  std::string out;
  take();
  while (!rest_.empty() && rest_.front() != '\n') {
    const char c = take();
    const bool continues = c == '\\' && (rest_.starts_with('\n') || rest_.starts_with("\r\n"));
    if (continues) {
      if (take() == '\r') take();
      out.push_back(' ');
    } else {
      out.push_back(c);
    }
  }
  return out;
}

std::string RadWords::word(std::string_view wanted) {
  skip_blanks();
  if (rest_.empty()) throw Error(place_, fmt::format("the file ends where {} is expected", wanted), kForm);
  std::string out;
  const char quote = rest_.front() == '"' || rest_.front() == '\'' ? take() : '\0';
  while (!rest_.empty() && (quote ? rest_.front() != quote : !is_blank(rest_.front()))) out.push_back(take());
  if (!quote) return out;
  if (rest_.empty()) throw Error(place_, "a quotation mark is not closed");
  take();
  return out;
}

std::size_t RadWords::count(std::string_view what) { return rad_count(word(what), what, place_); }

RadPrimitive RadWords::primitive() {
  RadPrimitive out;
  out.modifier = word("a modifier");
  out.place = place_;
  out.type = word("a type");
  out.name = word("a name");
  if (out.type == "alias") {
    out.alias_of = word("the name that an alias stands for");
    return out;
  }
  for (std::size_t left = count("the count of words"); left > 0; --left) out.words.push_back(word("a word"));
  for (std::size_t left = count("the count of integers"); left > 0; --left) word("an integer");
  for (std::size_t left = count("the count of numbers"); left > 0; --left) {
    const std::string text = word("a number");
    out.numbers.push_back(rad_number(text, "a number", place_));
  }
  return out;
}

std::vector<std::vector<std::string>> rad_pipeline(const std::string& command, const FilePlace& place) {
  std::vector<std::vector<std::string>> stages(1);
  for (std::size_t at = 0; at < command.size();) {
    const char c = command[at];
    if (is_blank(c)) {
      ++at;
    } else if (c == '|') {
      stages.emplace_back();
      ++at;
    } else {
      std::string& word = stages.back().emplace_back();
      for (char quote = '\0'; at < command.size(); ++at) {
        const char next = command[at];
        if (quote ? next == quote : next == '"' || next == '\'') {
          quote = quote ? '\0' : next;
        } else if (!quote && (is_blank(next) || next == '|')) {
          break;
        } else if (!quote && std::string_view(";&<>$`()*?\\").find(next) != std::string_view::npos) {
          throw Error(place, fmt::format("the command '!{}' needs a shell, which is never started", command),
                      "Run it yourself, and keep its output in a .rad file that takes its place.");
        } else {
          word.push_back(next);
        }
      }
    }
  }
  constexpr std::size_t kMostStages = 8;
  if (stages.size() > kMostStages) throw Error(place, "the pipeline has too many stages");
  for (const auto& stage : stages)
    if (stage.empty()) throw Error(place, fmt::format("the line '!{}' lacks a command", command));
  return stages;
}

std::optional<double> rad_number(std::string_view word) {
  double value = 0;
  if (!take_number(word, value) || !word.empty() || !std::isfinite(static_cast<float>(value))) return std::nullopt;
  return value;
}

double rad_number(std::string_view word, std::string_view what, const FilePlace& place) {
  const std::optional<double> value = rad_number(word);
  if (!value) throw Error(place, fmt::format("'{}' is not {}", word, what), kForm);
  return *value;
}

std::size_t rad_count(std::string_view word, std::string_view what, const FilePlace& place) {
  const double value = rad_number(word, what, place);
  if (value < 0 || value != std::floor(value) || value > 1e15)
    throw Error(place, fmt::format("'{}' is not {}", word, what), kForm);
  return static_cast<std::size_t>(value);
}

}  // namespace glowworm
