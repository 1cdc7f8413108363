// Light paths that are kept for other moments of a moving scene.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/box_tree.h"
#include "core/rgb.h"
#include "core/vec.h"
#include "photon/photon_chunk.h"
#include "scene/changed_places.h"

namespace glowworm {

/// A photon as it leaves its light; all bytes 0 if it has no flux.
struct EmittedPath {
  Vec3 origin, direction;
  RGB flux;  ///< W
  std::uint32_t light = 0, medium = 0;
};

/// The paths of a chunk of a pass, and their photons.
struct KeptChunk {
  std::uint32_t moment = 0;          ///< number of the pass, from 1; 0: the chunk is not kept
  std::vector<EmittedPath> emitted;  ///< of each path
  PathPhotons left;                  ///< parts in order of paths, then of bounces

  std::uint64_t bytes() const { return emitted.capacity() * sizeof(EmittedPath) + left.bytes(); }
};

/// A pass of photons, path by path, for the same pass at another moment of the scene: a path stays if it leaves its
/// light as before and none of its straight parts meets a place that changed. What it leaves then has the bits of a
/// path that is traced again: random numbers belong to the path, and a hit depends on the ray and the triangle alone
/// (TieRule::number). Where media are, all paths change if looked_at_box() does.
class KeptPaths {
 public:
  /// What guides a pass; null: nothing does.
  struct Guides {
    std::shared_ptr<const EmissionGuide> emission;
    std::shared_ptr<const PhotonImportance> importance;
    bool operator==(const Guides&) const = default;
  };

  /// Makes what is kept of the moment before available to a pass. It must be one of PhotonChoice::all without discs,
  /// and all in this process, by a tracer with TieRule::number.
  /// @param guides what the pass's guide and importance belong to, kept so that no other has their addresses
  /// @param most_bytes that paths and the geometry of their moment may take; paths for which there is no room are
  /// traced again each time
  void begin(const Tracer& tracer, const PhotonPassSettings& pass, Guides guides, std::uint64_t most_bytes);
  /// Forgets everything.
  void clear();

  /// The paths of a chunk, counted from 0. Any thread may call it, each for other chunks; the reference stays.
  KeptChunk& chunk(std::uint64_t number);
  /// For each path of a chunk whether it goes as it did before. @param emitted now
  std::vector<bool> staying_paths(const KeptChunk& before, const std::vector<EmittedPath>& emitted) const;
  /// Joins paths of a chunk that stay and those that were followed.
  /// @param before the chunk at the moment before; it becomes that of this one, unless there is no room
  /// @param emitted now @param now what the paths left that were followed, parts in order of bounces, then of paths;
  /// then what all left
  void join(KeptChunk& before, const std::vector<bool>& stays, std::vector<EmittedPath> emitted, PathPhotons& now);

  /// Photons of the last pass that were not traced again.
  std::uint64_t kept_photons() const { return kept_photons_; }
  std::uint64_t bytes() const { return bytes_; }

 private:
  /// What the paths of a pass depend on beside scene and light.
  struct Pass {
    std::uint32_t seed, pass;
    int max_bounces;
    bool on_all_surfaces;
    Guides guides;
    std::array<Vec3, 2> looked_at;  ///< corners of looked_at_box() where media are
    bool operator==(const Pass&) const = default;
  };

  /// Notes the moment that paths are of, if there is room for its geometry; else none are kept.
  void keep_moment(const Scene& scene);
  /// Whether there is room for so many more bytes, which are then taken.
  bool take_room(std::uint64_t bytes);
  /// Whether the parts of a path meet no place that changed.
  bool meets_nothing(Vec3 origin, std::span<const PathPart> parts) const;

  std::optional<Pass> pass_;
  std::optional<SceneMoment> moment_;
  std::uint32_t number_ = 0;  // of the pass; a pass may need fewer chunks than the one before
  BoxTree changed_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<KeptChunk>> chunks_;
  std::atomic<std::uint64_t> bytes_ = 0, kept_photons_ = 0;
  std::uint64_t most_bytes_ = 0, moment_bytes_ = 0;
};

}  // namespace glowworm
