// The same picture, bit for bit, for any number of threads, memory budget and use of the disk.
#include <gtest/gtest.h>

#include <optional>

#include "builtin/builtin.h"
#include "core/error.h"
#include "core/parallel.h"
#include "density/engine.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

using Bits = std::vector<std::uint32_t>;

/// How a render may differ without a difference in the picture.
struct Way {
  int threads;
  std::uint64_t megabytes;
  DiskUse disk;
};

std::ostream& operator<<(std::ostream& out, const Way& way) {
  return out << way.threads << " threads, " << way.megabytes << "M, disk " << static_cast<int>(way.disk);
}

/// The film's bits; nothing where the memory does not suffice.
std::optional<Bits> bits_of(const Stage& stage, RenderSettings settings, const Way& way) {
  set_thread_count(way.threads);
  settings.memory_bytes = way.megabytes << 20;
  settings.disk = way.disk;
  std::optional<Bits> bits;
  try {
    bits = stage.render(settings).save();
  } catch (const Error&) {
  }
  set_thread_count(0);
  return bits;
}

/// The least memory in megabytes, of steps of 4, with which the render runs.
std::uint64_t smallest_memory(const Stage& stage, RenderSettings settings, int threads) {
  settings.samples = 1;
  // Less than the rays of the threads take cannot do.
  for (std::uint64_t megabytes = 8 * static_cast<std::uint64_t>(threads); megabytes < 200; megabytes += 4)
    if (bits_of(stage, settings, {threads, megabytes, DiskUse::automatic})) return megabytes;
  return 200;
}

void expect_same_bits(const Stage& stage, const RenderSettings& settings, const std::vector<int>& threads,
                      const std::vector<std::uint64_t>& memories, const std::vector<DiskUse>& disks) {
  const auto expected = bits_of(stage, settings, {2, 4000, DiskUse::never});
  ASSERT_TRUE(expected);
  for (const int count : threads) {
    const std::uint64_t smallest = smallest_memory(stage, settings, count);
    std::vector<std::uint64_t> tried = {smallest};
    for (const std::uint64_t megabytes : memories)
      if (megabytes > smallest) tried.push_back(megabytes);
    for (const std::uint64_t megabytes : tried)
      for (const DiskUse disk : disks) {
        const Way way{count, megabytes, disk};
        const auto bits = bits_of(stage, settings, way);
        // Query points of a file need room for its cache, too.
        if (disk == DiskUse::always && megabytes == smallest && !bits) continue;
        ASSERT_TRUE(bits) << way;
        EXPECT_TRUE(*bits == *expected) << way;
      }
  }
}

/// A picture whose query points make several portions in little memory.
RenderSettings small_picture(const std::string& engine) {
  // Brute force goes over all pairs: it gets few of them.
  RenderSettings settings =
      engine == "brute" ? by_photons(12, 2, 4, 500, engine.c_str()) : by_photons(32, 2, 16, 4000, engine.c_str());
  settings.guiding = false;
  return settings;
}

const std::vector<DiskUse> kAllDisks = {DiskUse::automatic, DiskUse::always, DiskUse::never};

TEST(SameBits, OfBlockedAndReverseInLittleMemoryAndByDisk) {
  const Stage stage(builtin_scene("glass-sphere"));
  for (const char* engine : {"blocked", "reverse"}) {
    SCOPED_TRACE(engine);
    expect_same_bits(stage, small_picture(engine), {1, 3}, {}, {DiskUse::always, DiskUse::never});
  }
}

TEST(SlowSameBits, OfEveryEngineForThreadsMemoryAndDisk) {
  const Stage stage(builtin_scene("cornell"));
  for (const std::string& engine : engine_names()) {
    SCOPED_TRACE(engine);
    RenderSettings settings = small_picture(engine);
    settings.samples = 1;
    expect_same_bits(stage, settings, {1, 3}, {64, 256}, kAllDisks);
  }
}

TEST(SlowSameBits, OfGlossySurfacesCausticsAndProgressiveRenders) {
  const Stage glass(builtin_scene("glass-sphere")), glossy(builtin_scene("atrium"));
  for (const char* engine : {"blocked", "reverse"}) {
    SCOPED_TRACE(engine);
    RenderSettings settings = small_picture(engine);
    expect_same_bits(glossy, settings, {1, 3}, {256}, {DiskUse::always, DiskUse::never});
    settings.progressive = true;
    settings.guiding = true;
    expect_same_bits(glass, settings, {1, 3}, {256}, {DiskUse::always, DiskUse::never});
  }
}

TEST(SlowSameBits, OfRendersThatFillTheirMemory) {
  const Stage stage(builtin_scene("cornell"));
  const auto expect_same = [&](const RenderSettings& settings, const std::vector<Way>& ways) {
    const auto expected = bits_of(stage, settings, ways.front());
    ASSERT_TRUE(expected) << ways.front();
    for (const Way& way : std::vector<Way>(ways.begin() + 1, ways.end())) {
      const auto bits = bits_of(stage, settings, way);
      ASSERT_TRUE(bits) << way;
      EXPECT_TRUE(*bits == *expected) << way;
    }
  };
  RenderSettings settings = by_photons(256, 1, 16, 40'000, "blocked");
  settings.separate_layers = false;
  expect_same(settings, {{1, 52, DiskUse::automatic}, {3, 52, DiskUse::automatic}, {2, 1024, DiskUse::never}});
  settings = by_photons(256, 1, 16, 100'000, "reverse");
  settings.separate_layers = false;
  expect_same(settings, {{1, 100, DiskUse::automatic}, {4, 100, DiskUse::automatic}, {2, 1024, DiskUse::never}});
}

TEST(SameBits, DefaultsDoNotDependOnMemoryOrCores) {
  const Scene scene(builtin_scene("cornell"));
  for (const double limit : {0.0, 20.0}) {
    RenderSettings asked;
    asked.engine = "reverse";
    asked.time_limit_s = limit;
    asked.memory_bytes = std::uint64_t{128} << 20;
    set_thread_count(1);
    const RenderSettings small = resolve(asked, scene);
    set_thread_count(7);
    asked.memory_bytes = std::uint64_t{64} << 30;
    const RenderSettings large = resolve(asked, scene);
    set_thread_count(0);
    EXPECT_EQ(render_key(scene, small), render_key(scene, large)) << limit;
    EXPECT_EQ(small.samples, large.samples) << limit;
  }
}

TEST(SameBits, PhotonsThatDoNotFitAreAnErrorWithARemedy) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(16, 1, 4, 1'000'000);
  settings.memory_bytes = std::uint64_t{64} << 20;
  try {
    stage.render(settings);
    ADD_FAILURE();
  } catch (const Error& error) {
    const std::string text = error.what();
    for (const char* part : {"photon map", "1000000 photons", "--memory", "--photons"})
      EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace glowworm
