// One radius for all photons: chosen for k photons in a mean estimate, or given.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "settings/options.h"

namespace glowworm {
namespace {

double photons_per_query(const Statistics& statistics) {
  return static_cast<double>(statistics.count(Counter::shader_operations)) /
         static_cast<double>(statistics.count(Counter::query_points));
}

TEST(SlowFixedRadius, HoldsAsManyPhotonsOnAverageAsAreAskedFor) {
  // A closed room, and rooms of which few surfaces are lit. Guided rays go to these.
  for (const char* scene : {"cornell", "atrium", "ajar", "window-room"})
    for (const auto& [integrator, guided] : {std::pair(Integrator::gather, false), std::pair(Integrator::gather, true),
                                             std::pair(Integrator::photons, false)}) {
      SCOPED_TRACE(testing::Message() << scene << " guided " << guided);
      const Stage stage(builtin_scene(scene));
      RenderSettings settings = by_photons(48, 1, 16, 10'000, "blocked");
      settings.integrator = integrator;
      settings.indirect_only = true;
      settings.guiding = settings.gather_guiding = guided;
      settings.fixed_radius = true;
      settings.nearest = 60;
      Job job(stage.scene, stage.tracer, settings);
      job.wait();
      // A sample of the picture's query points gives the radius.
      EXPECT_NEAR(photons_per_query(job.statistics()), 60, 3);
    }
}

TEST(FixedRadius, IsTheOneThatIsGiven) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(16, 1, 4, 10'000, "blocked");
  for (const Option& option : render_options())
    if (std::string(option.name) == "--radius") option.parse(settings, "0.04");
  settings.aovs = {"radius"};
  const Film film = stage.render(settings);
  int found = 0;
  for (std::size_t i = 0; i < film.pixel_count(); ++i)
    if (const float radius = film.value(SlotValue::radius, i); radius > 0) {
      EXPECT_NEAR(radius, 0.04f, 1e-6f);
      ++found;
    }
  EXPECT_GT(found, 100);
}

}  // namespace
}  // namespace glowworm
