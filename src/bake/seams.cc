#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/fill.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

constexpr float kSmoothCosine = 0.95f;  ///< between shading normals of two sides that show one surface
constexpr double kStiffness = 0.001;    ///< weight of keeping a texel against closing a place of a seam

Vec3 corner_normal(const Geometry& geometry, BakeFace face, std::size_t corner) {
  const Vec3 n = geometry.normals[geometry.triangles[face.triangle][corner]];
  const Vec3 own = face_normal(geometry, face);
  return length_squared(n) > 0 ? face_forward(normalize(n), own) : own;
}

/// The four texels around a point of an atlas, and their weights times `sign`.
void add_side(const Atlas& atlas, const ChartPlace& place, Vec2 p, float sign, std::uint32_t* texel, float* weight) {
  const float x = p.x - 0.5f, y = p.y - 0.5f;
  const auto limit = static_cast<float>(atlas.side - 2);
  const float left = std::clamp(std::floor(x), 0.0f, limit), top = std::clamp(std::floor(y), 0.0f, limit);
  const float u = x - left, v = y - top;
  const float weights[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  for (int i = 0; i < 4; ++i) {
    const int column = static_cast<int>(left) + i % 2, row = static_cast<int>(top) + i / 2 + place.atlas * atlas.side;
    texel[i] =
        static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(atlas.side) + static_cast<std::uint32_t>(column);
    weight[i] = sign * weights[i];
  }
}

float distance(Vec2 a, Vec2 b) { return std::hypot(b.x - a.x, b.y - a.y); }

/// Sorts places so that those that depend on each other, because they share texels or others link them, follow one
/// another. Returns where each such group begins, and the end of the last. @param texels of all atlases
std::vector<std::size_t> sort_into_groups(std::vector<Seams::Place>& places, std::size_t texels) {
  std::vector<std::uint32_t> parent(texels);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const Seams::Place& place : places)
    for (const std::uint32_t texel : place.texel) {
      const std::uint32_t a = root(place.texel[0]), b = root(texel);
      parent[std::max(a, b)] = std::min(a, b);
    }
  const auto group = [&](const Seams::Place& place) { return root(place.texel[0]); };
  std::stable_sort(places.begin(), places.end(), [&](const auto& a, const auto& b) { return group(a) < group(b); });
  std::vector<std::size_t> begin;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (i == 0 || group(places[i]) != group(places[i - 1])) begin.push_back(i);
  begin.push_back(places.size());
  return begin;
}

/// The normal equations of a set of seams: for each channel, the sum over places of (weights . texels)^2, and over
/// texels of kStiffness (texel - what it was)^2.
class SeamSystem {
 public:
  /// @param places of one group; their texels are numbered anew, as in texels()
  explicit SeamSystem(std::span<Seams::Place> places) : places_(places) {
    for (const Seams::Place& place : places)
      texels_.insert(texels_.end(), std::begin(place.texel), std::end(place.texel));
    std::sort(texels_.begin(), texels_.end());
    texels_.erase(std::unique(texels_.begin(), texels_.end()), texels_.end());
    for (Seams::Place& place : places)
      for (std::uint32_t& t : place.texel)
        t = static_cast<std::uint32_t>(std::lower_bound(texels_.begin(), texels_.end(), t) - texels_.begin());
  }

  /// Texels that the seams touch.
  const std::vector<std::uint32_t>& texels() const { return texels_; }

  /// The values with the least sum, none below 0.
  std::vector<double> solve(std::vector<double> start) const {
    constexpr int kMaxRounds = 4;
    std::vector<std::uint8_t> at_zero(start.size(), 0);
    for (int round = 0;; ++round) {
      std::vector<double> x = minimum(start, at_zero);
      bool all_good = true;
      for (std::size_t i = 0; i < x.size(); ++i) {
        if (x[i] >= 0) continue;
        // Light is not negative. Where this texel stays at 0, others must do more.
        x[i] = start[i] = 0;
        at_zero[i] = 1;
        all_good = false;
      }
      if (all_good || round == kMaxRounds) return x;
    }
  }

 private:
  /// The values with the least sum by conjugate gradients. @param at_zero texels that stay as they are in `start`
  std::vector<double> minimum(const std::vector<double>& start, const std::vector<std::uint8_t>& at_zero) const {
    constexpr int kMaxSteps = 400;
    std::vector<double> x = start, r(x.size());
    // With x = start, the steps alone have a gradient.
    const std::vector<double> product = times(x, 0);
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = at_zero[i] ? 0 : -product[i];
    std::vector<double> p = r;
    double square = dot_of(r, r);
    const double enough = 1e-14 * square;
    for (int step = 0; step < kMaxSteps && square > enough; ++step) {
      const std::vector<double> ap = times(p, kStiffness);
      const double length = square / dot_of(p, ap);
      for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] += length * p[i];
        if (!at_zero[i]) r[i] -= length * ap[i];
      }
      const double next = dot_of(r, r);
      for (std::size_t i = 0; i < p.size(); ++i) p[i] = r[i] + next / square * p[i];
      square = next;
    }
    return x;
  }

  std::vector<double> times(const std::vector<double>& x, double stiffness) const {
    std::vector<double> out(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) out[i] = stiffness * x[i];
    for (const Seams::Place& place : places_) {
      double step = 0;
      for (std::size_t i = 0; i < 8; ++i) step += static_cast<double>(place.weight[i]) * x[place.texel[i]];
      for (std::size_t i = 0; i < 8; ++i) out[place.texel[i]] += place.weight[i] * step;
    }
    return out;
  }

  static double dot_of(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }

  std::span<const Seams::Place> places_;
  std::vector<std::uint32_t> texels_;
};

/// Solves for one channel.
void close_channel(const SeamSystem& system, int channel, std::vector<RGB>& texels) {
  std::vector<double> start;
  for (const std::uint32_t texel : system.texels()) start.push_back(texels[texel][channel]);
  const std::vector<double> solved = system.solve(std::move(start));
  for (std::size_t i = 0; i < solved.size(); ++i) texels[system.texels()[i]][channel] = static_cast<float>(solved[i]);
}

}  // namespace

Seams find_seams(const Geometry& geometry, std::span<const BakeFace> faces, std::span<const Chart> charts,
                 const Atlas& atlas) {
  const std::vector<FacePlace> where = places_of_faces(charts, faces.size());
  Seams seams;
  for (const SharedEdge& edge : shared_edges(geometry, faces)) {
    const std::uint32_t f[2] = {edge.face[0], edge.face[1]};
    if (geometry.material[faces[f[0]].triangle] != geometry.material[faces[f[1]].triangle]) continue;
    Vec2 begin[2], end[2];
    Vec3 normal[2][2];
    const ChartPlace* place[2];
    for (std::size_t side = 0; side < 2; ++side) {
      // The second face runs along the edge the other way.
      const std::size_t from = (edge.corner[side] + side) % 3, to = (edge.corner[side] + 1 - side) % 3;
      const FacePlace at = where[f[side]];
      place[side] = &atlas.places[at.chart];
      begin[side] = place[side]->texel(charts[at.chart].corners[at.index][from]);
      end[side] = place[side]->texel(charts[at.chart].corners[at.index][to]);
      normal[0][side] = corner_normal(geometry, faces[f[side]], from);
      normal[1][side] = corner_normal(geometry, faces[f[side]], to);
    }
    const bool same = place[0] == place[1] && distance(begin[0], begin[1]) + distance(end[0], end[1]) < 1e-3f;
    if (same || dot(normal[0][0], normal[0][1]) < kSmoothCosine || dot(normal[1][0], normal[1][1]) < kSmoothCosine)
      continue;
    const float texels = std::max(distance(begin[0], end[0]), distance(begin[1], end[1]));
    const int count = 2 + static_cast<int>(std::ceil(2 * texels));
    for (int i = 0; i < count; ++i) {
      const float t = static_cast<float>(i) / static_cast<float>(count - 1);
      Seams::Place shared;
      for (int side = 0; side < 2; ++side)
        add_side(atlas, *place[side], begin[side] + (end[side] - begin[side]) * t, side == 0 ? 1.0f : -1.0f,
                 shared.texel + 4 * side, shared.weight + 4 * side);
      seams.places.push_back(shared);
    }
  }
  return seams;
}

void close_seams(Seams seams, std::vector<RGB>& texels) {
  // Groups share no texel. Small systems stay in the cache and take few steps.
  const std::vector<std::size_t> begin = sort_into_groups(seams.places, texels.size());
  parallel_for(0, begin.size() - 1, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t g = first; g < last; ++g) {
      const SeamSystem system({seams.places.data() + begin[g], begin[g + 1] - begin[g]});
      parallel_for(0, 3, 1, [&](std::size_t from, std::size_t to) {
        for (int c = static_cast<int>(from); c < static_cast<int>(to); ++c) close_channel(system, c, texels);
      });
    }
  });
}

}  // namespace glowworm
