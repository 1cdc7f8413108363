// Settings of a render, and resolve(), which replaces every automatic value.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/disk_memory.h"
#include "core/random.h"
#include "density/engine.h"
#include "glowworm/render.h"
#include "settings/layers.h"
#include "transport/roulette.h"

namespace glowworm {

class Scene;

using api::Integrator;

/// How a pass gets its query points ([HHS05], section 5.1).
enum class Preference : std::uint8_t {
  automatic,  ///< large tiles, and several samples of a pixel if one would give too few query points
  preview,    ///< the largest tiles, one sample of a pixel: the whole image improves evenly
  quality,    ///< after a first whole image, small tiles with as many samples at once as possible
};

/// Whether the image is filtered (film/filtered.h).
enum class Filtering : std::uint8_t {
  automatic,  ///< if light is gathered
  off,
};

/// Most pixels along a side of a picture.
inline constexpr int kMaxPictureSide = 65536;

/// Default camera samples of a pixel.
inline constexpr std::uint32_t kDefaultSamples = 8;

/// Default gather rays of a camera sample of a picture.
inline constexpr std::uint32_t kDefaultGather = 12;

/// A rectangle of pixels: columns [x0, x1) and rows [y0, y1), counted from the upper left corner of the picture.
struct PixelBounds {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(width()) * static_cast<std::uint64_t>(height());
  }
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  bool operator==(const PixelBounds&) const = default;
};

/// A part of a picture, as fractions of its width and height.
struct CropWindow {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  bool empty() const { return x0 >= x1 || y0 >= y1; }
  /// Pixels of the window: both ends of a side are rounded up, so that windows that touch share no pixel
  /// (as pbrt-v4's cropwindow). May be empty.
  PixelBounds pixels(int width, int height) const;
};

/// One of `count` shares of the camera samples of every pixel. Together the shares 1 to `count` have all samples, each
/// once.
struct SampleShare {
  std::uint32_t index = 0, count = 0;  ///< from 1; 0 of 0: all samples

  bool is_all() const { return count == 0; }
  bool operator==(const SampleShare&) const = default;
};

/// Camera samples [first, end) of every pixel.
struct SampleRange {
  std::uint32_t first = 0, end = 0;

  std::uint32_t count() const { return end - first; }
  bool operator==(const SampleRange&) const = default;
};

/// Settings of a render. 0, "auto" or empty means automatic; resolve() replaces these by numbers.
struct RenderSettings {
  Integrator integrator = Integrator::gather;
  std::string engine = "auto";
  std::uint32_t samples = 0;  ///< camera samples of each pixel, of all shares together
  SampleShare part;           ///< the share of them to render; all else describes the whole render
  /// The slice of the open shutter's time that is rendered: its share of the samples of the whole render. The film
  /// holds the samples of earlier slices (JobMaps::rows).
  SampleShare slice;
  std::uint32_t photon_stream = 0;                ///< selects the photons of the seed: each moving slice has its own
  std::string share;                              ///< folder for share/share_folder.h; empty: none
  std::uint32_t gather = 0;                       ///< final gather rays of each camera sample
  std::uint32_t default_gather = kDefaultGather;  ///< the same where `gather` is automatic and time is not short
  std::uint64_t photons = 0;                      ///< photons in the global map
  std::uint64_t thinned = 0;                      ///< how many of them density control leaves; 0: all
  std::uint32_t nearest = 0;                      ///< k: target number of photons in an estimate
  std::uint32_t light_samples = 0;                ///< light samples of each gather point
  KernelShape kernel = KernelShape::epanechnikov;
  bool fixed_radius = false;  ///< one radius for all photons, as in [SF07], in place of one for each
  float radius = 0;           ///< that radius, metres; 0: such that estimates have k photons on average
  std::uint32_t reorder = 0;  ///< engine forward: points in an octree cell that is not divided; 0: automatic
  int width = 0, height = 0;  ///< pixels of the whole picture
  CropWindow crop;            ///< the part of the picture to render; empty: what the scene's file asks for
  PixelBounds bounds;         ///< the same in pixels; empty: by `crop`
  std::string camera;         ///< name; empty is the scene's first
  /// Cameras that see what photons and gather rays are guided to: those along the way of a sequence of frames, whose
  /// frames then share maps and guides. Names; empty: `camera` alone.
  std::vector<std::string> guide_cameras;
  /// Number of a frame of a sequence. Camera samples and gather rays have random numbers of their own in each; photons
  /// and guides have the same in all.
  std::uint32_t frame = 0;
  bool scene_moves = false;  ///< frames show the scene at several moments: light paths are kept for the next
  bool only_maps = false;    ///< make photons and guides, but take no samples
  std::uint32_t seed = 0;
  int threads = 0;
  std::uint64_t memory_bytes = 0;
  DiskUse disk = DiskUse::automatic;
  Preference preference = Preference::automatic;
  double time_limit_s = 0;  ///< for samples and what follows them (control/time_limit.h); 0: no limit
  double noise_target = 0;  ///< relative standard error of the image at which it stops; 0: none
  /// The relative error for which the render chooses more photons (maps/photon_noise.h); 0: it does not. Set by
  /// resolve() to `noise_target` if photons are automatic.
  double photon_target = 0;
  /// Renders that end by time or noise give more samples to pixels with more noise (control/adaptive.h).
  bool adaptive = true;
  bool indirect_only = false;
  bool progressive = false;         ///< new photons for every pass, with radii that shrink from pass to pass
  bool guiding = true;              ///< emit photons where the image needs them (maps/photon_guiding.h)
  bool secondary_gather = true;     ///< gather rays that are short beside the photons' radius gather again at their end
  bool gather_guiding = true;       ///< aim gather rays at light (gather/gather_guide.h, gather/bright_patches.h)
  bool boundary_correction = true;  ///< correct kernels that extend over edges (maps/boundary.h)
  int max_bounces = kNoBounceLimit;  ///< most bounces of a path
  SamplerKind sampler = SamplerKind::sobol;
  Filtering filter = Filtering::automatic;
  bool media = false;      ///< the scene has some; set by resolve()
  bool of_points = false;  ///< points are rendered, and not what a camera sees; set by Job
  /// Extrapolate what sensors gather from photons (PassSettings::extrapolates). Their passes average the noise that it
  /// costs, and their stated error does not include bias. Job turns it off for everything else.
  bool extrapolates = true;
  bool separate_layers = true;          ///< keep the film's layers apart; always true if there are AOVs or a filter
  bool light_groups = false;            ///< keep the light of each name of light apart (scene/light_groups.h)
  std::uint32_t light_group_count = 0;  ///< of the scene, if light_groups; set by resolve()
  std::vector<std::string> aovs;        ///< layers in addition to the image; names of aov_names()

  /// What `aovs` need of the places that camera rays end at.
  PlaceLayers place_layers() const;
  /// The samples to render, by `samples` and `part`.
  SampleRange sample_range() const;
  /// The samples of sample_range() that belong to `slice`; may be none.
  SampleRange slice_range() const;
  /// Seed of photons.
  std::uint32_t photon_seed() const { return photon_stream == 0 ? seed : hash_combine(~seed, photon_stream); }
  /// Seed of camera samples and gather rays.
  std::uint32_t sample_seed() const { return frame == 0 ? seed : hash_combine(seed, frame); }
};

/// Names for RenderSettings::guide_cameras: at most 16, evenly spaced among all frames.
std::vector<std::string> guide_cameras(const std::vector<std::string>& names);

/// Whether the render filters its image.
bool filters(const RenderSettings& settings);

/// Whether the render's pixels get samples by their noise. In a progressive render they do not: each sample has photons
/// of its own.
/// @param settings resolved
bool is_adaptive(const RenderSettings& settings);

/// Whether a render has time for photons of the caustic map alone.
bool has_time_for_caustics(const RenderSettings& settings);

/// Default memory of a render: half of the machine's, rounded down so that it is the same at every start.
std::uint64_t default_memory_bytes();

/// Threads of a render that asks for none: one for each core, but only as many as the memory has room for.
/// @param memory_bytes of the render; 0: default_memory_bytes()
int default_threads(std::uint64_t memory_bytes, int cores);
/// Sets the number of threads of the process (core/parallel.h) to the one asked for, or default_threads().
void set_thread_count(const RenderSettings& asked);

/// Throws Error if the share cannot be rendered with the other settings as they are asked for: if the number of samples
/// depends on time or noise.
void check_part(const RenderSettings& asked);

/// Most slices of the time of a shutter.
inline constexpr std::uint32_t kMostSlices = 32;

/// Returns the settings with every automatic value replaced. Values that affect the picture depend only on the scene
/// and the other settings, never on the machine, its cores or its memory. Throws Error for impossible values (a size of
/// 0, an unknown AOV).
RenderSettings resolve(const RenderSettings& asked, const Scene& scene);

/// The automatic choices with their reasons, one a line.
/// @param chosen resolve(asked)
std::vector<std::string> choice_notes(const RenderSettings& asked, const RenderSettings& chosen);

}  // namespace glowworm
