#include "render/checkpoint.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "builtin/builtin.h"
#include "core/error.h"
#include "render/job.h"

namespace glowworm {
namespace {

std::string temporary_path(const char* name) {
  return (std::filesystem::temp_directory_path() / (std::string(name) + std::to_string(::getpid()))).string();
}

RenderSettings small_render(std::uint32_t samples, bool progressive) {
  RenderSettings s;
  s.width = 24;
  s.height = 20;
  s.samples = samples;
  s.gather = 4;
  s.photons = 3000;
  s.progressive = progressive;
  return s;
}

class CheckpointTest : public testing::Test {
 protected:
  std::shared_ptr<const Scene> scene = std::make_shared<const Scene>(builtin_scene("cornell"));
  std::shared_ptr<const Tracer> tracer = std::make_shared<const Tracer>(*scene);
};

TEST_F(CheckpointTest, ResumedRenderHasTheBitsOfAnUninterruptedOne) {
  for (const bool progressive : {false, true}) {
    Job begun(scene, tracer, small_render(2, progressive));
    begun.wait();
    const std::string path = temporary_path("checkpoint");
    write_checkpoint(path, begun.checkpoint());
    const auto read = read_checkpoint(path);
    std::remove(path.c_str());
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

TEST_F(CheckpointTest, OtherRendersAreRefused) {
  Job begun(scene, tracer, small_render(1, false));
  begun.wait();
  const Checkpoint checkpoint = begun.checkpoint();
  RenderSettings other = small_render(2, false);
  other.seed = 7;
  EXPECT_THROW(Job(scene, tracer, other, &checkpoint), Error);
}

TEST_F(CheckpointTest, OtherMemoryIsRefusedWhereItWouldShowInTheBits) {
  for (const char* engine : {"blocked", "knn", "reverse"}) {
    RenderSettings settings = small_render(2, false);
    settings.engine = engine;
    settings.memory_bytes = std::uint64_t{512} << 20;
    Job begun(scene, tracer, settings);
    begun.wait();
    const Checkpoint checkpoint = begun.checkpoint();
    settings.samples = 3;
    EXPECT_NO_THROW(Job(scene, tracer, settings, &checkpoint).wait()) << engine;
    settings.memory_bytes /= 2;
    if (std::string(engine) == "knn") {
      EXPECT_NO_THROW(Job(scene, tracer, settings, &checkpoint).wait());
      continue;
    }
    try {
      const Job job(scene, tracer, settings, &checkpoint);
      ADD_FAILURE() << engine;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("--memory 536870912"), std::string::npos) << error.what();
    }
  }
}

TEST_F(CheckpointTest, DamagedFilesAreRefusedAndMissingOnesAreNone) {
  Job begun(scene, tracer, small_render(1, false));
  begun.wait();
  const std::string path = temporary_path("damaged");
  EXPECT_FALSE(read_checkpoint(path));
  write_checkpoint(path, begun.checkpoint());
  const auto size = std::filesystem::file_size(path);
  for (const std::uintmax_t cut : {size - 1, size / 2, std::uintmax_t{12}, std::uintmax_t{0}}) {
    write_checkpoint(path, begun.checkpoint());
    std::filesystem::resize_file(path, cut);
    EXPECT_THROW(read_checkpoint(path), Error) << cut;
  }
  write_checkpoint(path, begun.checkpoint());
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(size / 2));
  file.put('\x5a');
  file.close();
  EXPECT_THROW(read_checkpoint(path), Error);
  std::remove(path.c_str());
}

}  // namespace
}  // namespace glowworm
