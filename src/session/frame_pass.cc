#include "session/frame_pass.h"

#include <algorithm>

#include "core/parallel.h"
#include "gather/direct_light.h"
#include "gather/final_gather.h"

namespace glowworm {

namespace {

/// Bytes that a query point costs between its ray and completion.
constexpr std::uint64_t kBytesPerQuery = 2 * QueryPoints::kBytesEach + sizeof(RGB) + 64;

class PassRenderer {
 public:
  PassRenderer(const Tracer& tracer, const PhotonMaps& maps, const FramePassSettings& settings, MemoryBudget& budget,
               const Interrupt& interrupt, Statistics& statistics, FramePassMemory& memory)
      : tracer_(tracer),
        maps_(maps),
        settings_(settings),
        budget_(budget),
        interrupt_(interrupt),
        statistics_(statistics),
        memory_(memory) {
    memory_.reservation.reset();
  }
  ~PassRenderer() { memory_.keep(budget_); }
  PassRenderer(const PassRenderer&) = delete;
  PassRenderer& operator=(const PassRenderer&) = delete;

  FramePass render(const Camera& camera) {
    interrupt_.check();
    const CancellationScope scope(interrupt_.flag());
    CameraPassSettings camera_settings;
    camera_settings.width = settings_.width;
    camera_settings.height = settings_.height;
    camera_settings.seed = settings_.seed;
    const CameraTask task{0, 0, settings_.width, settings_.height, settings_.sample, 1};
    if (settings_.mode == ViewMode::photons) {
      camera_pass_queries(tracer_, camera, task, camera_settings, pass_.radiance, pass_.first_hit, memory_.queries,
                          statistics_);
      look_up(memory_.queries, maps_.engine(), pass_.radiance.indirect);
      return std::move(pass_);
    }
    GatherPoints& points = memory_.points;
    camera_pass(tracer_, camera, task, camera_settings, pass_.radiance, pass_.first_hit, points, statistics_);
    if (needs_diagnosis(settings_.mode))
      diagnose(points);
    else if (settings_.mode == ViewMode::gather)
      gather_light(points);
    return std::move(pass_);
  }

 private:
  void look_up(const QueryPoints& queries, const DensityEngine& engine, std::vector<RGB>& target) {
    memory_.found.assign(queries.size(), RGB());
    engine.estimate(queries, memory_.found, statistics_);
    complete(queries, memory_.found, target, statistics_);
  }

  bool wants(LightPart part) const { return settings_.part == LightPart::all || settings_.part == part; }

  void gather_light(const GatherPoints& points) {
    if (!(tracer_.scene().light_power().total() > 0)) return;
    if (wants(LightPart::direct))
      add_direct_light(tracer_, points, settings_.seed, usual_light_samples(settings_.gather), settings_.gather,
                       pass_.radiance, statistics_);
    if (wants(LightPart::caustic) && maps_.caustic_engine())
      look_up(gather_points_as_queries(points), *maps_.caustic_engine(), pass_.radiance.caustic);
    if (settings_.part == LightPart::caustic) return;
    gather(points, [&](const QueryPoints& queries) {
      if (wants(LightPart::indirect)) look_up(queries, maps_.engine(), pass_.radiance.indirect);
    });
  }

  /// Final gathering in portions; `answer` is called with the query points of each.
  template <typename Answer>
  void gather(const GatherPoints& points, Answer&& answer) {
    FinalGatherSettings gather_settings;
    gather_settings.rays = settings_.gather;
    gather_settings.seed = settings_.seed;
    gather_settings.light_samples = wants(LightPart::direct) ? usual_light_samples(settings_.gather) : 0;
    gather_settings.radii = settings_.corners ? &maps_.radii() : nullptr;
    const DensityEngine* caustics = settings_.corners && wants(LightPart::indirect) ? maps_.caustic_engine() : nullptr;
    // A ray that gathers again asks both maps.
    const std::uint64_t bytes_each = kBytesPerQuery * (caustics ? 2 : 1);
    const std::uint64_t room = budget_.available() / 2 / bytes_each;
    const auto at_once = static_cast<std::size_t>(std::min<std::uint64_t>(kQueriesAtOnce, room));
    const std::size_t most = std::max<std::size_t>(1, at_once / settings_.gather);
    const std::size_t portions = std::max<std::size_t>(1, (points.size() + most - 1) / most);
    const std::size_t step = (points.size() + portions - 1) / portions;
    for (std::size_t first = 0; first < points.size(); first += step) {
      interrupt_.check();
      const std::size_t last = std::min(first + step, points.size());
      const Reservation reservation(budget_, "query points", (last - first) * settings_.gather * bytes_each);
      final_gather(tracer_, points, first, last, gather_settings, pass_.radiance,
                   {memory_.queries, caustics ? &memory_.caustic_queries : nullptr}, statistics_);
      if (caustics) look_up(memory_.caustic_queries, *caustics, pass_.radiance.indirect);
      answer(memory_.queries);
    }
  }

  void diagnose(const GatherPoints& points) {
    pass_.diagnosis.assign(pass_.first_hit.depth.size(), RGB());
    if (maps_.empty() || !maps_.diagnosis()) return;
    const auto count = [&](QueryPoints& queries) {
      // Lambertian of reflectance pi: what the index holds is summed as it is.
      std::fill(queries.reflectance.begin(), queries.reflectance.end(), RGB(kPi));
      std::fill(queries.bsdf.begin(), queries.bsdf.end(), kLambertianQuery);
      std::fill(queries.weight.begin(), queries.weight.end(), RGB(1.0f));
      queries.bsdfs.clear();
      look_up(queries, *maps_.diagnosis(), pass_.diagnosis);
    };
    if (settings_.mode == ViewMode::cost)
      gather(points, count);
    else
      count(memory_.queries = gather_points_as_queries(points));
  }

  const Tracer& tracer_;
  const PhotonMaps& maps_;
  const FramePassSettings& settings_;
  MemoryBudget& budget_;
  const Interrupt& interrupt_;
  Statistics& statistics_;
  FramePassMemory& memory_;
  FramePass pass_;
};

}  // namespace

bool shows_light(ViewMode mode) { return mode == ViewMode::gather || mode == ViewMode::photons; }

bool needs_photons(ViewMode mode) { return mode != ViewMode::albedo && mode != ViewMode::normal; }

bool needs_diagnosis(ViewMode mode) {
  return mode == ViewMode::density || mode == ViewMode::radius || mode == ViewMode::cost;
}

void FramePassMemory::keep(MemoryBudget& budget) {
  const std::uint64_t bytes =
      points.slot.capacity() * GatherPoints::kBytesEach + queries.position.capacity() * QueryPoints::kBytesEach +
      queries.bsdfs.capacity() * sizeof(QueryBsdf) + caustic_queries.position.capacity() * QueryPoints::kBytesEach +
      caustic_queries.bsdfs.capacity() * sizeof(QueryBsdf) + found.capacity() * sizeof(RGB);
  reservation.reset();
  if (bytes > budget.available() / 2)
    *this = FramePassMemory();
  else
    reservation = std::make_unique<Reservation>(budget, "query points", bytes);
}

FramePass render_frame_pass(const Tracer& tracer, const PhotonMaps& maps, const Camera& camera,
                            const FramePassSettings& settings, MemoryBudget& budget, const Interrupt& interrupt,
                            Statistics& statistics, FramePassMemory& memory) {
  return PassRenderer(tracer, maps, settings, budget, interrupt, statistics, memory).render(camera);
}

}  // namespace glowworm
