#include "film/part.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "builtin/builtin.h"
#include "control/job_report.h"
#include "core/error.h"
#include "film/output.h"
#include "render/render_testing.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

RenderSettings small_picture(std::uint32_t samples) {
  RenderSettings s = by_photons(16, samples, 4, 1000, "auto");
  s.filter = Filtering::automatic;
  s.aovs = aov_names();
  return s;
}

class PartTest : public FolderTest {
 protected:
  /// Renders a part into a file.
  PartFile render(RenderSettings settings, SampleShare share, const std::string& name) const {
    settings.part = share;
    Job job(stage.scene, stage.tracer, settings);
    job.wait();
    write_part(path(name), part_of(job), job.snapshot());
    return {path(name), read_part(path(name))};
  }

  static Film merged(const std::vector<PartFile>& parts) {
    Film film = film_for(united(parts, false));
    for (const PartFile& file : parts) add_part(file.path, file.part, film);
    return film;
  }

  std::string read(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  Stage stage{builtin_scene("cornell")};

 private:
};

/// What the error says that the work throws; "" where it throws none.
template <typename Work>
std::string refusal(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

void expect_same_pictures(const Image& a, const Image& b) {
  ASSERT_EQ(a.channels().size(), b.channels().size());
  for (std::size_t i = 0; i < a.channels().size(); ++i) {
    EXPECT_EQ(a.channels()[i].name, b.channels()[i].name);
    EXPECT_TRUE(a.channels()[i].samples == b.channels()[i].samples) << a.channels()[i].name;
  }
  EXPECT_EQ(a.matrices, b.matrices);
  for (const auto& [name, text] : a.metadata)
    if (name != "capDate" && name != "glowworm:seconds") {
      EXPECT_EQ(text, b.metadata.at(name)) << name;
    }
}

TEST_F(PartTest, AllPartsInAnyOrderAreTheUndividedRender) {
  const RenderSettings settings = small_picture(16);
  Job whole(stage.scene, stage.tracer, settings);
  whole.wait();
  const Film film = whole.snapshot();
  const Image picture = make_image(film, whole);
  std::mt19937 random(7);
  for (const std::uint32_t n : {1u, 2u, 3u, 7u, 16u}) {
    std::vector<PartFile> parts;
    for (std::uint32_t i = 1; i <= n; ++i) parts.push_back(render(settings, {i, n}, std::to_string(i) + ".part"));
    std::shuffle(parts.begin(), parts.end(), random);
    const Film sum = merged(parts);
    const Part all = united(parts, false);
    EXPECT_EQ(all.ranges, std::vector<SampleRange>({{0, 16}}));
    expect_same_pictures(make_image(sum, all.picture), picture);
    // What a merge writes is a part, too.
    write_part(path("all.part"), all, sum);
    const PartFile again{path("all.part"), read_part(path("all.part"))};
    expect_same_pictures(make_image(merged({again}), again.part.picture), picture);
  }
}

TEST_F(PartTest, PathsAndProgressivePhotonsAreCutToTheSameBits) {
  RenderSettings progressive = small_picture(5), paths = small_picture(5);
  progressive.progressive = true;
  paths.integrator = Integrator::path;
  for (RenderSettings settings : {progressive, paths}) {
    settings.aovs.clear();
    const Film whole = stage.render(settings);
    const Film sum = merged({render(settings, {2, 2}, "2"), render(settings, {1, 2}, "1")});
    EXPECT_TRUE(sum.save() == whole.save());
  }
}

TEST_F(PartTest, EachPartCountsThePhotonsOfItsMapsOnce) {
  for (const bool progressive : {false, true}) {
    std::vector<std::uint64_t> photons;
    for (const SampleShare share : {SampleShare{1, 1}, SampleShare{2, 2}}) {
      RenderSettings settings = small_picture(2);
      settings.progressive = progressive;
      settings.part = share;
      Job job(stage.scene, stage.tracer, settings);
      job.wait();
      photons.push_back(job.statistics().count(Counter::photons_stored));
    }
    // Progressive parts have half of the passes; other parts make the same map again.
    const double expected = static_cast<double>(photons[0]) / (progressive ? 2 : 1);
    EXPECT_GT(expected, 0);
    EXPECT_NEAR(static_cast<double>(photons[1]), expected, 0.3 * expected) << progressive;
  }
}

TEST_F(PartTest, SomePartsAreAPictureOfFewerSamples) {
  const RenderSettings settings = small_picture(8);
  const std::vector<PartFile> parts = {render(settings, {2, 4}, "2"), render(settings, {1, 4}, "1")};
  EXPECT_TRUE(united(parts, false).ranges == std::vector<SampleRange>({{0, 4}}));
  EXPECT_EQ(united(parts, false).picture.settings.samples, 8u);
  expect_same_pictures(
      make_image(merged(parts), picture_info(Job(stage.scene, stage.tracer, small_picture(4)))),
      make_image(stage.render(small_picture(4)), picture_info(Job(stage.scene, stage.tracer, small_picture(4)))));
}

TEST_F(PartTest, LaterPartsAddSamples) {
  const std::vector<PartFile> parts = {render(small_picture(4), {1, 2}, "1"), render(small_picture(4), {2, 2}, "2"),
                                       render(small_picture(8), {3, 4}, "3"), render(small_picture(8), {4, 4}, "4")};
  const Part all = united(parts, false);
  EXPECT_EQ(all.picture.settings.samples, 8u);
  expect_same_pictures(make_image(merged(parts), all.picture), make_image(stage.render(small_picture(8)), all.picture));
}

TEST_F(PartTest, MergedPartsHaveTheLayersOfAll) {
  RenderSettings with_depth = small_picture(2), with_normal = with_depth;
  with_depth.aovs = {"depth"};
  with_normal.aovs = {"normal", "depth"};
  const std::vector<PartFile> parts = {render(with_depth, {1, 2}, "1"), render(with_normal, {2, 2}, "2")};
  EXPECT_EQ(united(parts, false).picture.settings.aovs, std::vector<std::string>({"depth", "normal"}));
}

TEST_F(PartTest, APartContinuesFromItsOwnCheckpointAlone) {
  RenderSettings settings = small_picture(6);
  settings.part = {2, 3};
  Job begun(stage.scene, stage.tracer, settings);
  while (begun.tasks() == 0 && !begun.done()) std::this_thread::yield();
  begun.cancel();
  begun.wait();
  const Checkpoint checkpoint = begun.checkpoint();
  Job resumed(stage.scene, stage.tracer, settings, &checkpoint);
  resumed.wait();
  EXPECT_TRUE(resumed.snapshot().save() == stage.render(settings).save());
  EXPECT_EQ(resumed.snapshot().whole_passes(), 2u);
  settings.part = {3, 3};
  EXPECT_THAT(refusal([&] { Job(stage.scene, stage.tracer, settings, &checkpoint); }),
              HasSubstr("begins after 2 samples"));
  settings.part = {3, 6};
  const Checkpoint whole = resumed.checkpoint();
  EXPECT_THAT(refusal([&] { Job(stage.scene, stage.tracer, settings, &whole); }),
              HasSubstr("do not belong to the part"));
  // Some pixels are enough.
  Film film = stage.render(settings);
  film.take_rows(resumed.film().rows(0, 3));
  Checkpoint uneven = whole;
  uneven.passes = 1;
  uneven.film = film.save();
  EXPECT_THAT(refusal([&] { Job(stage.scene, stage.tracer, settings, &uneven); }),
              HasSubstr("do not belong to the part"));
}

TEST_F(PartTest, PartsOfOtherRendersAreRefusedByName) {
  const RenderSettings settings = small_picture(4);
  const PartFile first = render(settings, {1, 2}, "a.part");
  PartFile second = render(settings, {2, 2}, "b.part");
  const auto with = [&](const std::string& name, const std::string& value) {
    PartFile other = second;
    const auto found = std::find_if(other.part.key.begin(), other.part.key.end(),
                                    [&](const KeyPart& part) { return part.name == name; });
    EXPECT_NE(found, other.part.key.end()) << name;
    found->value = value;
    return std::vector<PartFile>{first, other};
  };
  const auto text = [](const std::vector<PartFile>& parts, bool mixed = false) {
    return refusal([&] { (void)united(parts, mixed); });
  };
  EXPECT_EQ(text({first, second}), "");
  for (const char* what : {"a.part", "b.part", "--gather is 4 in", "and 5 in"})
    EXPECT_THAT(text(with("--gather", "5")), HasSubstr(what));
  EXPECT_THAT(text(with("layers of first hits", "uv")),
              HasSubstr("--aov (layers of first hits) is position,uv,object-id"));
  EXPECT_THAT(text(with("layers", "not given")), HasSubstr("--aov is given in"));
  EXPECT_THAT(text(with("geometry", "0")), HasSubstr("different scenes: their geometry"));
  EXPECT_THAT(text(with("version", "9.9")), HasSubstr("version is"));
  EXPECT_THAT(text(with("version", "9.9"), true), HasSubstr("version is"));
  for (const char* name : {"instruction set of the kernels", "instruction set of the rays"}) {
    EXPECT_THAT(text(with(name, "AVX9")), testing::AllOf(HasSubstr(name), HasSubstr("--mixed")));
    EXPECT_EQ(text(with(name, "AVX9"), true), "");
    // A merge of both takes part in mixed merges alone.
    PartFile mixture{"c.part", united(with(name, "AVX9"), true)};
    mixture.part.ranges = {{4, 5}};
    EXPECT_THAT(text({first, mixture}), HasSubstr("mixed in c.part"));
  }
  EXPECT_THAT(text({first, second, first}), HasSubstr("have samples in common: 1 to 2"));
  EXPECT_THAT(text({render(small_picture(8), {2, 8}, "c.part"), first}), HasSubstr("have samples in common: 2 to 2"));
}

TEST_F(PartTest, DamagedFilesAreRefused) {
  const PartFile part = render(small_picture(2), {1, 1}, "a.part");
  const std::string bytes = read("a.part");
  const auto take = [&](const std::string& damaged) {
    std::ofstream(path("b.part"), std::ios::binary) << damaged;
    const Part header = read_part(path("b.part"));
    Film film = film_for(header);
    add_part(path("b.part"), header, film);
  };
  EXPECT_EQ(refusal([&] { take(bytes); }), "");
  for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 97)
    EXPECT_THAT(refusal([&] { take(bytes.substr(0, size)); }), HasSubstr("not a whole part")) << size;
  for (std::size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 197) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    EXPECT_NE(refusal([&] { take(damaged); }), "") << at;
  }
  EXPECT_NE(refusal([&] { take(bytes + "x"); }), "");
}

TEST_F(PartTest, FilmsThatNoRenderCanGiveAreRefused) {
  const PartFile part = render(small_picture(4), {1, 2}, "a.part");
  Film film = merged({part});
  const auto take = [&](const Part& header, const Film& state) {
    write_part(path("b.part"), header, state);
    Film out = film_for(header);
    add_part(path("b.part"), read_part(path("b.part")), out);
  };
  EXPECT_EQ(refusal([&] { take(part.part, film); }), "");
  // More samples than the ranges have.
  Part fewer = part.part;
  fewer.ranges = {{0, 1}};
  EXPECT_THAT(refusal([&] { take(fewer, film); }), HasSubstr("not a whole part"));
  for (const std::vector<SampleRange>& ranges :
       std::vector<std::vector<SampleRange>>{{}, {{0, 9}}, {{2, 1}}, {{0, 2}, {1, 3}}}) {
    Part other = part.part;
    other.ranges = ranges;
    EXPECT_THAT(refusal([&] { take(other, film); }), HasSubstr("not a whole part"));
  }
  // A film of another size, and one of another kind.
  Part smaller = part.part;
  smaller.picture.settings.bounds.x1 = 15;
  EXPECT_THAT(refusal([&] { take(smaller, film); }), HasSubstr("not a whole part"));
  Part plain = part.part;
  plain.picture.settings.aovs.clear();
  EXPECT_THAT(refusal([&] { take(plain, film); }), HasSubstr("not a whole part"));
}

TEST(Parts, SharesAreDisjointAndCompleteForAnyNumber) {
  RenderSettings settings;
  for (const std::uint32_t samples : {1u, 5u, 16u, 1u << 24})
    for (const std::uint32_t count : {1u, 2u, 3u, 7u, 16u, 1000u}) {
      settings.samples = samples;
      std::uint32_t end = 0;
      for (std::uint32_t i = 1; i <= count; ++i) {
        settings.part = {i, count};
        EXPECT_EQ(settings.sample_range().first, end);
        end = settings.sample_range().end;
        EXPECT_LE(settings.sample_range().count(), samples / count + 1);
      }
      EXPECT_EQ(end, samples);
    }
}

TEST(Parts, NamesOfAnyBytesComeBack) {
  const Stage stage(builtin_scene("cornell"));
  Job job(stage.scene, stage.tracer, small_picture(1));
  job.wait();
  Part part = part_of(job);
  for (int byte = 1; byte < 256; ++byte)
    part.picture.objects.push_back("name" + std::string(2, static_cast<char>(byte)));
  const TemporaryFolder folder;
  const std::string path = folder.path("part");
  write_part(path, part, job.snapshot());
  const Part read = read_part(path);
  EXPECT_EQ(read.picture.objects, part.picture.objects);
}

}  // namespace
}  // namespace glowworm
