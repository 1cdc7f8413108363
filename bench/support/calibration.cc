#include "support/calibration.h"

#include <cmath>
#include <functional>

#include "density/radius.h"

namespace glowworm::bench {

namespace {

constexpr std::size_t kSampled = 60'000;
constexpr int kRounds = 6;

void append(QueryPoints& chosen, const QueryPoints& points, std::size_t i) {
  chosen.position.push_back(points.position[i]);
  chosen.normal.push_back(points.normal[i]);
  chosen.reflectance.push_back(points.reflectance[i]);
  chosen.weight.push_back(points.weight[i]);
  chosen.gather_point.push_back(points.gather_point[i]);
  chosen.bsdf.push_back(points.bsdf[i]);
}

QueryPoints select(const QueryPoints& points, const std::function<bool(std::size_t)>& wanted) {
  QueryPoints chosen;
  chosen.bsdfs = points.bsdfs;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (wanted(i)) append(chosen, points, i);
  return chosen;
}

/// The factor on all radii with which the mean comes to k. On a surface the mean grows with the square of it.
double factor_for(const Recording& recording, const RadiusPolicy& policy, double k) {
  const std::size_t step = std::max<std::size_t>(1, recording.points.size() / kSampled);
  const QueryPoints sample = select(recording.points, [step](std::size_t i) { return i % step == 0; });
  std::vector<RGB> radiance(sample.size());
  double factor = 1;
  for (int round = 0; round < kRounds; ++round) {
    RadiusPolicy scaled = policy;
    scaled.radius *= static_cast<float>(factor);
    for (float& radius : scaled.radii) radius *= static_cast<float>(factor);
    const auto engine = make_engine("blocked");
    Statistics statistics;
    engine->build(recording.photons, scaled, statistics);
    engine->estimate(sample, radiance, statistics);
    const double mean =
        static_cast<double>(statistics.count(Counter::shader_operations)) / static_cast<double>(sample.size());
    if (mean <= 0 || std::abs(mean / k - 1) < 0.01) break;
    factor *= std::sqrt(k / mean);
  }
  return factor;
}

}  // namespace

RadiusPolicy fixed_radius_for(const Recording& recording, double k) {
  RadiusPolicy policy;
  policy.kind = RadiusKind::fixed;
  policy.radius = fixed_radius(recording.photons, static_cast<std::uint32_t>(k));
  policy.radius *= static_cast<float>(factor_for(recording, policy, k));
  return policy;
}

RadiusPolicy own_radii_for(const Recording& recording, double k) {
  RadiusPolicy policy;
  policy.radii = per_photon_radii(recording.photons, static_cast<std::uint32_t>(k));
  const auto factor = static_cast<float>(factor_for(recording, policy, k));
  for (float& radius : policy.radii) radius *= factor;
  return policy;
}

QueryPoints runs_of(const QueryPoints& points, const std::vector<std::uint32_t>& order, std::size_t run,
                    std::size_t step) {
  std::vector<char> chosen(points.size());
  for (std::size_t place = 0; place < points.size(); ++place)
    chosen[order.empty() ? place : order[place]] = place / run % step == 0;
  return select(points, [&](std::size_t i) { return chosen[i] != 0; });
}

QueryPoints in_order(const QueryPoints& points, const std::vector<std::uint32_t>& order) {
  QueryPoints ordered;
  ordered.bsdfs = points.bsdfs;
  for (const std::uint32_t i : order) append(ordered, points, i);
  return ordered;
}

}  // namespace glowworm::bench
