#include "photon/photon_tracer.h"

#include <algorithm>
#include <limits>

#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"
#include "kernels/sobol.h"
#include "scene/light_sampling.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

constexpr std::size_t kPathsPerChunk = 1024;

/// Light paths under way, in structure-of-arrays form; finished ones are compacted away after every bounce.
struct Paths {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<RGB> flux;
  std::vector<std::uint32_t> number;  ///< of the path within its chunk
  std::vector<std::uint32_t> light;
  std::vector<std::uint8_t> sharp_only;  ///< every bounce so far was sharp
};

/// A pair of random numbers of every path under way.
struct Pairs {
  std::vector<float> x, y;
};
/// Pairs that emission takes; every bounce takes two.
constexpr std::uint32_t kEmissionPairs = 3;

/// What one chunk of paths leaves. Photons are in order of bounce; `path` says whose they are.
struct ChunkResult {
  PhotonBatch photons;
  std::vector<std::uint32_t> path;
  std::vector<std::uint32_t> light;
  std::vector<std::uint8_t> caustic;
  std::vector<std::uint8_t> used;
  FluxBalance balance;
  std::vector<std::uint32_t> emitted_light;
  std::vector<EmissionNumbers> numbers;  // that each path was emitted with
  std::vector<float> guide_weight;       // and the factor on its flux

  /// For a chunk of so many paths, and a photon of each.
  void reserve(std::size_t paths) {
    photons.reserve(paths);
    for (auto* array : {&path, &light}) array->reserve(paths);
    for (auto* array : {&caustic, &used}) array->reserve(paths);
    emitted_light.reserve(paths);
    numbers.reserve(paths);
    guide_weight.reserve(paths);
  }
};

void add(std::array<double, 3>& sum, RGB flux) {
  sum[0] += flux.r;
  sum[1] += flux.g;
  sum[2] += flux.b;
}

Ray photon_ray(Vec3 origin, Vec3 direction) { return {origin, 0, direction, std::numeric_limits<float>::infinity()}; }

/// What the shading normal does to arriving light: density estimation counts flux by the geometric cosine, the BSDF's
/// outgoing light goes by the shading one (Veach 1997, section 5.3.4). Bounded, since at grazing angles it is not.
float arrival_correction(Vec3 direction, Vec3 shading_normal, Vec3 geometric_normal) {
  const float geometric = std::abs(dot(direction, geometric_normal));
  const float shading = std::abs(dot(direction, shading_normal));
  return std::min(shading / std::max(geometric, 1e-6f), 8.0f);
}

/// How much the image asks for a photon: of the global map and, where it is one, of the caustic map.
float demand_for(const PhotonDemand& demand, Vec3 position, Vec3 normal, bool caustic) {
  return demand.gathered.value(position, normal) + (caustic ? demand.seen.value(position, normal) : 0.0f);
}

class ChunkTracer {
 public:
  ChunkTracer(const Tracer& tracer, const PhotonPassSettings& settings) : tracer_(tracer), settings_(settings) {}

  ChunkResult trace(std::uint64_t first_path, std::size_t count) {
    reserve(count);
    emit(first_path, count);
    for (int bounce = 0; !paths_.rays.empty(); ++bounce) {
      paths_.hits.resize(paths_.rays.size());
      tracer_.intersect(paths_.rays, paths_.hits, RayOrder::incoherent);
      draw_bounce(first_path, bounce);
      std::size_t kept = 0;
      for (std::size_t i = 0; i < paths_.rays.size(); ++i) {
        fetch_ahead(tracer_.scene(), i, paths_.hits.size(), [&](std::size_t at) { return paths_.hits[at].triangle; });
        if (scatter(i, bounce)) keep(i, kept++);
      }
      shrink(kept);
    }
    return std::move(result_);
  }

 private:
  void reserve(std::size_t count) {
    paths_.rays.reserve(count);
    paths_.hits.reserve(count);
    paths_.flux.reserve(count);
    paths_.number.reserve(count);
    paths_.light.reserve(count);
    paths_.sharp_only.reserve(count);
    result_.reserve(count);
  }

  /// Pair `dimension` of the paths' random numbers.
  void draw(std::uint32_t dimension, Pairs& pairs) {
    pairs.x.resize(index_.size());
    pairs.y.resize(index_.size());
    sobol_pairs(Sampler::pair_key(settings_.seed, hash_combine(0x70686f74u, settings_.pass), dimension), index_.data(),
                index_.size(), pairs.x.data(), pairs.y.data());
  }

  void emit(std::uint64_t first_path, std::size_t count) {
    index_.resize(count);
    for (std::size_t i = 0; i < count; ++i) index_[i] = static_cast<std::uint32_t>(first_path + i);
    Pairs light;
    draw(0, direction_);
    draw(1, choice_);
    draw(2, light);
    for (std::size_t i = 0; i < count; ++i) {
      EmissionNumbers numbers = {light.x[i], choice_.x[i], choice_.y[i], direction_.x[i], direction_.y[i]};
      const float guide_weight = settings_.guide ? settings_.guide->warp(numbers) : 1.0f;
      EmittedPhoton photon =
          sample_emission(tracer_.scene(), numbers[0], {numbers[1], numbers[2]}, {numbers[3], numbers[4]});
      photon.flux *= guide_weight;
      result_.numbers.push_back(numbers);
      result_.guide_weight.push_back(guide_weight);
      result_.emitted_light.push_back(photon.light);
      add(result_.balance.emitted, photon.flux);
      if (is_black(photon.flux)) continue;
      paths_.rays.push_back(photon_ray(photon.origin, photon.direction));
      paths_.flux.push_back(photon.flux);
      paths_.number.push_back(static_cast<std::uint32_t>(i));
      paths_.light.push_back(photon.light);
      paths_.sharp_only.push_back(1);
    }
  }

  /// The numbers of a bounce, of all paths at once: a pair for the choice of the lobe and for Russian roulette, and one
  /// for the direction.
  void draw_bounce(std::uint64_t first_path, int bounce) {
    index_.resize(paths_.number.size());
    for (std::size_t i = 0; i < index_.size(); ++i)
      index_[i] = static_cast<std::uint32_t>(first_path + paths_.number[i]);
    const auto dimension = kEmissionPairs + 2 * static_cast<std::uint32_t>(bounce);
    draw(dimension, choice_);
    draw(dimension + 1, direction_);
  }

  /// Stores the photon that path i leaves where it hits, and turns the path into its next piece; false where it ends.
  bool scatter(std::size_t i, int bounce) {
    const Hit& hit = paths_.hits[i];
    if (hit.triangle == kNone) {
      add(result_.balance.escaped, paths_.flux[i]);
      return false;
    }
    add(result_.balance.arrived, paths_.flux[i]);
    const Scene& scene = tracer_.scene();
    const Vec3 back = -paths_.rays[i].direction;
    DiffusePoint diffuse;
    Vec3 shading_normal;
    if (diffuse_point(scene, hit.triangle, hit.barycentric, diffuse) &&
        diffuse_shading_normal(scene, hit.triangle, hit.barycentric, diffuse, back, shading_normal))
      return scatter_diffuse(i, bounce, diffuse, shading_normal, back);
    SurfacePoint point = surface_point(scene, hit.triangle, hit.barycentric);
    const Bsdf bsdf = resolve_bsdf(scene, point, back);
    if (lobes(bsdf) & kBroad) store(i, point.position, point.geometric_normal, point.frame.n, back, bounce);
    const Vec3 wo = point.frame.to_local(back);
    const BsdfSample s = sample(bsdf, wo, choice_.x[i], {direction_.x[i], direction_.y[i]}, kAllLobes, Transport::flux);
    if (!s.valid) return false;
    return leave(i, bounce, point.position, point.geometric_normal, wo.z, s.wi.z, point.frame.to_world(s.wi), s.weight,
                 s.lobe == kSharp);
  }

  /// The same where nearly all paths end up: on a surface that only reflects diffusely, without frame and lobes.
  bool scatter_diffuse(std::size_t i, int bounce, const DiffusePoint& point, Vec3 shading_normal, Vec3 back) {
    if (is_black(point.reflectance)) return false;
    store(i, point.position, point.geometric_normal, shading_normal, back, bounce);
    const Vec3 n = face_forward(shading_normal, back);
    const Vec3 wi = square_to_cosine_hemisphere({direction_.x[i], direction_.y[i]});
    if (!(wi.z > 0)) return false;
    return leave(i, bounce, point.position, point.geometric_normal, dot(n, back), wi.z,
                 Frame::from_normal(n).to_world(wi), point.reflectance, false);
  }

  /// Sends path i on in a direction that was sampled with `weight`, or ends it by Russian roulette.
  /// @param cosine_in, cosine_out to the shading normal, with their signs
  bool leave(std::size_t i, int bounce, Vec3 position, Vec3 geometric_normal, float cosine_in, float cosine_out,
             Vec3 direction, RGB weight, bool sharp) {
    RGB& flux = paths_.flux[i];
    const float out_geometric = dot(direction, geometric_normal);
    const float in_geometric = -dot(paths_.rays[i].direction, geometric_normal);
    // A shading normal may send light through an opaque surface: such paths do not exist.
    if ((out_geometric * in_geometric > 0) != (cosine_out * cosine_in > 0) || out_geometric == 0) return false;
    // Veach 1997, equation 5.19: the adjoint BSDF under shading normals.
    const float adjoint =
        std::min(std::abs(cosine_in * out_geometric / std::max(std::abs(in_geometric * cosine_out), 1e-9f)), 8.0f);
    const RGB next = flux * weight * adjoint;
    const float survival = std::min(1.0f, max_component(next) / std::max(max_component(flux), 1e-30f));
    if (!(survival > 0) || choice_.y[i] >= survival) return false;
    flux = next / survival;
    add(result_.balance.scattered, flux);
    if (bounce + 1 >= settings_.max_bounces) {
      add(result_.balance.cut, flux);
      return false;
    }
    paths_.sharp_only[i] &= sharp;
    const Vec3 side = out_geometric > 0 ? geometric_normal : -geometric_normal;
    paths_.rays[i] = photon_ray(offset_origin(position, side), direction);
    return true;
  }

  void store(std::size_t i, Vec3 position, Vec3 geometric_normal, Vec3 shading_normal, Vec3 back, int bounce) {
    const Vec3 normal = face_forward(geometric_normal, back);
    const float correction = arrival_correction(back, shading_normal, normal);
    result_.photons.push_back(position, back, paths_.flux[i] * correction, normal);
    result_.path.push_back(paths_.number[i]);
    result_.light.push_back(paths_.light[i]);
    const bool caustic = bounce > 0 && paths_.sharp_only[i];
    result_.caustic.push_back(caustic);
    result_.used.push_back(!settings_.demand || demand_for(*settings_.demand, position, normal, caustic) > 0);
    add(result_.balance.stored, paths_.flux[i]);
  }

  void keep(std::size_t from, std::size_t to) {
    if (from == to) return;
    paths_.rays[to] = paths_.rays[from];
    paths_.flux[to] = paths_.flux[from];
    paths_.number[to] = paths_.number[from];
    paths_.light[to] = paths_.light[from];
    paths_.sharp_only[to] = paths_.sharp_only[from];
  }

  void shrink(std::size_t n) {
    paths_.rays.resize(n);
    paths_.flux.resize(n);
    paths_.number.resize(n);
    paths_.light.resize(n);
    paths_.sharp_only.resize(n);
  }

  const Tracer& tracer_;
  const PhotonPassSettings& settings_;
  Paths paths_;
  std::vector<std::uint32_t> index_;  // of the paths under way, among all of the pass
  Pairs choice_, direction_;
  ChunkResult result_;
};

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

/// Adds up what the chunk left by light, and sets its caustic photons apart.
void count(PhotonPass& pass, const ChunkResult& chunk) {
  for (const std::uint32_t light : chunk.emitted_light)
    if (light != kNone) ++pass.emitted_by_light[light];
  for (std::size_t i = 0; i < chunk.photons.size(); ++i) {
    ++pass.stored_by_light[chunk.light[i]];
    pass.used_by_light[chunk.light[i]] += chunk.used[i];
    if (chunk.caustic[i])
      pass.caustic.push_back(chunk.photons.position[i], chunk.photons.direction[i], chunk.photons.flux[i],
                             chunk.photons.normal[i]);
  }
  add(pass.balance, chunk.balance);
}

/// Appends one array of all chunks to that of the pass.
template <typename Array>
void append(PhotonPass& pass, const std::vector<ChunkResult>& chunks, Array array) {
  auto& to = pass.global.*array;
  for (const ChunkResult& chunk : chunks)
    to.insert(to.end(), (chunk.photons.*array).begin(), (chunk.photons.*array).end());
}

/// Joins the chunks of a wave in order.
void join(PhotonPass& pass, const std::vector<ChunkResult>& chunks) {
  parallel_for(0, 5, 1, [&](std::size_t part, std::size_t) {
    if (part == 0) append(pass, chunks, &PhotonBatch::position);
    if (part == 1) append(pass, chunks, &PhotonBatch::direction);
    if (part == 2) append(pass, chunks, &PhotonBatch::flux);
    if (part == 3) append(pass, chunks, &PhotonBatch::normal);
    if (part == 4)
      for (const ChunkResult& chunk : chunks) count(pass, chunk);
  });
}

void scale(PhotonPass& pass, std::uint64_t emitted) {
  const float factor = static_cast<float>(1.0 / static_cast<double>(emitted));
  for (RGB& flux : pass.global.flux) flux *= factor;
  for (RGB& flux : pass.caustic.flux) flux *= factor;
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
  // The last chunk brings more than are wanted; what is reserved and not written takes no memory.
  pass.global.reserve(settings.photons + 8 * kPathsPerChunk);
  const std::uint64_t limit = settings.max_emitted ? settings.max_emitted : 200 * settings.photons;
  std::uint64_t next_chunks = std::max<std::uint64_t>(1, settings.photons / 8 / kPathsPerChunk);
  while (pass.global.size() < settings.photons && pass.emitted < limit) {
    std::vector<ChunkResult> chunks(next_chunks);
    parallel_for(0, next_chunks, 1, [&](std::size_t first, std::size_t) {
      chunks[first] = ChunkTracer(tracer, settings).trace(pass.emitted + first * kPathsPerChunk, kPathsPerChunk);
    });
    join(pass, chunks);
    pass.emitted += next_chunks * kPathsPerChunk;
    // Where nothing at all is stored (glass alone, lights that miss the scene), more paths will not change that.
    if (pass.global.size() == 0 && pass.emitted >= settings.photons) break;
    // The yield so far says how many more paths are wanted; whole chunks, so that it never depends on threads.
    const double yield = std::max(static_cast<double>(pass.global.size()) / static_cast<double>(pass.emitted), 1e-3);
    const double missing = static_cast<double>(settings.photons) - static_cast<double>(pass.global.size());
    // A wave is at most as long as the photons wanted: the yield of a few paths may be far too low.
    const std::uint64_t longest =
        std::min(settings.photons, limit - std::min(limit, pass.emitted)) / kPathsPerChunk + 1;
    next_chunks = std::min(static_cast<std::uint64_t>(std::max(missing, 0.0) / yield / kPathsPerChunk) + 1, longest);
  }
  scale(pass, std::max<std::uint64_t>(1, pass.emitted));
  statistics.add(Counter::photons_emitted, pass.emitted);
  statistics.add(Counter::photons_stored, pass.global.size());
  return pass;
}

std::vector<PilotPath> trace_pilot(const Tracer& tracer, const PhotonPassSettings& settings, std::uint64_t first,
                                   std::size_t count) {
  std::vector<PilotPath> paths(count);
  const double power = tracer.scene().light_power().total();
  parallel_for(0, count, kPathsPerChunk, [&](std::size_t begin, std::size_t end) {
    const ChunkResult chunk = ChunkTracer(tracer, settings).trace(first + begin, end - begin);
    for (std::size_t i = 0; i < chunk.numbers.size(); ++i) {
      paths[begin + i].numbers = chunk.numbers[i];
      paths[begin + i].density = 1 / chunk.guide_weight[i];
    }
    for (std::size_t i = 0; i < chunk.photons.size(); ++i) {
      if (!chunk.used[i]) continue;
      const std::uint32_t path = chunk.path[i];
      const float demand =
          demand_for(*settings.demand, chunk.photons.position[i], chunk.photons.normal[i], chunk.caustic[i] != 0);
      paths[begin + path].score += static_cast<float>(demand * luminance(chunk.photons.flux[i]) /
                                                      static_cast<double>(chunk.guide_weight[path]) / power);
    }
  });
  return paths;
}

}  // namespace glowworm
