// Vector emission of photons: the same bits as sample_emission() for each photon, on every instruction set.
#include "photon/emission_block.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <set>

#include "builtin/builtin.h"
#include "core/random.h"
#include "kernels/instruction_sets.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

EmissionNumbers numbers_of(std::uint32_t i) {
  EmissionNumbers numbers;
  for (std::uint32_t k = 0; k < numbers.size(); ++k) numbers[k] = to_unit_float(hash_combine(hash32(i), k));
  // The corners of the square and the middle of the disc.
  if (i % 31 == 0) numbers[i / 31 % 5] = i % 2 == 0 ? 0.0f : 0x1.fffffep-1f;
  if (i % 37 == 0) numbers[3] = numbers[4] = 0.5f;
  return numbers;
}

template <typename Value>
void expect_same_bits(const Value& a, const Value& b, std::uint32_t i, const char* what) {
  EXPECT_EQ(std::memcmp(&a, &b, sizeof(Value)), 0) << what << " of photon " << i;
}

/// Emits 500 photons; returns the kinds of light that they came from.
std::set<std::uint32_t> compare(const Scene& scene) {
  constexpr std::uint32_t kPhotons = 500;
  const auto block = std::make_unique<EmissionBlock>();
  std::set<std::uint32_t> lights;
  for (std::uint32_t first = 0; first < kPhotons; first += EmissionBlock::kBlock) {
    const std::uint32_t count = std::min<std::uint32_t>(EmissionBlock::kBlock, kPhotons - first);
    const auto weight = [&](std::uint32_t i) { return i % 3 == 0 ? 1.0f : 0.3f + static_cast<float>(i % 7); };
    for (std::uint32_t i = 0; i < count; ++i) block->set_numbers(i, numbers_of(first + i), weight(i));
    block->emit(scene, count);
    for (std::uint32_t i = 0; i < count; ++i) {
      const EmissionNumbers n = numbers_of(first + i);
      const EmittedPhoton expected = sample_emission(scene, n[0], {n[1], n[2]}, {n[3], n[4]});
      EXPECT_EQ(block->light(i), expected.light);
      expect_same_bits(block->flux(i), expected.flux * weight(i), first + i, "flux");
      lights.insert(expected.light);
      if (is_black(expected.flux)) continue;
      expect_same_bits(block->origin(i), expected.origin, first + i, "origin");
      expect_same_bits(block->direction(i), expected.direction, first + i, "direction");
    }
  }
  return lights;
}

TEST(EmissionBlock, EmitsWhatEachLightEmits) {
  for (const LightCase light : light_cases()) {
    SCOPED_TRACE(light_case_name(light));
    const Scene scene(lit_floor(light));
    on_every_instruction_set([&] {
      const std::set<std::uint32_t> lights = compare(scene);
      // All of them where there are several, so that kinds are mixed within a block.
      EXPECT_GE(lights.size(), light == LightCase::all ? 3u : 1u);
    });
  }
}

TEST(EmissionBlock, EmitsWhatScenesEmit) {
  for (const char* name : {"cornell", "atrium", "window-room"}) {
    SCOPED_TRACE(name);
    compare(Scene(builtin_scene(name)));
  }
}

TEST(EmissionBlock, EmitsNothingInTheDark) {
  const Scene lit(lit_floor(LightCase::point));
  SceneEdit dark;
  dark.emissions = lit.emissions();
  dark.lights = lit.lights();
  for (Light& light : dark.lights) light.intensity = RGB(0.0f);
  const Scene scene(lit, dark);
  ASSERT_EQ(scene.light_power().total(), 0);
  EXPECT_EQ(compare(scene), std::set<std::uint32_t>{kNone});
}

}  // namespace
}  // namespace glowworm
