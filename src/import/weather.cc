#include "import/weather.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/lines.h"

namespace glowworm {

namespace {

constexpr const char* kWholeFile = "Give a whole EPW file of EnergyPlus.";

/// The lines of a weather file, divided at commas.
class WeatherLines {
 public:
  WeatherLines(std::string_view text, const std::string& path)
      : rest_(without_byte_order_mark(text)), path_(path), is_ended_(text.ends_with('\n') || text.ends_with('\r')) {}

  /// Goes to the next line; false behind the last. The last one may lack its end, but none of its fields.
  bool next() {
    if (rest_.empty()) return false;
    const std::size_t before = fields_.size();
    divide(take_line(rest_));
    ++number_;
    if (rest_.empty() && !is_ended_ && (fields_.size() < before || fields_.back().empty()))
      fail("the file ends within this line");
    return true;
  }

  /// A field of the line, without blanks and quotes around it; empty beyond the last.
  std::string_view word(std::size_t i) const { return i < fields_.size() ? fields_[i] : std::string_view(); }

  double number(std::size_t i) const {
    double value = 0;
    std::string_view rest = word(i);
    if (!take_number(rest, value) || !rest.empty() || !std::isfinite(value))
      fail(fmt::format("column {} is no number: '{}'", i + 1, word(i).substr(0, 40)));
    return value;
  }

  bool is_empty() const { return fields_.size() == 1 && fields_.front().empty(); }
  FilePlace place() const { return {path_, number_}; }
  [[noreturn]] void fail(const std::string& message) const { throw Error(place(), message, kWholeFile); }

 private:
  void divide(std::string_view line) {
    fields_.clear();
    bool quoted = false;
    std::size_t begin = 0;
    for (std::size_t i = 0; i <= line.size(); ++i) {
      if (i < line.size() && line[i] == '"') quoted = !quoted;
      if (i < line.size() && (quoted || line[i] != ',')) continue;
      fields_.push_back(trimmed(line.substr(begin, i - begin), " \t\""));
      begin = i + 1;
    }
  }

  std::string_view rest_;
  std::string path_;
  bool is_ended_;  // by a line end
  std::vector<std::string_view> fields_;
  int number_ = 0;
};

/// The hour in the middle of the time from `begin` to `end` during which the sun is up; the middle of all if it is
/// never up, or set only in between.
double middle_of_daylight(SkyMoment moment, double begin, double end) {
  const auto is_up = [&](double hour) {
    moment.hour = hour;
    return sun_place(moment).altitude > 0;
  };
  const bool at_begin = is_up(begin), at_end = is_up(end);
  if (at_begin == at_end) return (begin + end) / 2;
  double dark = at_begin ? end : begin, light = at_begin ? begin : end;
  for (int i = 0; i < 30; ++i) {
    const double middle = (dark + light) / 2;
    (is_up(middle) ? light : dark) = middle;
  }
  return (light + (at_begin ? begin : end)) / 2;
}

/// The records of a weather file behind its header.
class WeatherRecords {
 public:
  WeatherRecords(std::string_view text, const std::string& path) : lines_(text, path) {
    if (!lines_.next() || lines_.word(0) != "LOCATION") lines_.fail("is no EPW file: it does not begin with LOCATION");
    moment_ = {1, 1, 0, lines_.number(6), lines_.number(7), lines_.number(8)};
    constexpr int kMostRecords = 60;
    for (int i = 2; i <= kHeader; ++i)
      if (!lines_.next()) lines_.fail("the file ends within its header");
    if (lines_.word(0) != "DATA PERIODS") lines_.fail("does not begin with DATA PERIODS");
    const double given = lines_.number(2);
    if (!(given >= 1 && given <= kMostRecords && given == std::floor(given)))
      lines_.fail(fmt::format("column 3 says {:g} records an hour", given));
    each_ = static_cast<int>(given);
  }

  static constexpr int kHeader = 8;

  /// Records of an hour.
  int each() const { return each_; }
  /// Goes to the next record; false behind the last.
  bool next() {
    // Some files end in an empty line.
    do {
      if (!lines_.next()) return false;
    } while (lines_.is_empty());
    return true;
  }
  /// Whether the record belongs to this hour.
  bool is_of(int month, int day, int hour) const {
    return lines_.number(1) == month && lines_.number(2) == day && lines_.number(3) == hour;
  }
  /// The hour that the record belongs to. Throws Error if there is no such hour.
  WeatherHour hour() const {
    const double month = lines_.number(1), day = lines_.number(2), hour = lines_.number(3);
    const auto is_within = [](double v, int most) { return v >= 1 && v <= most && v == std::floor(v); };
    if (!is_within(month, 12) || !is_within(day, 31) || !is_within(hour, 24))
      lines_.fail(fmt::format("month {:g}, day {:g}, hour {:g} is no time", month, day, hour));
    WeatherHour out;
    out.moment = moment_;
    out.moment.month = static_cast<int>(month);
    out.moment.day = static_cast<int>(day);
    out.hour = static_cast<int>(hour);
    return out;
  }
  /// Adds the energy that arrived in the record's part of the hour.
  void add_to(SolarIrradiance& sum) const {
    const double direct = lines_.number(14), diffuse = lines_.number(15);
    if (!(direct >= 0 && direct < kMissing && diffuse >= 0 && diffuse < kMissing))
      throw Error(lines_.place(), "the irradiance of this hour is missing or negative",
                  "Give another hour, or fill the gap.");
    sum.direct_normal += direct;
    sum.diffuse_horizontal += diffuse;
  }
  /// Global horizontal irradiance of the record; infinite if it is missing.
  double global() const {
    const double value = lines_.number(13);
    return value < kMissing ? value : HUGE_VAL;
  }

 private:
  static constexpr double kMissing = 9999;

  WeatherLines lines_;
  SkyMoment moment_;
  int each_ = 1;
};

[[noreturn]] void refuse_gap(const FilePlace& place, const WeatherHour& hour, int each, int found) {
  throw Error(place,
              fmt::format("says {} records an hour, but hour {} of {:02}-{:02} has {}", each, hour.hour,
                          hour.moment.month, hour.moment.day, found),
              kWholeFile);
}

/// Counts what is strange in the hours of a year.
class YearDoubts {
 public:
  /// @param global horizontal irradiance, W m^-2; infinite if it is missing
  void look_at(const WeatherHour& hour, double global) {
    const SolarIrradiance& e = hour.irradiance;
    const SunPlace sun = sun_place(hour.moment);
    if (e.direct_normal + e.diffuse_horizontal > 0 && !perez_sky(hour.moment, e)) ++at_night_;
    if (std::isinf(global)) return;
    const double sum = e.diffuse_horizontal + e.direct_normal * std::max(std::sin(sun.altitude * M_PI / 180), 0.0);
    const double difference = std::abs(global - sum);
    if (!(difference > kLeast && difference > kShare * std::max(global, sum))) return;
    if (difference > most_) {
      most_ = difference;
      where_ = fmt::format("{:02}-{:02} hour {}: {:.0f} and {:.0f} W/m2", hour.moment.month, hour.moment.day, hour.hour,
                           global, sum);
    }
    ++differ_;
  }

  std::vector<std::string> notes(std::size_t hours) const {
    std::vector<std::string> out;
    if (differ_ > 0)
      out.push_back(
          fmt::format("in {} hours global horizontal irradiance differs by more than {:.0f}% from the sum of direct "
                      "and diffuse, which are used (most at {})",
                      differ_, 100 * kShare, where_));
    if (at_night_ > 0) out.push_back(fmt::format("{} hours have light, but no sun: they are taken as dark", at_night_));
    if (hours != 8760 && hours != 8784)
      out.push_back(fmt::format("the file has {} hours; a year has 8760 or 8784", hours));
    return out;
  }

 private:
  /// W m^-2, and share of the irradiance: smaller differences may come from the sun's position within the hour.
  static constexpr double kLeast = 20, kShare = 0.1;

  std::size_t differ_ = 0, at_night_ = 0;
  double most_ = 0;
  std::string where_;
};

}  // namespace

WeatherHour parse_weather_hour(std::string_view text, const std::string& path, int month, int day, int hour) {
  WeatherRecords records(text, path);
  WeatherHour out;
  int found = 0;
  while (found < records.each() && records.next()) {
    if (!records.is_of(month, day, hour)) {
      if (found > 0) break;
      continue;
    }
    if (found == 0) out = records.hour();
    records.add_to(out.irradiance);
    ++found;
  }
  if (found == 0)
    throw Error({path}, fmt::format("has no hour {} of {:02}-{:02}", hour, month, day),
                "Give month, day, and an hour from 1 to 24.");
  if (found < records.each()) refuse_gap({path, WeatherRecords::kHeader}, out, records.each(), found);
  out.moment.hour = middle_of_daylight(out.moment, hour - 1, hour);
  return out;
}

WeatherYear parse_weather_year(std::string_view text, const std::string& path, double turn) {
  WeatherRecords records(text, path);
  WeatherYear out;
  YearDoubts doubts;
  while (records.next()) {
    WeatherHour hour = records.hour();
    double global = 0;
    for (int found = 0; found < records.each(); ++found) {
      if (found > 0 && (!records.next() || !records.is_of(hour.moment.month, hour.moment.day, hour.hour)))
        refuse_gap({path, WeatherRecords::kHeader}, hour, records.each(), found);
      records.add_to(hour.irradiance);
      global += records.global();
    }
    hour.moment.hour = middle_of_daylight(hour.moment, hour.hour - 1, hour.hour);
    hour.moment.turn = turn;
    doubts.look_at(hour, global);
    out.hours.push_back(hour);
  }
  if (out.hours.empty()) throw Error({path}, "has no hour", kWholeFile);
  out.notes = doubts.notes(out.hours.size());
  return out;
}

}  // namespace glowworm
