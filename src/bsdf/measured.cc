#include "bsdf/measured.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "bsdf/component.h"
#include "core/content_hash.h"

namespace glowworm {

PatchBasis::PatchBasis(const std::vector<Ring>& rings) {
  double least = 0;
  for (const Ring& ring : rings) {
    const double sine = std::sin(ring.upper * M_PI / 180), most = ring.upper >= 90 ? 1 : sine * sine;
    const auto count = static_cast<std::size_t>(ring.patches);
    rings_.push_back({static_cast<float>(least), static_cast<float>(most),
                      static_cast<float>(M_PI * (most - least) / ring.patches), ring_of_.size(), count});
    ring_of_.insert(ring_of_.end(), count, static_cast<std::uint8_t>(rings_.size() - 1));
    least = most;
  }
}

std::size_t PatchBasis::patch_of(Vec3 d) const {
  const float sine2 = d.x * d.x + d.y * d.y;
  std::size_t i = 0;
  while (i + 1 < rings_.size() && sine2 >= rings_[i].most_sine2) ++i;
  const Bounds& ring = rings_[i];
  if (ring.count == 1) return ring.first;
  const auto count = static_cast<float>(ring.count);
  const float turn = std::atan2(d.y, d.x) * (count / (2 * kPi));  // from -count / 2
  const auto patch = static_cast<std::size_t>(std::floor(turn + count + 0.5f));
  return ring.first + patch % ring.count;
}

std::size_t PatchBasis::opposite(std::size_t patch) const {
  const Bounds& ring = rings_[ring_of_[patch]];
  return ring.first + (patch - ring.first + ring.count / 2) % ring.count;
}

Vec3 PatchBasis::sample(std::size_t patch, Vec2 u) const {
  const Bounds& ring = rings_[ring_of_[patch]];
  const float sine2 = ring.least_sine2 + (ring.most_sine2 - ring.least_sine2) * u.x;
  const float sine = std::sqrt(sine2), z = std::sqrt(std::max(1 - sine2, 0.0f));
  const float phi = 2 * kPi * (static_cast<float>(patch - ring.first) + u.y - 0.5f) / static_cast<float>(ring.count);
  return {sine * std::cos(phi), sine * std::sin(phi), z};
}

MeasuredBsdf::MeasuredBsdf(PatchBasis basis, Values values) : basis_(std::move(basis)) {
  make_reciprocal(values);
  const std::size_t n = basis_.size();
  sides_[0][0].values = std::move(values.front);
  sides_[1][0].values = std::move(values.back);
  sides_[0][1].values = std::move(values.onwards);
  Side& behind = sides_[1][1];
  behind.values.resize(n * n);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) behind.values[b * n + a] = sides_[0][1].values[a * n + b];
  conserve_energy();
  for (auto& side : sides_)
    for (Side& part : side) add_up(part);
}

void MeasuredBsdf::make_reciprocal(Values& v) {
  const std::size_t n = basis_.size();
  for (std::vector<float>* matrix : {&v.front, &v.back}) matrix->resize(n * n);
  if (v.onwards.empty()) std::swap(v.onwards, v.backwards);
  v.onwards.resize(n * n);
  double all = 0, apart = 0;
  const auto merge = [&](float& x, float& y, std::size_t a, std::size_t b) {
    const double weight = double{basis_.projected(a)} * basis_.projected(b);
    all += weight * (x + y) / 2;
    apart += weight * std::abs(x - y) / 2;
    x = y = (x + y) / 2;
  };
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) {
      if (b < a)
        for (std::vector<float>* matrix : {&v.front, &v.back}) merge((*matrix)[a * n + b], (*matrix)[b * n + a], a, b);
      if (!v.backwards.empty()) merge(v.onwards[a * n + b], v.backwards[a * n + b], a, b);
    }
  if (all > 0) corrections_.asymmetry = apart / all;
}

void MeasuredBsdf::conserve_energy() {
  const std::size_t n = basis_.size();
  double most = 1;
  for (const auto& side : sides_)
    for (std::size_t a = 0; a < n; ++a) {
      double sum = 0;
      for (const Side& part : side)
        for (std::size_t b = 0; b < n; ++b) sum += double{part.values[a * n + b]} * basis_.projected(b);
      most = std::max(most, sum);
    }
  corrections_.scale = 1 / most;
  for (auto& side : sides_)
    for (Side& part : side)
      for (float& value : part.values) value = static_cast<float>(value / most);
}

void MeasuredBsdf::add_up(Side& side) {
  const std::size_t n = basis_.size();
  side.sums.resize(n * n);
  side.albedo.resize(n);
  for (std::size_t a = 0; a < n; ++a) {
    double sum = 0;
    for (std::size_t b = 0; b < n; ++b) {
      sum += double{side.values[a * n + b]} * basis_.projected(b);
      side.sums[a * n + b] = static_cast<float>(sum);
    }
    side.albedo[a] = side.sums[a * n + n - 1];
  }
}

bool MeasuredBsdf::is_black(bool passes) const {
  const auto is_zero = [](float x) { return x == 0; };
  return std::all_of(sides_[0][passes].albedo.begin(), sides_[0][passes].albedo.end(), is_zero) &&
         std::all_of(sides_[1][passes].albedo.begin(), sides_[1][passes].albedo.end(), is_zero);
}

Vec3 MeasuredBsdf::sample(bool back, bool passes, Vec3 wo, Vec2 u) const {
  const std::size_t n = basis_.size();
  const std::span<const float> sums = std::span(sides_[back][passes].sums).subspan(basis_.patch_of(wo) * n, n);
  const float wanted = u.x * sums.back();
  const auto chosen = static_cast<std::size_t>(
      std::min(std::upper_bound(sums.begin(), sums.end(), wanted) - sums.begin(), static_cast<std::ptrdiff_t>(n) - 1));
  const float before = chosen > 0 ? sums[chosen - 1] : 0, width = sums[chosen] - before;
  const float rest = width > 0 ? std::clamp((wanted - before) / width, 0.0f, 1 - 0x1p-24f) : 0;
  return basis_.sample(chosen, {rest, u.y});
}

std::uint64_t MeasuredBsdf::hash() const {
  ContentHash hash;
  hash.add(basis_.size());
  for (std::size_t i = 0; i < basis_.size(); ++i) hash.add(basis_.projected(i));
  for (const auto& side : sides_)
    for (const Side& part : side) hash.add_array(std::span<const float>(part.values));
  return hash.value();
}

namespace bsdf_detail {

void evaluate_measured(const View& view, std::span<const Vec3> wi, std::span<RGB> out) {
  const MeasuredBsdf& m = *view.bsdf.measured;
  for_each_direction(view, wi, out, [&](Vec3 w) {
    const bool passes = w.z < 0;
    if (!(view.lobes & (passes ? kDiffuseTransmission : kGlossy))) return RGB(0.0f);
    return RGB(m.evaluate(view.inside, passes, view.wo, w));
  });
}

void measured_components(const View& view, Components& out) {
  for (const bool passes : {false, true}) {
    Component c;
    c.shape = passes ? Shape::measured_transmission : Shape::measured_reflection;
    c.lobe = passes ? kDiffuseTransmission : kGlossy;
    c.measured = view.bsdf.measured;
    c.inside = view.inside;
    c.albedo = RGB(c.measured->albedo(view.inside, passes, view.wo));
    out.add(c);
  }
}

}  // namespace bsdf_detail

}  // namespace glowworm
