// The table of options: values parse as printed, and the checkpoint key covers all options that change bits.
#include "settings/options.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <set>
#include <string>

#include "builtin/builtin.h"
#include "core/error.h"
#include "render_testing.h"
#include "settings/render_key.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

/// A tiny render in which every option has an effect but --prefer.
RenderSettings tiny_render() {
  RenderSettings s = by_photons(12, 1, 4, 2000);
  s.engine = "forward";
  s.light_samples = 2;
  s.filter = Filtering::automatic;
  return s;
}

/// A value that an option has in none of these tests otherwise.
std::string other_value(const Option& option, const RenderSettings& settings) {
  // A camera may have any name; "table" is one of the scene's.
  for (const char* text :
       {"table",   "given", "not given", "off",   "on",   "independent", "path", "fixed",     "cone",    "never",
        "quality", "depth", "knn",       "13x11", "3000", "77",          "256M", "0,0.5,1,1", "1,2,7,9", "1/1"}) {
    RenderSettings changed = settings;
    try {
      option.parse(changed, text);
    } catch (const Error&) {
      continue;
    }
    if (option.print(changed) != option.print(settings)) return text;
  }
  ADD_FAILURE() << option.name << " takes none of the texts";
  return "";
}

TEST(Options, ParseWhatTheyPrint) {
  for (const Option& option : render_options()) {
    const RenderSettings standard;
    for (const std::string& text : {option.print(standard), other_value(option, standard)}) {
      RenderSettings once, twice;
      option.parse(once, text);
      option.parse(twice, option.print(once));
      EXPECT_EQ(option.print(once), option.print(twice)) << option.name;
    }
    RenderSettings changed;
    option.parse(changed, other_value(option, changed));
    option.parse(changed, option.print(standard));
    EXPECT_EQ(option.print(changed), option.print(standard)) << option.name;
  }
}

TEST(Options, RefuseValuesThatOnlyAProgramCanSet) {
  check_settings(RenderSettings());
  check_settings(tiny_render());
  const auto refused = [](const auto& change) {
    RenderSettings settings;
    change(settings);
    try {
      check_settings(settings);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double value : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(refused([&](RenderSettings& s) { s.time_limit_s = value; }).find("--time"), std::string::npos);
    EXPECT_NE(refused([&](RenderSettings& s) { s.noise_target = value; }).find("--noise"), std::string::npos);
  }
  EXPECT_NE(refused([](RenderSettings& s) { s.kernel = static_cast<KernelShape>(77); }).find("77"), std::string::npos);
  EXPECT_NE(refused([](RenderSettings& s) { s.integrator = static_cast<Integrator>(3); }), "");
  EXPECT_NE(refused([](RenderSettings& s) { s.threads = -1; }), "");
  EXPECT_NE(refused([](RenderSettings& s) { s.max_bounces = -1; }), "");
  EXPECT_NE(refused([](RenderSettings& s) { s.memory_bytes = 1000; }), "");
  EXPECT_NE(refused([](RenderSettings& s) { s.aovs = {"dept"}; }), "");
}

TEST(Options, RejectInvalidValuesWithTheNearestName) {
  RenderSettings s;
  for (const Option& option : render_options()) {
    // Any text may be one.
    if (option.name == std::string("--camera") || option.name == std::string("--share")) continue;
    try {
      option.parse(s, "foward");
      ADD_FAILURE() << option.name;
    } catch (const Error& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find(std::string(option.name) + " 'foward'"), std::string::npos) << text;
      if (option.name == std::string("--engine")) {
        EXPECT_NE(text.find("Did you mean 'forward'?"), std::string::npos) << text;
      }
    }
  }
}

/// An option of which neither holds would let a checkpoint go on to other bits.
TEST(Options, AreInTheKeyOrChangeNoBits) {
  // These end a render sooner or later, but change no sample; the camera is in the key as a hash of its place.
  const std::set<std::string> ends = {"--samples", "--time", "--noise", "--crop"};
  Stage stage(builtin_scene("ajar"));
  const RenderSettings base = tiny_render();
  const std::vector<std::uint32_t> bits = stage.render(base).save();
  const TemporaryFolder folder;
  for (const Option& option : render_options()) {
    RenderSettings without = base;
    if (option.name == std::string("--thinned")) without.engine = "reverse";  // the others do not thin
    RenderSettings changed = without;
    option.parse(changed, other_value(option, base));
    const bool in_key = render_key(*stage.scene, changed) != render_key(*stage.scene, without);
    EXPECT_EQ(in_key, option.shows || option.name == std::string("--camera")) << option.name;
    if (!in_key && !ends.contains(option.name)) {
      if (!changed.share.empty()) changed.share = folder.path("share");
      EXPECT_EQ(stage.render(changed).save(), bits) << option.name;
      if (!changed.share.empty()) {
        EXPECT_GT(std::filesystem::remove_all(changed.share), 1u);
      }
    }
  }
}

TEST(Options, NameTheOptionThatOverrulesThem) {
  const auto overruled = [](const std::string& name, const RenderSettings& s) -> std::string {
    for (const Option& option : render_options())
      if (option.name == name) return option.has_effect(s) ? "" : option.overruled_by(s);
    ADD_FAILURE() << name;
    return "";
  };
  RenderSettings s = tiny_render();
  EXPECT_EQ(overruled("--gather", s), "");
  EXPECT_EQ(overruled("--reorder", s), "");
  s.engine = "auto";
  EXPECT_EQ(overruled("--reorder", s), "--engine auto");
  s.progressive = true;
  EXPECT_EQ(overruled("--prefer", s).substr(0, 13), "--progressive");
  s.integrator = Integrator::photons;
  EXPECT_EQ(overruled("--gather", s), "--integrator photons");
  EXPECT_EQ(overruled("--photons", s), "");
  s.integrator = Integrator::path;
  EXPECT_EQ(overruled("--photons", s), "--integrator path");
  EXPECT_EQ(overruled("--seed", s), "");
}

}  // namespace
}  // namespace glowworm
