#include "photon/photon_tracer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <utility>

#include "core/archive.h"
#include "core/make_parts.h"
#include "core/parallel.h"
#include "photon/chunk_tracer.h"
#include "photon/kept_paths.h"
#include "photon/material_lobes.h"

namespace glowworm {

namespace {

/// Chunks of a piece of shared work, about a tenth of a second of a core, and most pieces of a wave.
constexpr std::uint64_t kChunksPerPiece = 128, kMostPieces = 64;

void add(FluxBalance& sum, const FluxBalance& part) {
  for (int c = 0; c < 3; ++c) {
    sum.emitted[c] += part.emitted[c];
    sum.arrived[c] += part.arrived[c];
    sum.scattered[c] += part.scattered[c];
    sum.escaped[c] += part.escaped[c];
    sum.cut[c] += part.cut[c];
    sum.stored[c] += part.stored[c];
  }
}

/// Adds up a chunk's counts by light, and separates its caustic photons.
void count(PhotonPass& pass, const PhotonChunk& chunk, const PhotonPassSettings& settings) {
  for (const std::uint32_t light : chunk.emitted_light)
    if (light != kNone) ++pass.emitted_by_light[light];
  for (const ChunkPhoton& photon : chunk.photons) {
    ++pass.stored_by_light[photon.light];
    // Without importance, all stored photons count as used.
    if (settings.importance) pass.used_by_light[photon.light] += photon.used;
    if (photon.caustic) pass.caustic.push_back(photon.position, photon.direction, photon.flux, photon.normal);
    if (!settings.keep_sources) continue;
    pass.global_source.push_back(photon.light);
    if (photon.caustic) pass.caustic_source.push_back(photon.light);
  }
  add(pass.balance, chunk.balance);
}

/// Appends a chunk to the pass.
void join(PhotonPass& pass, const PhotonChunk& chunk, const PhotonPassSettings& settings) {
  if (settings.choice == PhotonChoice::all)
    for (const ChunkPhoton& photon : chunk.photons)
      pass.global.push_back(photon.position, photon.direction, photon.flux, photon.normal);
  pass.segments.insert(pass.segments.end(), chunk.segments.begin(), chunk.segments.end());
  pass.in_media.append(chunk.in_media);
  pass.beams.append(chunk.beams);
  pass.stored += chunk.count() + (settings.choice == PhotonChoice::all ? 0 : chunk.segments.size());
  count(pass, chunk, settings);
}

/// Traces chunks [first, end) of a pass. Chunks are joined in order while others are being traced.
void trace_chunks(const ChunkTracer& chunk_tracer, std::uint64_t first, std::uint64_t end,
                  const std::function<void(const PhotonChunk&)>& join) {
  const auto trace = [&](std::size_t number, PhotonChunk& chunk) {
    chunk_tracer.trace((first + number) * kPathsPerChunk, kPathsPerChunk, chunk);
  };
  make_parts<PhotonChunk>(end - first, trace, join);
}

/// Adds chunks [first, end) to a pass, divided with other processes.
void share_chunks(const Tracer& tracer, const ChunkTracer& chunk_tracer, std::uint64_t first, std::uint64_t end,
                  const PhotonPassSettings& settings, PhotonPass& pass) {
  const std::uint64_t pieces = std::min((end - first + kChunksPerPiece - 1) / kChunksPerPiece, kMostPieces);
  const auto make = [&](std::size_t piece) {
    std::vector<std::byte> out;
    const std::uint64_t chunks = end - first;
    trace_chunks(chunk_tracer, first + chunks * piece / pieces, first + chunks * (piece + 1) / pieces,
                 [&](const PhotonChunk& chunk) {
                   const std::vector<std::byte> bytes = archived(chunk);
                   out.insert(out.end(), bytes.begin(), bytes.end());
                 });
    return out;
  };
  PhotonChunk chunk;
  const auto take = [&](std::size_t piece, std::span<const std::byte> bytes) {
    const std::uint64_t chunks = (end - first) * (piece + 1) / pieces - (end - first) * piece / pieces;
    // Nothing is joined before all of the piece is known to be sound.
    for (const bool sound : {false, true}) {
      ArchiveReader in(bytes);
      for (std::uint64_t i = 0; i < chunks; ++i) {
        transfer(in, chunk);
        require(chunk.is_possible(tracer.scene()));
        if (sound) join(pass, chunk, settings);
      }
      require(in.at_end());
    }
  };
  settings.shared->divide("photons-" + std::to_string(settings.pass) + "-" + std::to_string(first), pieces, make, take);
}

/// Traces paths until the pass has the wanted photons, and adds them.
void trace_waves(const Tracer& tracer, const PhotonPassSettings& settings, PhotonPass& pass) {
  // The last wave exceeds the wanted number; reserved memory that is never written costs nothing. Nothing grows later:
  // other threads append, and this one may place arrays on disk.
  if (settings.choice == PhotonChoice::all)
    pass.global.reserve(settings.photons + settings.photons / 32 + 8 * kPathsPerChunk);
  const ChunkTracer chunk_tracer(tracer, settings);
  const std::uint64_t limit = settings.max_emitted ? settings.max_emitted : 200 * settings.photons;
  // The first paths, of which each may store so many photons; but the first chunk tells whether they store far more.
  constexpr std::uint64_t kPhotonsAPath = 8;
  const std::uint64_t first_chunks = std::max<std::uint64_t>(1, settings.photons / kPhotonsAPath / kPathsPerChunk);
  std::uint64_t next_chunks = 1;
  while (pass.stored < settings.photons && pass.emitted < limit) {
    const std::uint64_t first = pass.emitted / kPathsPerChunk, end = first + next_chunks;
    if (settings.shared)
      share_chunks(tracer, chunk_tracer, first, end, settings, pass);
    else
      trace_chunks(chunk_tracer, first, end, [&](const PhotonChunk& chunk) { join(pass, chunk, settings); });
    pass.emitted = end * kPathsPerChunk;
    // If nothing is stored (only glass, or lights that miss the scene), more paths do not help.
    if (pass.stored == 0 && pass.emitted >= settings.photons) break;
    // The yield so far gives the number of paths still needed, in whole chunks, so it does not depend on threads.
    const double yield = std::max(static_cast<double>(pass.stored) / static_cast<double>(pass.emitted), 1e-3);
    const double missing = static_cast<double>(settings.photons) - static_cast<double>(pass.stored);
    // The number of wanted photons bounds a wave: the yield of a few paths may be far too low.
    const std::uint64_t left = (limit - std::min(limit, pass.emitted) + kPathsPerChunk - 1) / kPathsPerChunk;
    const std::uint64_t longest = std::min(settings.photons / kPathsPerChunk + 1, left);
    next_chunks = std::min(static_cast<std::uint64_t>(std::max(missing, 0.0) / yield / kPathsPerChunk) + 1, longest);
    if (end == 1 && first_chunks > 1 && next_chunks + 1 >= first_chunks) next_chunks = first_chunks - 1;
  }
}

void scale(PhotonPass& pass, std::uint64_t emitted) {
  const float factor = static_cast<float>(1.0 / static_cast<double>(emitted));
  parallel_for_each(pass.global.size(), 4096, [&](std::size_t i) { pass.global.flux[i] *= factor; });
  for (RGB& flux : pass.caustic.flux) flux *= factor;
  for (PhotonSegment& segment : pass.segments) segment.flux *= factor;
  for (RGB& flux : pass.in_media.flux) flux *= factor;
  for (RGB& flux : pass.beams.flux) flux *= factor;
  const double exact = 1.0 / static_cast<double>(emitted);
  FluxBalance& b = pass.balance;
  for (auto* sum : {&b.emitted, &b.arrived, &b.scattered, &b.escaped, &b.cut, &b.stored})
    for (double& v : *sum) v *= exact;
}

}  // namespace

PhotonPass trace_photons(const Tracer& tracer, const PhotonPassSettings& settings, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::trace_photons);
  PhotonPass pass;
  pass.emitted_by_light.resize(tracer.scene().light_source_count());
  pass.stored_by_light.resize(tracer.scene().light_source_count());
  pass.used_by_light.resize(tracer.scene().light_source_count());
  // Without a place for photons, more paths do not help.
  if (settings.choice != PhotonChoice::all || settings.discs || settings.on_all_surfaces ||
      may_have_lobes(tracer.scene(), kBroad) || !tracer.scene().media().empty())
    trace_waves(tracer, settings, pass);
  if (!settings.importance) pass.used_by_light = pass.stored_by_light;
  scale(pass, std::max<std::uint64_t>(1, pass.emitted));
  statistics.add(Counter::photons_emitted, pass.emitted);
  statistics.add(Counter::photons_stored, pass.stored);
  if (settings.kept) statistics.add(Counter::photons_kept, settings.kept->kept_photons());
  return pass;
}

namespace {

/// Traces paths [first, first + paths.size()) of a pilot pass. Returns how many photons they store.
std::uint64_t trace_pilot_paths(const ChunkTracer& chunk_tracer, double power, const PhotonPassSettings& settings,
                                std::uint64_t first, std::span<PilotPath> paths) {
  std::atomic<std::uint64_t> stored = 0;
  parallel_for(0, paths.size(), kPathsPerChunk, [&](std::size_t begin, std::size_t end) {
    PhotonChunk chunk;
    chunk_tracer.trace(first + begin, end - begin, chunk);
    stored += chunk.photons.size();
    for (std::size_t i = 0; i < chunk.numbers.size(); ++i) {
      paths[begin + i].numbers = chunk.numbers[i];
      paths[begin + i].density = 1 / chunk.guide_weight[i];
    }
    const auto add_score = [&](std::uint32_t path, RGB flux) {
      paths[begin + path].score +=
          static_cast<float>(luminance(flux) / static_cast<double>(chunk.guide_weight[path]) / power);
    };
    for (const ChunkPhoton& photon : chunk.photons)
      add_score(photon.path,
                photon.flux * importance_for(settings, photon.position, photon.normal, photon.caustic != 0));
    for (std::size_t i = 0; i < chunk.segments.size(); ++i) add_score(chunk.segment_path[i], chunk.segments[i].flux);
  });
  return stored;
}

}  // namespace

std::vector<PilotPath> trace_pilot(const Tracer& tracer, const PhotonPassSettings& settings, std::uint64_t first,
                                   std::size_t count, std::uint64_t& photons_left) {
  const ChunkTracer chunk_tracer(tracer, settings, true);
  const double power = tracer.scene().light_power().total();
  std::vector<PilotPath> paths;
  std::uint64_t stored = 0;
  while (paths.size() < count && photons_left > 0) {
    // The first chunk tells how many paths store the photons that are left.
    const double each = static_cast<double>(stored) / static_cast<double>(std::max<std::size_t>(1, paths.size()));
    std::size_t wave = std::min(count - paths.size(), kPathsPerChunk);
    if (!paths.empty()) {
      const double chunks = static_cast<double>(photons_left) / std::max(each, 1e-6) / kPathsPerChunk;
      wave = static_cast<std::size_t>(
          std::min(static_cast<double>(count - paths.size()), std::ceil(chunks) * static_cast<double>(kPathsPerChunk)));
    }
    const std::size_t before = paths.size();
    paths.resize(before + wave);
    const std::uint64_t more =
        trace_pilot_paths(chunk_tracer, power, settings, first + before, std::span(paths).subspan(before));
    stored += more;
    photons_left -= std::min(photons_left, more);
  }
  return paths;
}

}  // namespace glowworm
