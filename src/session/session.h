// An interactive session without a window: states in, frames out.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "core/interrupt.h"
#include "core/memory_budget.h"
#include "core/spare_memory.h"
#include "core/statistics.h"
#include "gather/light_edges.h"
#include "maps/pass.h"
#include "maps/photon_maps.h"
#include "scene/light_rig.h"
#include "session/frame_sums.h"
#include "session/history.h"
#include "session/pace.h"
#include "session/view_frame.h"
#include "session/view_state.h"
#include "trace/tracer.h"

namespace glowworm {

/// Settings of a session that do not depend on the view.
struct SessionSettings {
  bool adapt = false;             ///< keep the frame rate of moving views with fewer pixels, rays and photons
  double frames_per_second = 15;  ///< target of adapting
  std::uint32_t seed = 0;
  std::uint64_t memory_bytes = 0;  ///< 0: half of the machine's
};

/// The moments of a scene that moves.
struct SceneMoments {
  std::function<std::shared_ptr<const Scene>(double seconds)> at;  ///< may throw
  double seconds = 0;  ///< the moment of the scene that the session begins with
  double length = 0;   ///< of the animation, s; 0: nothing moves
};

/// Renders frame after frame of one scene and redoes only what changed from state to state: the photon map survives a
/// moved camera, radii and indices survive a changed mode, and light edits rebuild only the structure of moved lights.
/// Frames of a changed view are quick: their maps lack boundary correction and bright patches unless these exist
/// already. While the state stays, passes accumulate without end, with the maps, the film and the filter of a Job;
/// after some, with new photons and smaller radii, as in progressive renders. If frames do not adapt, they depend only
/// on states and times, not on the machine.
class Session {
 public:
  /// Builds the acceleration structure, on all threads.
  Session(std::shared_ptr<const Scene> scene, const SessionSettings& settings, SceneMoments moments = {});
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// The scene's first camera, unedited lights, and the scene's size or 512 x 512.
  ViewState initial_state() const;
  const Scene& scene() const { return *base_; }
  /// The lights of the first moment, which ViewState::lights edits.
  const LightRig& rig() const { return rig_; }

  /// Renders the next frame. Throws Error for an impossible state, and Cancelled when interrupted; the next call then
  /// continues from the finished steps.
  /// @param seconds of the session's clock; never less than in the previous call
  /// @param interacting the user is active: the frame is timed even if nothing changed
  ViewFrame next_frame(const ViewState& state, double seconds, bool interacting, const Interrupt& interrupt);
  /// As above, without interruption.
  ViewFrame next_frame(const ViewState& state, double seconds);

  /// Makes the next frame trace new photons although the lights are unchanged: for measurements.
  void forget_photons();

  const MemoryBudget& budget() const { return budget_; }
  const Statistics& statistics() const { return statistics_; }

 private:
  struct Change;
  Change compare(const ViewState& state) const;
  void show_moment(const ViewState& state);
  void set_lights(const ViewState& state);
  PhotonMapSettings map_settings(const ViewState& state, std::uint64_t photons, bool moving) const;
  PassSettings pass_settings(const ViewState& state, const FrameEffort& effort, bool moving) const;
  void update_maps(const ViewState& state, std::uint64_t photons, bool moving);
  std::shared_ptr<const EmissionGuide> make_guide(const ViewState& state);
  const PhotonMaps& resting_maps(const ViewState& state);
  FrameEffort plan(const ViewState& state, bool moving) const;
  ViewFrame render(const ViewState& state, bool moving);
  void reuse(ViewFrame& frame, double seconds);
  void forget_sums();
  void show_resting(const ViewState& state, double pass_seconds, ViewFrame& frame);
  void show_false_colors(const ViewState& state, const std::vector<RGB>& diagnosis, ViewFrame& frame) const;
  void learn(const ViewFrame& frame);

  SessionSettings settings_;
  SceneMoments moments_;
  std::shared_ptr<const Scene> base_;
  LightRig rig_;                        // of the first moment
  LightRig moment_rig_;                 // of base_
  std::shared_ptr<const Scene> scene_;  // in the light of state_
  std::unique_ptr<Tracer> tracer_;
  bool movable_ = false;  // whether the tracer's structure has movable triangles

  MemoryBudget budget_;
  std::unique_ptr<Reservation> spare_reservation_;
  std::unique_ptr<FreedMemoryKeeper> spare_memory_;
  Statistics statistics_;
  PhotonMaps maps_{budget_}, refined_{budget_};
  bool has_maps_ = false;  // maps_ are of this light
  std::uint64_t map_photons_ = 0;
  std::shared_ptr<const EmissionGuide> map_guide_;                     // of maps_; null: by power alone
  std::shared_ptr<const EmissionGuide> guide_;                         // that maps_ shall have at rest
  GatherGuide gather_guide_;                                           // of the view at rest
  bool guided_ = false;                                                // guide_ was asked for in this light
  std::optional<std::shared_ptr<const EmissionGuide>> refined_guide_;  // of this view; none: not asked for yet
  std::optional<KnownLightEdges> edges_;                               // of the view at rest
  PassMemory pass_memory_;
  FrameSums sums_{budget_};
  ViewImage filtered_;                  // newest filtered picture of sums_
  std::uint32_t filtered_samples_ = 0;  // of that picture
  std::uint32_t next_filter_ = 0;       // samples of the next one
  History history_;
  Pace pace_;

  bool started_ = false;
  ViewState state_;                  // of the last frame
  double history_seconds_ = 0;       // time of the last frame in the history
  std::uint32_t moving_sample_ = 0;  // number of the camera sample of the last frame in motion
};

}  // namespace glowworm
