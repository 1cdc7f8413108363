// Files of a render that hold what no render writes, with the right hashes: nothing crashes, and pieces of shared work
// are made again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "builtin/builtin.h"
#include "control/job_report.h"
#include "core/error.h"
#include "film/output.h"
#include "film/packed_file.h"
#include "film/part.h"
#include "render/render_testing.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;

/// A file of a header and packed bytes, as parts and pieces of shared work are.
struct PackedFile {
  FileKind kind{};
  std::string header;
  std::vector<std::byte> bytes;

  explicit PackedFile(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    file.read(kind.data(), static_cast<std::streamsize>(kind.size()));
    file.seekg(0);
    header = read_header(file, kind, fs::file_size(path)).value();
    PackedReader packed(file);
    for (std::byte next{}; packed.read(std::span(&next, 1));) bytes.push_back(next);
  }

  void write(const fs::path& path) const {
    AtomicFile file(path);
    write_header(file, kind, header);
    PackedWriter packed(file);
    packed.write(bytes);
    packed.finish();
    file.commit();
  }
};

class ForgedFiles : public FolderTest {
 protected:
  std::vector<fs::path> pieces() const {
    std::vector<fs::path> out;
    for (const auto& entry : fs::recursive_directory_iterator(folder_))
      if (entry.path().extension() == ".share") out.push_back(entry.path());
    std::sort(out.begin(), out.end());
    return out;
  }

  std::mt19937 random_{5};
};

TEST_F(ForgedFiles, PiecesWithIndicesBeyondTheirArraysAreMadeAgain) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(16, 1, 8, 5000, "blocked");
  settings.light_groups = true;  // the sources of photons count
  const std::vector<std::uint32_t> expected = stage.render(settings).save();
  settings.share = folder_;
  stage.render(settings);
  constexpr std::uint32_t kBeyond = ~0u;  // also not a number
  int forged = 0;
  for (const fs::path& path : pieces()) {
    const PackedFile own(path);
    const std::size_t words = own.bytes.size() / sizeof kBeyond;
    // The first two are the size of the piece.
    for (int trial = 0; trial < 12 && words > 2; ++trial, ++forged) {
      PackedFile other = own;
      const std::size_t word = std::uniform_int_distribution<std::size_t>(2, words - 1)(random_);
      std::memcpy(other.bytes.data() + word * sizeof kBeyond, &kBeyond, sizeof kBeyond);
      other.write(path);
      const std::vector<std::uint32_t> made = stage.render(settings).save();
      // Another place in a grid of importance is as good as the right one.
      if (path.filename().string().find("photon-guide") == std::string::npos) {
        EXPECT_TRUE(made == expected) << path << " " << word;
      }
    }
    own.write(path);
  }
  EXPECT_GE(forged, 36);
}

TEST_F(ForgedFiles, PartsAreRefusedOrMakePictures) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(8, 2, 4, 1000, "auto");
  settings.guiding = false;
  settings.filter = Filtering::automatic;
  settings.aovs = aov_names();
  settings.light_groups = true;
  Job job(stage.scene, stage.tracer, settings);
  job.wait();
  const fs::path path = folder_ / "a.part";
  write_part(path, part_of(job), job.snapshot());
  const PackedFile own(path);
  const auto take = [&](const PackedFile& file) {
    file.write(path);
    try {
      const Part part = read_part(path);
      if (part.picture.settings.bounds.pixel_count() > 1'000'000) return;  // glowworm merge looks at the memory first
      Film film = film_for(part);
      add_part(path, part, film);
      make_image(film, part.picture);
    } catch (const Error&) {
    }
  };
  for (int trial = 0; trial < 60; ++trial) {
    PackedFile other = own;
    const std::uint32_t word = trial % 2 == 0 ? ~0u : static_cast<std::uint32_t>(random_());
    const std::size_t place = std::uniform_int_distribution<std::size_t>(0, own.bytes.size() / 4 - 1)(random_);
    std::memcpy(other.bytes.data() + 4 * place, &word, sizeof word);
    take(other);
  }
  // Numbers, not texts, hold bytes of zero.
  std::vector<std::size_t> numbers;
  for (std::size_t place = 0; place + 4 <= own.header.size(); ++place)
    if (own.header.find('\0', place) < place + 4) numbers.push_back(place);
  ASSERT_FALSE(numbers.empty());
  for (const std::size_t place : numbers)
    for (const std::uint32_t word : {0u, 1u, 0x7fc00000u, ~0u}) {
      PackedFile other = own;
      std::memcpy(other.header.data() + place, &word, sizeof word);
      take(other);
    }
  const auto take_changed = [&](auto&& change) {
    Part part = part_of(job);
    change(part.picture);
    write_part(path, part, job.snapshot());
    take(PackedFile(path));
  };
  take_changed([](PictureInfo& p) { p.objects.clear(); });
  take_changed([](PictureInfo& p) { p.materials.clear(); });
  take_changed([](PictureInfo& p) { p.light_groups.clear(); });
  take_changed([](PictureInfo& p) { p.matrices.clear(); });
}

TEST_F(ForgedFiles, CheckpointsAreRefusedOrContinued) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(8, 2, 4, 1000, "auto");
  settings.guiding = false;
  Job job(stage.scene, stage.tracer, settings);
  job.wait();
  const Checkpoint own = job.checkpoint();
  settings.samples = 3;
  const auto take = [&](const Checkpoint& forged) {
    const std::string path = folder_ / "a.checkpoint";
    write_checkpoint(path, forged);
    try {
      const std::optional<Checkpoint> read = read_checkpoint(path);
      Job(stage.scene, stage.tracer, settings, &*read).wait();
    } catch (const Error&) {
    }
  };
  for (int trial = 0; trial < 40; ++trial) {
    Checkpoint forged = own;
    const std::size_t place = std::uniform_int_distribution<std::size_t>(0, own.film.size() - 1)(random_);
    forged.film[place] = trial % 2 == 0 ? ~0u : static_cast<std::uint32_t>(random_());
    take(forged);
  }
  for (const std::uint32_t number : {1u, 3u, ~0u}) {
    Checkpoint forged = own;
    forged.passes = number;
    take(forged);
    forged = own;
    forged.round.assign(8 * 8, number);
    take(forged);
    forged.round.assign(number % 7, number);
    take(forged);
    forged = own;
    forged.first_row = forged.end_row = number;
    take(forged);
    forged.above.resize(number % 100);
    take(forged);
  }
  Checkpoint forged = own;
  forged.photon_variance = std::numeric_limits<double>::quiet_NaN();
  take(forged);
}

}  // namespace
}  // namespace glowworm
