#include "support/table.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/parallel.h"
#include "kernels/simd.h"

namespace glowworm::bench {

namespace {

constexpr int kSpreadDigits = 3;

std::string show(double value, int digits) {
  // As many digits, but whole numbers are never cut.
  if (std::abs(value) >= std::pow(10.0, digits)) return fmt::format("{:.0f}", value);
  return fmt::format("{:.{}g}", value, digits);
}

std::string show(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* number = std::get_if<Number>(&cell)) return show(number->value, number->digits);
  if (const auto* s = std::get_if<Spread>(&cell); s && s->runs > 0) {
    const std::string median = show(s->median, kSpreadDigits);
    return s->runs == 1
               ? median
               : fmt::format("{} [{} to {}]", median, show(s->least, kSpreadDigits), show(s->most, kSpreadDigits));
  }
  return "–";
}

}  // namespace

Spread spread_of(std::vector<double> values) {
  if (values.empty()) throw Error("a spread needs at least one value");
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return {(values[(n - 1) / 2] + values[n / 2]) / 2, values.front(), values.back(), static_cast<int>(n)};
}

Spread measure_seconds(int runs, const std::function<void()>& work) {
  std::vector<double> seconds;
  for (int i = 0; i < runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return spread_of(std::move(seconds));
}

Table::Table(std::string name, std::string title, std::vector<std::string> columns)
    : name_(std::move(name)), title_(std::move(title)), columns_(std::move(columns)) {
  fmt::print("\n# {}\n| {} | instructions | threads |\n", title_, fmt::join(columns_, " | "));
}

void Table::add(std::vector<Cell> cells) {
  if (cells.size() != columns_.size())
    throw Error(fmt::format("table {}: a row of {} cells for {} columns", name_, cells.size(), columns_.size()));
  rows_.push_back({std::move(cells), simd_name(), thread_count()});
  fmt::print("{}", row_markdown(rows_.back()));
  std::fflush(stdout);
}

void Table::note(std::string text) { notes_.push_back(std::move(text)); }

std::string Table::row_markdown(const Row& row) const {
  std::string text = "|";
  for (const Cell& cell : row.cells) text += fmt::format(" {} |", show(cell));
  return text + fmt::format(" {} | {} |\n", row.simd, row.threads);
}

std::string Table::markdown() const {
  std::string text = fmt::format(
      "# {}\n\nWritten by `{}` on {}, commit {}, {:%Y-%m-%d}.\n\n| {} | instructions | threads |\n|", title_,
      command_line(), machine_name(), commit_name(), fmt::gmtime(std::time(nullptr)), fmt::join(columns_, " | "));
  for (std::size_t i = 0; i < columns_.size() + 2; ++i) text += " --- |";
  text += '\n';
  for (const Row& row : rows_) text += row_markdown(row);
  for (const std::string& note : notes_) text += fmt::format("\n{}\n", note);
  return text;
}

void Table::write(const std::string& folder) const {
  std::filesystem::create_directories(folder);
  write_file(folder + '/' + name_ + ".md", markdown());
}

std::string machine_name() {
  std::ifstream cpu("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(cpu, line);) {
    const std::size_t colon = line.find(": ");
    if (!line.starts_with("model name") || colon == std::string::npos) continue;
    name = line.substr(colon + 2);
    break;
  }
  return fmt::format("{}, {} cores", name, std::thread::hardware_concurrency());
}

std::string command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string text;
  for (std::string word; std::getline(file, word, '\0');)
    text += text.empty() ? std::filesystem::path(word).filename().string() : " " + word;
  return text;
}

std::string commit_name() {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> git(
      popen("git describe --always --dirty --abbrev=12 --exclude '*' 2>/dev/null", "r"), pclose);
  char line[64] = {};
  if (!git || !std::fgets(line, sizeof line, git.get())) return "unknown";
  std::string name = line;
  while (!name.empty() && name.back() == '\n') name.pop_back();
  return name;
}

}  // namespace glowworm::bench
