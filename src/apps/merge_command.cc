#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>

#include "apps/commands.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/table_options.h"
#include "core/atomic_file.h"
#include "core/disk_memory.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "film/output.h"
#include "film/part.h"
#include "settings/settings.h"

namespace glowworm {

namespace {

struct MergeOptions {
  std::string command_line;
  std::vector<std::string> parts, names;
  std::vector<Output> outputs;
  PictureOptions picture;
  TableOptions table;
  bool mixed = false, quiet = false;
};

void prepare_outputs(MergeOptions& o, OutputFiles& files) {
  for (const std::string& name : o.names) o.outputs.push_back(output_of(name));
  for (const std::string& part : o.parts) files.add_input("a part", part);
  if (!o.picture.color.request.config.empty()) files.add_input("--ocio", o.picture.color.request.config);
  for (const Output& output : o.outputs) files.add("-o", output.path);
  bool any = false;
  for (const Output& output : o.outputs) any = files.probe(output.path) || any;
  if (!any) files.throw_if_any_failed();
  o.picture.color.load();
  warn_of_unused_formats(o.picture, o.outputs);
}

/// The parts in the order of their samples, in which the ids of a pixel appear in a render.
std::vector<PartFile> read_parts(const std::vector<std::string>& paths) {
  std::vector<PartFile> parts;
  for (const std::string& path : paths) parts.push_back({path, read_part(path)});
  std::stable_sort(parts.begin(), parts.end(), [](const PartFile& a, const PartFile& b) {
    return a.part.ranges.front().first < b.part.ranges.front().first;
  });
  return parts;
}

/// The samples, counted from 1.
std::string samples_text(const std::vector<SampleRange>& ranges) {
  std::vector<std::string> texts;
  for (const SampleRange& range : ranges)
    texts.push_back(range.count() == 1 ? fmt::format("{}", range.end)
                                       : fmt::format("{}-{}", range.first + 1, range.end));
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// Says which samples are not there.
void tell_samples(const Part& all, const Film& film, std::size_t parts) {
  const std::uint32_t wanted = all.picture.settings.samples, there = all.sample_count();
  inform(fmt::format("merged {} part{}: {} of {} samples of each pixel", parts, parts == 1 ? "" : "s", there, wanted));
  std::vector<SampleRange> missing;
  std::uint32_t end = 0;
  for (const SampleRange& range : all.ranges) {
    if (range.first > end) missing.push_back({end, range.first});
    end = range.end;
  }
  if (end < wanted) missing.push_back({end, wanted});
  if (!missing.empty())
    warn(fmt::format("samples {} of {} are missing: the picture has {} samples", samples_text(missing), wanted, there));
  if (film.whole_passes() < there)
    warn(fmt::format("a part was stopped before its end: some pixels have only {} of {} samples", film.whole_passes(),
                     there));
}

void write_outputs(const MergeOptions& o, const Part& all, const Film& film, OutputFiles& files) {
  std::optional<Image> image;
  for (const Output& output : o.outputs) {
    std::string how;
    const auto write = [&] {
      if (output.format == OutputFormat::part) return write_part(output.path, all, film);
      if (!image) {
        image = make_image(film, all.picture);
        image->metadata["comments"] = o.command_line;
      }
      how = write_picture(output, *image, o.picture);
    };
    files.write_and_report(output.path, write, how);
  }
  files.throw_if_any_failed();
}

int run_merge(MergeOptions& o) {
  set_log_level(o.quiet ? LogLevel::quiet : LogLevel::normal);
  set_thread_count(o.table.settings);
  OutputFiles files;
  prepare_outputs(o, files);
  const std::vector<PartFile> parts = read_parts(o.parts);
  const Part all = united(parts, o.mixed);
  const std::uint64_t memory = o.table.settings.memory_bytes;
  MemoryBudget budget(memory > 0 ? memory : default_memory_bytes(), "Give a larger --memory.");
  const auto is_part = [](const Output& output) { return output.format == OutputFormat::part; };
  const bool shows = !std::all_of(o.outputs.begin(), o.outputs.end(), is_part);
  const std::uint64_t film_bytes = merge_bytes(all), shown_bytes = shows ? image_bytes(all.picture.settings) : 0;
  const std::unique_ptr<DiskMemory> disk =
      DiskMemory::for_arrays(o.table.settings.disk, film_bytes + shown_bytes, budget.limit());
  const DiskMemory::Scope scope(disk.get(), DiskMemory::kLeastOfChannels);
  const Reservation film_memory(budget, "film", disk ? 0 : film_bytes);
  const Reservation image_memory(budget, "image", disk ? 0 : shown_bytes);
  Film film = film_for(all);
  for (const PartFile& file : parts) add_part(file.path, file.part, film);
  tell_samples(all, film, parts.size());
  write_outputs(o, all, film, files);
  return 0;
}

constexpr const char* kMergeFooter = R"(
Merging all parts reproduces the render bit for bit; merging some gives a noisier image. Parts may be
merged into a larger part (-o all.part), to be merged again. The layers are what --aov named for the parts.

Examples:
  glowworm render builtin:cornell --part 1/2 -o 1.part
  glowworm render builtin:cornell --part 2/2 -o 2.part
  glowworm merge 1.part 2.part -o cornell.exr -o cornell.png)";

}  // namespace

void add_merge_command(CLI::App& program, const std::string& command_line, int& exit_status) {
  auto options = std::make_shared<MergeOptions>();
  options->command_line = command_line;
  CLI::App* c = program.add_subcommand("merge", "Makes a picture of parts (glowworm render --part).");
  c->add_option("parts", options->parts, "Parts of one render, in any order")->required()->option_text("PART...");
  add_list(*c, "Options", "-o,--output", options->names, "FILE",
           "Image to write: .exr, .hdr or .png, or .part for a part; several may be given")
      ->required();
  add_picture_options(*c, "Options", options->picture);
  c->add_flag("--mixed", options->mixed, "Take parts that were rendered with other instruction sets");
  add_table_options(*c, "Machine", Command::merge, options->table);
  c->add_flag("-q,--quiet", options->quiet, "Print warnings and errors only");
  c->footer(kMergeFooter);
  c->callback([options, &exit_status] { exit_status = run_merge(*options); });
}

}  // namespace glowworm
