// One picture of `glowworm render`, or one of the jobs that make it.
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "apps/attend.h"
#include "apps/output_files.h"
#include "apps/render_outputs.h"
#include "apps/tev_stream.h"
#include "control/job.h"
#include "film/earlier_frames.h"
#include "import/import.h"
#include "scene/light_rig.h"
#include "scene/scene.h"
#include "share/crew.h"
#include "share/ranks.h"
#include "trace/tracer.h"

namespace glowworm {

/// A scene, ready to render.
struct Opened {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;
  std::shared_ptr<const LightRig> named;        ///< the lights that --light may name, at any moment; null: no --light
  std::chrono::steady_clock::time_point start;  ///< of the render
  double load_s = 0, build_s = 0;
  ImportOptions import;  ///< of other moments
};

/// Loads the scene of the command line, in its view and light. Throws CommandLineError if these do not fit the scene.
/// @param helps whether this process is a rank that prints nothing @param motion to import with it; null: none
Opened open_render(RenderOptions& o, OutputFiles& files, bool helps, std::shared_ptr<SceneMotion> motion);

/// When a picture with motion blur has enough samples: its slices of time share a number that is known before.
struct BlurGoal {
  double noise = 0, end_s = 0;                         ///< --noise, and --time from `start`; 0: not asked for
  std::chrono::steady_clock::time_point start, begun;  ///< of the first try, and of this one
  std::uint32_t samples = 0, most;                     ///< of this try, and of any
  std::uint32_t next = 0;                              ///< of the next one; 0: this one is enough
};

/// What a job leaves to later ones.
struct Kept {
  std::optional<BlurGoal> goal;                ///< of the picture that the jobs render
  std::shared_ptr<JobMaps> maps;               ///< null: none
  std::optional<JobGuides> guides;             ///< of all moments with the light of the first, if things or lamps move
  std::shared_ptr<const Statistics> learning;  ///< of the job that made `guides`, for those of the next picture
  bool is_resumed = false;                     ///< whether a job went on from the checkpoint of --resume
  bool is_described = false;                   ///< whether what is rendered has been printed
  WorkPart part;                            ///< of the picture, for progress: the samples of a job, if ranks share it
  std::shared_ptr<const FrameLight> light;  ///< of a frame, if any uses light again
};

/// What becomes of the samples of a job that does not end early: a picture, those of a picture's next slice of time, a
/// part that a rank sends, or the light of a frame alone. For maps there are none (RenderSettings::only_maps). Parts
/// and maps that end early throw Cancelled.
enum class Purpose { picture, slice, share, light, maps };

/// Ends the other ranks, and warns of what failed there. Those that do not answer are aborted.
/// @param status of this process
void dismiss_ranks(Crew& crew, Ranks& ranks, int status);

/// Renders one picture, and returns the exit status.
/// @param ranks that share the work; null: this process alone
/// @param kept of the job before, and then of this one; null: there is one job
int render_picture(const RenderOptions& o, const Opened& opened, OutputFiles& files, TevStream& tev,
                   const std::shared_ptr<Ranks>& ranks, Kept* kept = nullptr, Purpose purpose = Purpose::picture);

}  // namespace glowworm
