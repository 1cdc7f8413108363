// A running render: one future-like object for the command line, tests and benchmarks.
#pragma once
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "control/adaptive.h"
#include "control/scheduler.h"
#include "control/time_fit.h"
#include "control/time_limit.h"
#include "core/disk_memory.h"
#include "core/interrupt.h"
#include "core/memory_budget.h"
#include "core/statistics.h"
#include "film/checkpoint.h"
#include "film/earlier_frames.h"
#include "film/film.h"
#include "film/filtered.h"
#include "gather/light_edges.h"
#include "glowworm/statistics.h"
#include "maps/pass.h"
#include "maps/photon_guiding.h"
#include "maps/photon_maps.h"
#include "maps/photon_report.h"
#include "settings/render_key.h"
#include "settings/settings.h"
#include "share/crew.h"
#include "share/share_folder.h"
#include "trace/tracer.h"

namespace glowworm {

using api::Ending;

/// Numbers that were left to the program.
struct ChosenNumbers {
  std::uint64_t photons = 0;
  std::uint32_t nearest = 0, gather = 0, light_samples = 0;
};

/// What a render learns of the scene: the same for all frames of a sequence.
struct JobGuides {
  std::shared_ptr<const EmissionGuide> guide;
  std::shared_ptr<const PhotonImportance> importance;
  GatherGuide gather_guide;
  bool has_gather_guide = false;
  float fixed_radius = 0;  ///< with RenderSettings::fixed_radius, if it is automatic: metres; 0: not yet known
  std::optional<ChosenNumbers> numbers;  ///< of all frames of a sequence, once its first has chosen them
  /// Job::photon_variance() of all frames of a sequence, or of all slices of time of a picture, once it is measured.
  std::optional<double> photon_variance;
  /// Hash of the moment of a sequence that all of this comes from, whatever moment is rendered; "": not yet known. It
  /// is part of Job::key(), since the same moment after another first one has other photons.
  std::string first_moment;
};

/// What earlier Jobs of the same picture have done, for its statistics.
struct EarlierWork {
  Statistics statistics;
  std::vector<LightPhotons> lights;  ///< of the last Job that traced photons
  std::uint64_t tasks = 0;
  std::uint64_t photon_map_bytes = 0, query_point_bytes = 0;  ///< of the last Jobs that had some
};

/// The photons of a render, what guides them and the gather rays, and samples.
struct JobMaps : JobGuides {
  PhotonMaps maps;
  std::optional<Film> rows;                    ///< finished samples that the next Job starts with; it takes them out
  std::shared_ptr<const EarlierWork> earlier;  ///< of the Jobs that made `rows`, if they are of the same picture

  explicit JobMaps(MemoryBudget& budget) : maps(budget) {}
  /// Forgets the photons: the next Job has another moment of the scene. @param learned what it is guided by
  void change_scene(JobGuides learned);
};

class Job;

/// What a job's end depends on beside its settings.
struct JobEnd {
  /// Does with a part of the film what the caller does with all of it after the job, without leaving files. The job
  /// measures how long it takes.
  using Rehearsal = std::function<void(const Film&, const Job&)>;

  double spent_s = 0;              ///< seconds of the limit already used
  Rehearsal rehearsal;             ///< called by the render's thread; null: the filter alone is measured
  std::uint32_t least_passes = 1;  ///< passes that are finished, however long they take
  FrameLights earlier;             ///< frames of a sequence whose light counts where the noise is measured

  JobEnd(double spent_s = 0, Rehearsal rehearsal = nullptr, std::uint32_t least_passes = 1, FrameLights earlier = {})
      : spent_s(spent_s), rehearsal(std::move(rehearsal)), least_passes(least_passes), earlier(std::move(earlier)) {}
};

/// A render in its own thread (its parallel loops use all threads). Every pass renders one camera sample of every
/// pixel, in tiles, so the first pass is a whole, noisy image.
class Job {
 public:
  /// Starts the render. @param asked is resolved first; throws its errors here, later ones from wait().
  /// @param resume continues from this film; throws Error if the checkpoint belongs to another render. Ranks other
  /// than 0 need its key alone.
  /// @param points  renders irradiance (W m^-2) at these points in place of radiance in the camera's pixels; the
  /// settings take the size of the grid, and their bounds, if not empty, are a part of it
  /// @param ranks   share the work: rank 0 has the picture, the others compute for it
  /// @param maps    of another Job that is destroyed, over the same scene and points with the same settings but for
  /// their bounds, or but for the camera and the frame of a sequence (RenderSettings::guide_cameras); over another
  /// moment of the scene after JobMaps::change_scene(); null: new ones
  Job(std::shared_ptr<const Scene> scene, std::shared_ptr<const Tracer> tracer, const RenderSettings& asked,
      const Checkpoint* resume = nullptr, JobEnd end = {}, std::shared_ptr<const PointGrid> points = nullptr,
      std::shared_ptr<Ranks> ranks = nullptr, std::shared_ptr<JobMaps> maps = nullptr);
  ~Job();  ///< cancels and waits
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  /// Stops the render after the task under way, or at once during photon tracing.
  /// Safe in signal handlers.
  void cancel() { interrupt_.request(); }
  /// Waits for the end; throws the render's error, at every call. Several threads may wait.
  void wait();
  /// True once the render has ended, for any reason.
  bool done() const { return done_; }
  /// Waits for the end, but no longer than this (s). Returns whether it is done.
  bool wait_for(double seconds) const;
  Ending ending() const { return ending_; }

  /// Finished share of the work, in [0, 1]: by samples, or by time if the time limit ends it first. That time includes
  /// what follows the job.
  double progress() const;
  /// Passes (camera samples of every pixel) done so far, of settings().sample_range().
  std::uint32_t passes() const { return passes_; }
  /// The work under way.
  enum class Step { photons, map, waiting, picture, rounds };
  Step step() const {
    if (is_mapping_ && shared_ && shared_->is_waiting()) return Step::waiting;
    if (is_mapping_) return made_->maps.is_building() ? Step::map : Step::photons;
    return in_rounds_ ? Step::rounds : Step::picture;
  }
  /// Mean number of samples of a pixel, at any time.
  double mean_samples() const;
  /// Finished tasks, with those of earlier Jobs of the picture: parts that are computed from start to end at once.
  std::uint64_t tasks() const { return tasks_; }
  /// Wall seconds since the start, or up to the end.
  double seconds() const;

  /// A copy of the current film; at any time.
  Film snapshot() const;
  /// The film itself, once the render has ended.
  const Film& film() const { return film_; }
  /// The state to continue from: the film after the last complete task; at any time. The first call hashes the scene.
  Checkpoint checkpoint() const;
  /// Film::not_finite() of the current film; at any time.
  std::uint64_t samples_not_finite() const;
  /// Everything that determines the bits of the samples. The first call hashes the scene.
  RenderKey key() const;
  /// The settings as resolved. Until the first task, photons and gather rays may still become fewer, or photons
  /// more: see is_fitted() and has_more_photons().
  RenderSettings settings() const;
  /// Whether photons or gather rays are fewer than resolve() chose, because the machine is too slow for the time limit.
  bool is_fitted() const { return fitted_; }
  /// Whether photons are more than resolve() chose, because their noise was too large for the noise asked for.
  bool has_more_photons() const { return has_more_photons_; }
  /// PictureInfo::photon_variance; 0 before the photons are traced.
  double photon_variance() const { return photon_variance_; }
  /// What the camera sees of the picture.
  FrameView frame_view() const;
  /// For the next Job.
  std::shared_ptr<JobMaps> maps() const { return made_; }
  /// The same for a Job of the next slice of time, which adds its samples to this one's.
  std::shared_ptr<JobMaps> maps_for_next_slice() const;
  const Statistics& statistics() const { return statistics_; }
  Statistics& statistics() { return statistics_; }
  /// Fate of the photons so far, by light; at any time. Before any, those of the Job before, if it had the same
  /// picture. Empty for the path tracer.
  std::vector<LightPhotons> light_photons() const;
  const MemoryBudget& budget() const { return budget_; }
  /// Where film, image and photons are, because the memory budget is too small for them; null: in memory.
  const DiskMemory* disk() const { return disk_.get(); }
  /// The most that they take there, in bytes.
  std::uint64_t disk_bytes() const { return disk_budget_.peak(); }
  /// The other ranks, of rank 0; null if there are none.
  Crew* crew() { return crew_.get(); }
  const Scene& scene() const { return *scene_; }
  /// The points that are rendered; null: the camera's pixels.
  const PointGrid* points() const { return points_.get(); }
  /// Groups of lights that the film keeps apart; null: none.
  const LightGroups* light_groups() const { return light_groups_.get(); }
  /// Query points to and from files, after the end of the render.
  const DiskTraffic& query_traffic() const { return memory_.disk; }
  std::uint64_t photon_map_bytes() const { return photon_map_bytes_; }
  std::uint64_t query_point_bytes() const { return query_point_bytes_; }
  /// Memory of the process at the start of the render: program, scene and acceleration structure.
  std::uint64_t scene_bytes() const { return scene_bytes_; }
  /// Peak memory of the process since then, beyond scene_bytes(); 0 if the system does not report it.
  std::uint64_t peak_beside_scene_bytes() const;
  /// Peak memory of the process.
  std::uint64_t peak_resident() const;

 private:
  /// The budget of film, image and photons.
  MemoryBudget& array_budget() { return disk_ ? disk_budget_ : budget_; }
  /// Batches of the samples of a pixel.
  std::uint32_t batches() const { return points_ ? points_->batches : 1; }
  void run();
  void render_passes();
  /// Adaptive sampling after the passes.
  void render_rounds();
  /// A share of the whole render's work, in [0, 1].
  struct WorkShare {
    double begin, end;
  };
  /// The squares of the next round; empty if it ends the render.
  /// @param choice_s estimated seconds of a choice
  SquareSamples choose_round(double& choice_s, WorkShare& share);
  bool render_tasks(std::vector<CameraTask> tasks, WorkShare share);
  bool share_pass(std::uint32_t first_sample, std::uint32_t samples, WorkShare share);
  bool share_tasks(const std::vector<CameraTask>& tiles, std::uint32_t samples_at_once, WorkShare share);
  void work_for_rank_0();
  /// Light of tasks, as a film takes it.
  struct TaskResult {
    SlotRadiance radiance;
    FirstHit first_hit;
    std::uint64_t not_finite = 0;  ///< samples that are black because their light was not finite
  };
  TaskResult compute(CameraTasks places);
  void add_samples(Film& film, CameraTasks places, const TaskResult& result) const;
  void put(CameraTasks places, const TaskResult& result);
  void put(const CameraTask& task, const Film& film);
  PhotonMapSettings map_settings(const RenderSettings& s, std::uint32_t pass) const;
  PassSettings pass_settings();
  View view() const;
  /// What photons and gather rays are guided to.
  View guide_view() const;
  /// Of passes that guides learn from: the same for all frames of a sequence.
  PassSettings guide_pass() const;
  /// Makes the guide of photons for these settings, unless they are there or not wanted.
  void guide_emission(const RenderSettings& s, Statistics& statistics);
  /// Makes the maps for these settings, and what guide_emission() makes.
  void make_maps(const RenderSettings& s, std::uint32_t sample, Statistics& statistics);
  /// The processes that divide the photons of a pass with this one; null: none.
  SharedWork* sharers(std::uint32_t pass) const;
  void shoot_photons(std::uint32_t sample);
  /// Measures Job::photon_variance(), and takes more photons if it is too large for the noise asked for. All ranks and
  /// renders that continue do the same.
  void find_photon_noise(std::uint32_t sample);
  bool take_more_photons();
  /// Makes the photon map and the schedule of a pass, unless they are there.
  void prepare(std::uint32_t done);
  /// Reduces the automatic numbers of photons and gather rays to what the time limit leaves room for. Not for renders
  /// by several processes.
  void fit_to_time();
  /// Wall seconds of a typical task of the picture, for each camera sample of a pixel, with the present maps.
  double measure_slot();
  /// @param next_s estimated seconds of the next piece of work
  bool should_stop(double next_s);
  /// Measures what follows the last sample.
  void rehearse();
  void resume(const Checkpoint& checkpoint);
  /// Whether samples tell the noise of points well enough to stop by it.
  bool knows_noise() const;
  bool reached_noise_target();
  /// The picture whose noise is measured.
  FilmPicture measured_picture() const { return shown_picture(film_, settings_, earlier_ ? &*earlier_ : nullptr); }
  /// The relative error of the film at which the render ends; 0: none.
  double noise_of_samples() const;

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Tracer> tracer_;
  std::shared_ptr<const PointGrid> points_;
  std::vector<const Camera*> guide_cameras_;  // empty: the camera alone
  std::optional<EarlierFrames> earlier_;
  RenderSettings settings_;  // only the render's thread writes, with the mutex
  mutable std::mutex settings_mutex_;
  AutomaticNumbers automatic_;                       // none of a render that continues from a checkpoint
  std::shared_ptr<const LightGroups> light_groups_;  // null: not kept apart
  MemoryBudget budget_, disk_budget_;
  std::unique_ptr<DiskMemory> disk_;
  std::optional<Reservation> disk_pages_;
  // A copy of the film for readers during the render. Allocated before the film, so that a film that does not fit is
  // never allocated.
  Reservation film_memory_;
  Statistics statistics_;
  mutable std::mutex film_mutex_;
  Film film_;
  std::optional<KnownLightEdges> edges_;  // where there are surface samples
  SquareSamples round_;                   // under way; empty: none
  mutable std::mutex done_mutex_;
  mutable std::condition_variable done_changes_;
  mutable std::mutex key_mutex_;
  mutable std::optional<RenderKey> key_;
  std::vector<LightPhotons> light_photons_, earlier_lights_;
  std::chrono::steady_clock::time_point start_;
  JobEnd job_end_;
  TimeLimit time_;
  std::atomic<double> end_seconds_{0};
  double task_seconds_ = 0, photon_seconds_ = 0;  // of the last task, and the last pass of photons
  double slot_seconds_ = 0;                       // wall time of a camera sample of the newest task; 0 before the first
  Interrupt interrupt_;
  std::atomic<bool> done_{false}, is_mapping_{false}, in_rounds_{false}, fitted_{false}, has_more_photons_{false};
  std::atomic<Ending> ending_{Ending::running};
  std::atomic<std::uint32_t> passes_{0};
  std::atomic<double> work_done_{0}, photon_variance_{0};
  std::uint64_t scene_bytes_ = 0, earlier_peak_ = 0;
  std::atomic<std::uint64_t> tasks_{0}, photon_map_bytes_{0}, query_point_bytes_{0};
  std::uint64_t most_kept_bytes_ = 0;  // of light paths, for another moment of the scene
  bool owns_maps_;                     // false: another Job made them
  std::shared_ptr<JobMaps> made_;
  std::unique_ptr<ShareFolder> shared_;  // null: photons are not shared
  PassMemory memory_;
  PassSettings pass_;
  Schedule schedule_;
  bool measures_photon_noise_ = false;   ///< it is still to be measured; of several parts, the first does
  std::optional<std::uint32_t> mapped_;  // the pass that map and schedule are of
  std::shared_ptr<Ranks> ranks_;
  std::unique_ptr<Crew> crew_;  // of rank 0
  std::exception_ptr failure_;
  std::mutex join_mutex_;
  std::thread thread_;
};

}  // namespace glowworm
