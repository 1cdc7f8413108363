#include "photon/photon_chunk.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/archive.h"

namespace glowworm {

template <>
inline constexpr bool kPlain<ChunkPhoton> = sizeof(ChunkPhoton) == 60;
template <>
inline constexpr bool kPlain<PhotonSegment> = sizeof(PhotonSegment) == 56;
template <>
inline constexpr bool kPlain<FluxBalance> = sizeof(FluxBalance) == 144;

std::uint64_t PathPhotons::bytes() const {
  const auto of = [](const auto& array) { return array.capacity() * sizeof(array[0]); };
  return of(parts) + of(photons) + of(in_media_place) + of(beam_place) + in_media.size() * bytes_each<VolumePhotons>() +
         beams.size() * bytes_each<VolumeBeams>();
}

void PhotonChunk::clear() {
  parts.clear();
  photons.clear();
  segments.clear();
  segment_path.clear();
  in_media.clear();
  in_media_place.clear();
  beams.clear();
  beam_place.clear();
  balance = {};
  emitted_light.clear();
  numbers.clear();
  guide_weight.clear();
}

void add(std::array<double, 3>& sum, RGB flux) {
  for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += static_cast<double>(flux[c]);
}

template <typename Archive>
void PhotonChunk::transfer(Archive& archive) {
  const auto batch = [&](auto& photons_in_media) {
    photons_in_media.for_arrays(
        [&](auto& array) {
          glowworm::transfer(archive, array);
          require(array.size() == photons_in_media.size());
        },
        photons_in_media);
  };
  batch(in_media);
  batch(beams);
  transfer_all(archive, photons, segments, balance, emitted_light);
}
template void PhotonChunk::transfer(ArchiveWriter& archive);
template void PhotonChunk::transfer(ArchiveReader& archive);

bool PhotonChunk::is_possible(const Scene& scene) const {
  constexpr float kOfLength = 0.01f;  // far above the rounding of unit vectors
  const std::size_t lights = scene.light_source_count();
  const Box3 box = scene.bounds();
  const Vec3 middle = (box.min + box.max) / 2;
  const float reach = length(box.diagonal());  // twice as far as the corners
  const auto is_unit = [](Vec3 v) { return std::abs(length_squared(v) - 1) < kOfLength; };
  for (const ChunkPhoton& p : photons) {
    const bool possible = length(p.position - middle) <= reach && is_unit(p.direction) && is_unit(p.normal) &&
                          is_finite(p.flux) && p.light < lights && p.path < kPathsPerChunk && p.caustic <= 1 &&
                          p.used <= 1;
    if (!possible) return false;
  }
  for (const PhotonSegment& segment : segments) {
    const bool possible = std::isfinite(dot(segment.origin, segment.origin)) && segment.length >= 0 &&
                          is_unit(segment.direction) && is_finite(segment.flux) && is_finite(segment.absorption) &&
                          segment.light < lights;
    if (!possible) return false;
  }
  const auto are_possible = [&](const auto& batch, const auto& places) {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const bool possible = std::isfinite(dot(places[i], places[i])) && is_unit(batch.direction[i]) &&
                            is_finite(batch.flux[i]) && batch.medium[i] < scene.media().size() &&
                            batch.source[i] < lights;
      if (!possible) return false;
    }
    return true;
  };
  if (!are_possible(in_media, in_media.position) || !are_possible(beams, beams.origin)) return false;
  for (const float length : beams.length)
    if (!(length >= 0) || !std::isfinite(length)) return false;
  const auto is_source = [&](std::uint32_t source) { return source == kNone || source < lights; };
  return emitted_light.size() <= kPathsPerChunk && std::all_of(emitted_light.begin(), emitted_light.end(), is_source);
}

}  // namespace glowworm
