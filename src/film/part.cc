#include "film/part.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include "core/archive.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/input_file.h"
#include "film/output.h"
#include "film/packed_file.h"
#include "settings/options.h"

namespace glowworm {

template <>
inline constexpr bool kPlain<SampleRange> = sizeof(SampleRange) == 8;

namespace {

constexpr FileKind kPartFile = {'G', 'L', 'O', 'W', 'P', 'T', '0', '4'};

/// Settings as names and words of their options.
template <typename Archive>
void transfer_settings(Archive& archive, RenderSettings& settings) {
  for (const Option& option : render_options()) {
    std::string name = option.name, word = Archive::kReads ? "" : option.print(settings);
    transfer_all(archive, name, word);
    require(name == option.name);
    if (Archive::kReads) option.parse(settings, word);
  }
  transfer_all(archive, settings.media, settings.of_points);
}

template <typename Archive>
void transfer_picture(Archive& archive, PictureInfo& p) {
  transfer_settings(archive, p.settings);
  std::vector<std::string> names;
  std::vector<std::array<float, 16>> matrices;
  for (const auto& [name, matrix] : p.matrices) {
    names.push_back(name);
    matrices.push_back(matrix);
  }
  transfer_all(archive, p.scene, p.scale, p.origin, p.seconds, p.photon_variance, p.objects, p.materials,
               p.light_groups, names, matrices, p.view);
  require(names.size() == matrices.size());
  for (std::size_t i = 0; i < names.size(); ++i) p.matrices[names[i]] = matrices[i];
  p.settings.light_group_count = static_cast<std::uint32_t>(p.light_groups.size());
}

std::string header_text(Part part) {
  // The machine that merges has settings of its own for these.
  part.picture.settings.threads = 0;
  part.picture.settings.share.clear();
  std::string text;
  ArchiveWriter writer([&](const void* data, std::size_t size) { text.append(static_cast<const char*>(data), size); });
  std::string key = key_text(part.key);
  transfer_all(writer, key, part.ranges);
  transfer_picture(writer, part.picture);
  return text;
}

/// Whether a render can have these ranges and settings.
bool is_possible(const Part& part) {
  const RenderSettings& s = part.picture.settings;
  const PixelBounds& b = s.bounds;
  const PictureInfo& p = part.picture;
  if (!is_variance(p.photon_variance) || !std::isfinite(p.seconds) || !is_finite(p.origin)) return false;
  if (!(p.scale > 0 && std::isfinite(p.scale))) return false;
  for (const auto& [name, matrix] : p.matrices)
    if (!std::ranges::all_of(matrix, [](float entry) { return std::isfinite(entry); })) return false;
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

/// The part whose header this is; nothing if it is none.
std::optional<Part> parse_header(const std::string& text) try {
  ArchiveReader reader(std::as_bytes(std::span(text)));
  Part part;
  std::string key;
  transfer_all(reader, key, part.ranges);
  part.key = parse_key(key);
  transfer_picture(reader, part.picture);
  return reader.at_end() && is_possible(part) ? std::optional(part) : std::nullopt;
} catch (const Error&) {
  return std::nullopt;
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

std::vector<std::byte> packed_film(const Film& film) {
  std::vector<std::byte> out;
  PackedWriter writer([&](std::span<const std::byte> bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); });
  film.write_state([&](std::span<const std::byte> bytes) { writer.write(bytes); });
  writer.finish();
  return out;
}

void unpack_film(std::span<const std::byte> bytes, const CameraTask& task, Film& film) {
  PackedReader packed([&](std::span<std::byte> to) {
    if (bytes.size() < to.size()) return false;
    std::copy_n(bytes.begin(), to.size(), to.begin());
    bytes = bytes.subspan(to.size());
    return true;
  });
  const auto read = [&](std::span<std::byte> to) { return packed.read(to); };
  if (!film.merge_state(read, task.sample_count) || !packed.at_end() || !film.is_of(task))
    throw Error("a rank sent a film that is damaged or of another task",
                "Run one version of the program on all machines.");
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
