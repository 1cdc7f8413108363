#include "film/part.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/input_file.h"
#include "film/output.h"
#include "film/packed_file.h"
#include "settings/options.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr FileKind kPartFile = {'G', 'L', 'O', 'W', 'P', 'T', '0', '3'};

/// Names of files are any bytes, and JSON has only characters: each byte is one of the first 256.
std::string as_characters(const std::string& bytes) {
  std::string text;
  for (const char byte : bytes) {
    const auto code = static_cast<unsigned char>(byte);
    if (code < 0x80) {
      text += byte;
      continue;
    }
    text += static_cast<char>(0xc0 | code >> 6);
    text += static_cast<char>(0x80 | (code & 0x3f));
  }
  return text;
}

std::string as_bytes(const std::string& text) {
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto code = static_cast<unsigned char>(text[i]);
    if (code < 0x80 || i + 1 == text.size()) {
      bytes += text[i];
      continue;
    }
    ++i;
    bytes += static_cast<char>((code & 3) << 6 | (static_cast<unsigned char>(text[i]) & 0x3f));
  }
  return bytes;
}

json as_characters(const std::vector<std::string>& names) {
  json out = json::array();
  for (const std::string& name : names) out.push_back(as_characters(name));
  return out;
}

std::vector<std::string> as_bytes(const json& names) {
  std::vector<std::string> out;
  for (const json& name : names) out.push_back(as_bytes(name.get<std::string>()));
  return out;
}

json settings_to_json(RenderSettings settings) {
  // Those of the machine that merges.
  settings.threads = 0;
  settings.share.clear();
  json out = json::object();
  for (const Option& option : render_options()) out[option.name] = as_characters(option.print(settings));
  return out;
}

RenderSettings settings_from_json(const json& in) {
  RenderSettings settings;
  for (const Option& option : render_options()) option.parse(settings, as_bytes(in.at(option.name).get<std::string>()));
  return settings;
}

std::string header_text(const Part& part) {
  json ranges = json::array();
  for (const SampleRange& range : part.ranges) ranges.push_back({range.first, range.end});
  const PictureInfo& p = part.picture;
  const json out = {{"key", as_characters(key_text(part.key))},
                    {"ranges", ranges},
                    {"settings", settings_to_json(p.settings)},
                    {"scene", as_characters(p.scene)},
                    {"scale", p.scale},
                    {"origin", {p.origin.x, p.origin.y, p.origin.z}},
                    {"seconds", p.seconds},
                    {"photon_variance", p.photon_variance},
                    {"objects", as_characters(p.objects)},
                    {"materials", as_characters(p.materials)},
                    {"light_groups", as_characters(p.light_groups)},
                    {"matrices", p.matrices},
                    {"media", p.settings.media},
                    {"view", p.view},
                    {"of_points", p.settings.of_points}};
  return out.dump();
}

/// Whether a render can have these ranges and settings.
bool is_possible(const Part& part) {
  const RenderSettings& s = part.picture.settings;
  const PixelBounds& b = s.bounds;
  if (!is_variance(part.picture.photon_variance)) return false;
  if (b.empty() || b.x0 < 0 || b.y0 < 0 || b.x1 > s.width || b.y1 > s.height) return false;
  std::uint32_t end = 0;
  for (const SampleRange& range : part.ranges) {
    if (range.first < end || range.end <= range.first || range.end > s.samples) return false;
    end = range.end;
  }
  return s.light_groups == !part.picture.light_groups.empty() && !part.key.empty() && !part.ranges.empty() &&
         s.samples <= Film::kMaxSamples &&
         s.separate_layers >= (s.place_layers().any() || filters(s) || s.light_groups);
}

/// A number of samples. Converting a number that is not whole would be undefined behaviour.
std::uint32_t sample_number(const json& in) {
  if (!in.is_number_unsigned()) throw Error("a range of samples is not of whole numbers");
  return in.get<std::uint32_t>();
}

/// The part whose header this is; nothing if it is none.
std::optional<Part> parse_header(const std::string& text) {
  const json in = json::parse(text, nullptr, false);
  if (!in.is_object()) return std::nullopt;
  Part part;
  try {
    part.key = parse_key(as_bytes(in.at("key").get<std::string>()));
    for (const json& range : in.at("ranges"))
      part.ranges.push_back({sample_number(range.at(0)), sample_number(range.at(1))});
    PictureInfo& p = part.picture;
    p.settings = settings_from_json(in.at("settings"));
    p.scene = as_bytes(in.at("scene").get<std::string>());
    p.scale = in.at("scale").get<float>();
    const auto origin = in.at("origin").get<std::array<float, 3>>();
    p.origin = {origin[0], origin[1], origin[2]};
    p.seconds = in.at("seconds").get<double>();
    p.photon_variance = in.at("photon_variance").get<double>();
    p.objects = as_bytes(in.at("objects"));
    p.materials = as_bytes(in.at("materials"));
    p.light_groups = as_bytes(in.at("light_groups"));
    p.settings.light_group_count = static_cast<std::uint32_t>(p.light_groups.size());
    p.settings.media = in.at("media").get<bool>();
    p.settings.of_points = in.at("of_points").get<bool>();
    p.matrices = in.at("matrices").get<decltype(p.matrices)>();
    p.view = in.at("view").get<std::string>();
  } catch (const json::exception&) {
    return std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
  return is_possible(part) ? std::optional(part) : std::nullopt;
}

[[noreturn]] void refuse(const std::string& path) {
  throw Error({path}, "this is not a whole part of a picture by this program",
              "Copy the file again, or render the part again (glowworm render --part).");
}

/// Opens the file and reads its header.
Part open_part(const std::string& path, std::ifstream& file) {
  check_input_file(path);
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  file.open(path, std::ios::binary);
  if (error || !file) throw Error({path}, "the part cannot be read");
  const std::optional<std::string> text = read_header(file, kPartFile, size);
  std::optional<Part> part = text ? parse_header(*text) : std::nullopt;
  if (!part) refuse(path);
  return *std::move(part);
}

}  // namespace

std::uint32_t Part::sample_count() const {
  std::uint32_t count = 0;
  for (const SampleRange& range : ranges) count += range.count();
  return count;
}

void write_part(const std::string& path, const Part& part, const Film& film) {
  AtomicFile file(path);
  write_header(file, kPartFile, header_text(part));
  PackedWriter packed(file);
  film.write_state([&](std::span<const std::byte> bytes) { packed.write(bytes); });
  packed.finish();
  file.commit();
}

Part read_part(const std::string& path) {
  std::ifstream file;
  return open_part(path, file);
}

Film film_for(const Part& part) {
  const RenderSettings& s = part.picture.settings;
  return Film(s.bounds, s.indirect_only, s.separate_layers, s.place_layers(), filters(s), s.light_group_count);
}

std::uint64_t merge_bytes(const Part& part) {
  // Blocks before and after compression; the counts of a part.
  constexpr std::uint64_t kBuffers = std::uint64_t{128} << 20, kBytesPerPixel = 8;
  const RenderSettings& s = part.picture.settings;
  return kBuffers + kBytesPerPixel * s.bounds.pixel_count() +
         Film::bytes(s.bounds, s.separate_layers, s.place_layers(), filters(s), s.light_group_count);
}

void add_part(const std::string& path, const Part& part, Film& film) {
  std::ifstream file;
  const Part now = open_part(path, file);
  if (now.ranges != part.ranges || now.key != part.key)
    throw Error({path}, "the part has been written over", "Merge when all parts are there.");
  PackedReader packed(file);
  const auto read = [&](std::span<std::byte> bytes) { return packed.read(bytes); };
  if (!film.merge_state(read, part.sample_count()) || !packed.at_end()) refuse(path);
}

Part united(const std::vector<PartFile>& parts, bool mixed) {
  const PartFile& first = parts.front();
  Part all = first.part;
  all.ranges.clear();
  all.picture.seconds = 0;
  struct Taken {
    SampleRange range;
    const PartFile* file;
  };
  std::vector<Taken> taken;
  for (const PartFile& file : parts) {
    check_same_whole({first.path, first.part.key}, {file.path, file.part.key}, mixed);
    if (mixed) all.key = common_key(all.key, file.part.key);
    RenderSettings& settings = all.picture.settings;
    settings.samples = std::max(settings.samples, file.part.picture.settings.samples);
    for (const std::string& aov : file.part.picture.settings.aovs)
      if (std::find(settings.aovs.begin(), settings.aovs.end(), aov) == settings.aovs.end())
        settings.aovs.push_back(aov);
    all.picture.seconds += file.part.picture.seconds;
    // All have the same photons, whose noise the first part measures.
    all.picture.photon_variance = std::max(all.picture.photon_variance, file.part.picture.photon_variance);
    for (const SampleRange& range : file.part.ranges) taken.push_back({range, &file});
  }
  std::stable_sort(taken.begin(), taken.end(),
                   [](const Taken& a, const Taken& b) { return a.range.first < b.range.first; });
  const PartFile* last = nullptr;
  for (const Taken& each : taken) {
    if (last && each.range.first < all.ranges.back().end)
      throw Error(fmt::format("{} and {} have samples in common: {} to {}", last->path, each.file->path,
                              each.range.first + 1, std::min(each.range.end, all.ranges.back().end)),
                  "Merge each part once.");
    if (last && each.range.first == all.ranges.back().end)
      all.ranges.back().end = each.range.end;
    else
      all.ranges.push_back(each.range);
    last = each.file;
  }
  return all;
}

}  // namespace glowworm
