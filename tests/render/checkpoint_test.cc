#include "film/checkpoint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "builtin/builtin.h"
#include "control/job.h"
#include "core/error.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

RenderSettings small_render(std::uint32_t samples, bool progressive) {
  RenderSettings s;
  s.width = 24;
  s.height = 20;
  s.samples = samples;
  s.gather = 4;
  s.photons = 3000;
  s.progressive = progressive;
  s.filter = Filtering::off;  // so that layers may be left out
  return s;
}

class CheckpointTest : public FolderTest {
 protected:
  std::shared_ptr<const Scene> scene = std::make_shared<const Scene>(builtin_scene("cornell"));
  std::shared_ptr<const Tracer> tracer = std::make_shared<const Tracer>(*scene);
};

TEST_F(CheckpointTest, ResumedRenderHasTheBitsOfAnUninterruptedOne) {
  for (const bool progressive : {false, true}) {
    Job begun(scene, tracer, small_render(2, progressive));
    begun.wait();
    const std::string saved = path("checkpoint");
    write_checkpoint(saved, begun.checkpoint());
    const auto read = read_checkpoint(saved);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->passes, 2u);
    Job resumed(scene, tracer, small_render(5, progressive), &*read);
    resumed.wait();
    Job whole(scene, tracer, small_render(5, progressive));
    whole.wait();
    EXPECT_EQ(resumed.snapshot().save(), whole.snapshot().save());
    EXPECT_NE(begun.snapshot().save(), whole.snapshot().save());
  }
}

TEST_F(CheckpointTest, ResumingWithOtherMemoryAndThreadsGivesTheSameBits) {
  RenderSettings settings = small_render(2, false);
  settings.memory_bytes = std::uint64_t{512} << 20;
  Job begun(scene, tracer, settings);
  begun.wait();
  const Checkpoint checkpoint = begun.checkpoint();
  settings.samples = 4;
  settings.memory_bytes /= 4;
  settings.disk = DiskUse::always;
  settings.preference = Preference::quality;
  Job resumed(scene, tracer, settings, &checkpoint);
  resumed.wait();
  Job whole(scene, tracer, small_render(4, false));
  whole.wait();
  EXPECT_EQ(resumed.snapshot().save(), whole.snapshot().save());
}

/// As after adaptive sampling. With a limited time, tasks are cut, so that some pieces have their samples already.
TEST_F(CheckpointTest, UnevenSamplesAreContinuedInALimitedTime) {
  RenderSettings settings = small_render(1, false);
  settings.width = 320;
  settings.height = 32;
  Job one(scene, tracer, settings);
  one.wait();
  settings.samples = 2;
  Job two(scene, tracer, settings);
  two.wait();
  Film film = one.film().like(one.film().bounds());
  film.add({256, 0, 320, 16}, two.film());
  film.add({0, 0, 320, 32}, one.film());
  EXPECT_EQ(film.most_samples(), 2u);
  const Checkpoint checkpoint{key_text(one.key()), 1, film.save(), {}};
  settings.samples = 3;
  Job whole(scene, tracer, settings);
  whole.wait();
  settings.time_limit_s = 1000;
  Job resumed(scene, tracer, settings, &checkpoint);
  resumed.wait();
  EXPECT_EQ(resumed.passes(), 3u);
  EXPECT_TRUE(resumed.film().save() == whole.film().save());
}

/// What the error says that going on from the checkpoint is; fails where there is none.
std::string refusal(std::shared_ptr<const Scene> scene, std::shared_ptr<const Tracer> tracer,
                    const RenderSettings& settings, const Checkpoint& checkpoint) {
  try {
    const Job job(std::move(scene), std::move(tracer), settings, &checkpoint);
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "the checkpoint was taken";
  return "";
}

TEST_F(CheckpointTest, OtherSettingsAreRejectedByNameWithARemedy) {
  Job begun(scene, tracer, small_render(1, false));
  begun.wait();
  const Checkpoint checkpoint = begun.checkpoint();
  const auto refused = [&](auto&& change, const std::vector<std::string>& parts) {
    RenderSettings other = small_render(2, false);
    change(other);
    const std::string text = refusal(scene, tracer, other, checkpoint);
    for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
  };
  refused([](RenderSettings& s) { s.seed = 7; }, {"--seed is 0 there and 7 here", "Give --seed 0"});
  refused([](RenderSettings& s) { s.gather = 9; }, {"--gather is 4 there and 9 here", "Give --gather 4"});
  refused([](RenderSettings& s) { s.height = 21; }, {"--size is 24x20 there and 24x21 here"});
  refused([](RenderSettings& s) { s.engine = "knn"; }, {"--engine is ", " there and knn here"});
  refused([](RenderSettings& s) { s.progressive = true; }, {"--progressive", "Give no --progressive"});
  refused([](RenderSettings& s) { s.separate_layers = false; }, {"with --aov", "Give --aov"});
  refused([](RenderSettings& s) { s.aovs = {"cryptomatte"}; },
          {"--aov (layers of first hits) is none there and object-id,material-id here",
           "Give --aov without object-id,material-id"});
  refused([](RenderSettings& s) { s.integrator = Integrator::path; }, {"--integrator is gather there and path here"});
}

TEST_F(CheckpointTest, OtherScenesAreRejectedWithTheDifference) {
  Job begun(scene, tracer, small_render(1, false));
  begun.wait();
  const Checkpoint checkpoint = begun.checkpoint();
  const auto refused = [&](auto&& change, const char* part) {
    SceneDescription description = builtin_scene("cornell");
    change(description);
    const auto other = std::make_shared<const Scene>(std::move(description));
    const std::string text = refusal(other, std::make_shared<const Tracer>(*other), small_render(2, false), checkpoint);
    EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
  };
  refused([](SceneDescription& d) { d.materials.back().reflectance.value.r *= 0.5f; }, "its materials or textures");
  refused([](SceneDescription& d) { d.geometry.positions.front().x += 1e-6f; }, "its geometry");
  refused([](SceneDescription& d) { d.emissions.front().radiance.value *= 2; }, "its lights");
  refused([](SceneDescription& d) { d.cameras.front().half_extent *= 1.01f; }, "its camera");
  // A bake.
  Checkpoint of_points = checkpoint;
  RenderKey key = parse_key(checkpoint.key);
  key.push_back({"points", "0"});
  of_points.key = key_text(key);
  EXPECT_NE(refusal(scene, tracer, small_render(2, false), of_points).find("its points differ"), std::string::npos);
  // A frame after another first one; samples of a part of the shutter.
  for (const char* name : {"first moment", "samples of the shutter"}) {
    Checkpoint of_sequence = checkpoint;
    key = parse_key(checkpoint.key);
    key.push_back({name, "1"});
    of_sequence.key = key_text(key);
    EXPECT_NE(refusal(scene, tracer, small_render(2, false), of_sequence).find(name + std::string(" is 1 there")),
              std::string::npos);
  }
  // The same scene under another name is the same scene.
  SceneDescription renamed = builtin_scene("cornell");
  renamed.name = "box";
  const auto same = std::make_shared<const Scene>(std::move(renamed));
  EXPECT_NO_THROW(Job(same, std::make_shared<const Tracer>(*same), small_render(2, false), &checkpoint).wait());
}

TEST_F(CheckpointTest, OtherVersionsAndInstructionSetsAreRefusedByName) {
  Job begun(scene, tracer, small_render(1, false));
  begun.wait();
  Checkpoint checkpoint = begun.checkpoint();
  for (const char* name : {"version", "instruction set of the kernels", "instruction set of the rays"}) {
    RenderKey key = parse_key(begun.checkpoint().key);
    const auto part = std::find_if(key.begin(), key.end(), [&](const KeyPart& p) { return p.name == name; });
    ASSERT_NE(part, key.end()) << name;
    EXPECT_FALSE(part->value.empty());
    part->value = "another";
    checkpoint.key = key_text(key);
    const std::string text = refusal(scene, tracer, small_render(2, false), checkpoint);
    EXPECT_NE(text.find(std::string("its ") + name + " is another"), std::string::npos) << text;
  }
  for (const char* key : {"", "{}", "[1]", "[[]]", "[[\"version\",1]]", "\xff"}) {
    checkpoint.key = key;
    EXPECT_FALSE(refusal(scene, tracer, small_render(2, false), checkpoint).empty()) << key;
  }
}

TEST_F(CheckpointTest, ForgedCountsAndSumsAreRefused) {
  Job begun(scene, tracer, small_render(1, false));
  begun.wait();
  const Checkpoint good = begun.checkpoint();
  const auto refused = [&](const Checkpoint& forged) {
    const std::string text = refusal(scene, tracer, small_render(2, false), forged);
    EXPECT_NE(text.find("is corrupt"), std::string::npos) << text;
  };
  for (const std::uint32_t count : {0u, 2u, 1u << 25, 0xffffffffu, 0x7fc00000u}) {
    // After two words of a number come the counts of samples.
    Checkpoint forged = good;
    for (std::size_t i = 2; i < 2 + 24 * 20; ++i) forged.film[i] = count;
    refused(forged);
  }
  Checkpoint forged = good;
  for (std::size_t i = 2 + 24 * 20; i < forged.film.size(); ++i) forged.film[i] = 0x7f7fffffu;
  refused(forged);
  forged = good;
  forged.passes = 5;
  refused(forged);
  forged = good;
  forged.film.pop_back();
  refused(forged);
}

TEST_F(CheckpointTest, DamagedFilesAreRefusedAndMissingOnesAreNone) {
  Job begun(scene, tracer, small_render(1, false));
  begun.wait();
  const std::string saved = path("damaged");
  EXPECT_FALSE(read_checkpoint(saved));
  EXPECT_FALSE(read_key_of_checkpoint(saved));
  write_checkpoint(saved, begun.checkpoint());
  const auto key_alone = read_key_of_checkpoint(saved);
  ASSERT_TRUE(key_alone);
  EXPECT_EQ(key_alone->key, begun.checkpoint().key);
  EXPECT_TRUE(key_alone->film.empty());
  const auto size = std::filesystem::file_size(saved);
  for (const std::uintmax_t cut : {size - 1, size / 2, std::uintmax_t{12}, std::uintmax_t{0}}) {
    write_checkpoint(saved, begun.checkpoint());
    std::filesystem::resize_file(saved, cut);
    EXPECT_THROW(read_checkpoint(saved), Error) << cut;
  }
  write_checkpoint(saved, begun.checkpoint());
  std::fstream file(saved, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(size / 2));
  file.put('\x5a');
  file.close();
  EXPECT_THROW(read_checkpoint(saved), Error);
}

}  // namespace
}  // namespace glowworm
