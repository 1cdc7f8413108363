#include "density/radius.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "density/engine.h"
#include "density/kd_tree.h"

namespace glowworm {

namespace {

// Maximum number of surfaces in one leaf; a photon that matches none of them joins the last.
constexpr int kMaxSurfaces = 4;
// Leaves before and after a leaf, in the order of the tree, that are pooled with its estimate.
constexpr std::size_t kPooledLeaves = 3;
// Number of photons for an estimate of their area without pooling.
constexpr float kTrustedCount = 12;
// A radius is at most this multiple of the median radius, or of the radius of evenly spread photons: lone photons stay
// local. The second bound serves caustics, where nearly all photons lie in the focus and the median is tiny.
constexpr float kMaxOverMedian = 8, kMaxOverEven = 4;
// The second bound never exceeds this share of the diagonal of the photons' box: few photons do not blur over all of
// it.
constexpr float kMaxShareOfDiagonal = 1.0f / 16;
constexpr std::size_t kLeafGrain = 64;

/// Sums over photons: positions relative to a nearby origin, and their products.
struct Moments {
  double n = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void add(Vec3 p) {
    n += 1;
    x += p.x;
    y += p.y;
    z += p.z;
    xx += double(p.x) * p.x;
    xy += double(p.x) * p.y;
    xz += double(p.x) * p.z;
    yy += double(p.y) * p.y;
    yz += double(p.y) * p.z;
    zz += double(p.z) * p.z;
  }

  /// The area of a square with the photons' covariance C in the plane normal to m: 12 sqrt(det). It is close to the
  /// area of any compact shape that they cover evenly (4 pi / 12 for a disc). The determinant in the plane is m^T
  /// adj(C) m. The root of its estimate from n points is too small by a factor (n - 2) / (n - 1) on average (Wishart
  /// distribution), so surfaces with few photons of a leaf, as in corners, would get small radii.
  double area(Vec3 m) const {
    if (n < 3) return 0;
    const double inverse = 1 / n, unbiased = 1 / (n - 1);
    const double cxx = (xx - x * x * inverse) * unbiased, cyy = (yy - y * y * inverse) * unbiased,
                 czz = (zz - z * z * inverse) * unbiased, cxy = (xy - x * y * inverse) * unbiased,
                 cxz = (xz - x * z * inverse) * unbiased, cyz = (yz - y * z * inverse) * unbiased;
    const double det = m.x * m.x * (cyy * czz - cyz * cyz) + m.y * m.y * (cxx * czz - cxz * cxz) +
                       m.z * m.z * (cxx * cyy - cxy * cxy) + 2 * m.x * m.y * (cxz * cyz - cxy * czz) +
                       2 * m.x * m.z * (cxy * cyz - cxz * cyy) + 2 * m.y * m.z * (cxy * cxz - cyz * cxx);
    return 12 * std::sqrt(std::max(0.0, det)) * (n - 1) / (n - 2);
  }
};

/// The photons of one leaf on one surface.
struct Surface {
  Vec3 first_normal;  ///< of the first photon
  Vec3 normal;        ///< averaged, unit
  Vec3 center;        ///< metres
  float count = 0;
  float area = 0;       ///< covered by the photons, m^2; 0 if they are too few or on a line
  float cell_area = 0;  ///< of the largest side of the box around the leaf's photons, m^2
};

struct Leaf {
  std::uint32_t first = 0, count = 0;  ///< photons, in tree order
  int surface_count = 0;
  std::array<Surface, kMaxSurfaces> surfaces;
};

/// The surface of the leaf with that normal; adds a new one if none matches.
int surface_of(Leaf& leaf, Vec3 normal) {
  for (int s = 0; s < leaf.surface_count; ++s) {
    if (dot(leaf.surfaces[s].first_normal, normal) > kMinNormalCosine) return s;
  }
  if (leaf.surface_count == kMaxSurfaces) return kMaxSurfaces - 1;
  leaf.surfaces[leaf.surface_count].first_normal = normal;
  return leaf.surface_count++;
}

/// Prefetches the normals of a leaf's photons, which are scattered in memory.
void prefetch_normals(const KdNode& leaf, const KdTree& tree, std::span<const Vec3> normals) {
  for (std::uint32_t i = leaf.first(); i < leaf.first() + leaf.count; ++i) {
    __builtin_prefetch(&normals[tree.points[i].index]);
  }
}

/// Sorts the photons of a leaf by surface and measures the areas that they cover.
void measure(Leaf& leaf, const KdTree& tree, std::span<const Vec3> normals, std::uint8_t* surface_index) {
  std::array<Moments, kMaxSurfaces> moments;
  const Vec3 origin = tree.points[leaf.first].position;
  Box3 box;
  for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
    const KdPoint& p = tree.points[i];
    const Vec3 normal = normals[p.index];
    const int s = surface_of(leaf, normal);
    surface_index[i] = static_cast<std::uint8_t>(s);
    moments[s].add(p.position - origin);
    leaf.surfaces[s].normal += normal;
    box.grow(p.position);
  }
  const Vec3 d = box.diagonal();
  const float cell_area = std::max(d.x * d.y, std::max(d.y * d.z, d.z * d.x));
  for (int s = 0; s < leaf.surface_count; ++s) {
    Surface& surface = leaf.surfaces[s];
    const Moments& m = moments[s];
    const float norm = length(surface.normal);
    surface.normal = norm > 0 ? surface.normal / norm : surface.first_normal;
    surface.center = origin + Vec3{float(m.x / m.n), float(m.y / m.n), float(m.z / m.n)};
    surface.count = static_cast<float>(m.n);
    surface.area = static_cast<float>(m.area(surface.normal));
    surface.cell_area = cell_area;
  }
}

/// The radius that holds k photons on a surface: pi r^2 = k times the area of a photon, pooled over the surface and its
/// continuation in adjacent leaves. Zero or negative if there are too few photons.
float pooled_radius(std::span<const Leaf> leaves, std::size_t i, const Surface& surface, float k) {
  const std::size_t first = i < kPooledLeaves ? 0 : i - kPooledLeaves;
  const std::size_t last = std::min(i + kPooledLeaves + 1, leaves.size());
  float area = 0, count = 0;
  for (std::size_t j = first; j < last; ++j) {
    for (int s = 0; s < leaves[j].surface_count; ++s) {
      const Surface& other = leaves[j].surfaces[s];
      if (other.area <= 0 || !(dot(other.normal, surface.normal) > kMinNormalCosine)) continue;
      // Adjacent leaves in the tree may be far apart in space.
      const float reach = 2 * std::max(surface.area, other.area);
      if (length_squared(other.center - surface.center) > reach) continue;
      area += other.area;
      count += other.count;
    }
  }
  float area_each = count > 0 ? area / count : surface.cell_area / surface.count;
  if (count >= kTrustedCount) return std::sqrt(k * kInversePi * area_each);
  // A few photons that are close together by chance, or on a line, would get a radius near zero and make bright specks.
  // They share the area of the leaf with all its photons.
  area_each = std::max(area_each, surface.cell_area / static_cast<float>(leaves[i].count));
  return -std::sqrt(k * kInversePi * area_each);
}

/// The median of the known radii, from at most a few thousand of them; 0 if there is none.
float median_radius(const std::vector<float>& radii) {
  std::vector<float> some;
  const std::size_t step = radii.size() / 4096 + 1;
  for (std::size_t i = 0; i < radii.size(); i += step) {
    if (radii[i] > 0) some.push_back(radii[i]);
  }
  if (some.empty()) return 0;
  std::nth_element(some.begin(), some.begin() + some.size() / 2, some.end());
  return some[some.size() / 2];
}

/// The radius that would hold k of n photons if they were evenly spread over the largest side of their box.
float even_radius(std::size_t n, const Box3& bounds, float k) {
  const Vec3 d = bounds.diagonal();
  const float side = std::max(d.x * d.y, std::max(d.y * d.z, d.z * d.x));
  return std::sqrt(k * kInversePi * side / static_cast<float>(n));
}

/// Makes all radii positive and finite, and bounds them from both sides.
void bound_radii(std::vector<float>& radii, const Box3& bounds, float k) {
  const float diagonal = length(bounds.diagonal());
  float median = median_radius(radii);
  // All photons coincide or lie on lines: their density is unknown, and the size of their box is the best estimate.
  if (!(median > 0)) median = diagonal > 0 ? diagonal / 100 : 1e-3f;
  const float low = std::max(median * 1e-3f, std::numeric_limits<float>::min());
  const float even = std::min(kMaxOverEven * even_radius(radii.size(), bounds, k), kMaxShareOfDiagonal * diagonal);
  const float high = std::max(median * kMaxOverMedian, even);
  const float low_untrusted = median / 4;
  for (float& radius : radii) {
    radius = radius > 0 ? std::clamp(radius, low, high) : std::clamp(-radius, low_untrusted, high);
  }
}

}  // namespace

PhotonRadii measured_radii(const PhotonBatch& photons, std::uint32_t k) {
  PhotonRadii found;
  if (photons.size() == 0) return found;
  const KdTree tree = build_kd_tree(photons.position, std::max(16u, k / 2));
  LargeVector<KdNode> places;
  places.reserve(tree.nodes.size() / 2 + 1);
  for (const KdNode& node : tree.nodes)
    if (node.is_leaf()) places.push_back(node);
  LargeArray<Leaf> leaves(places.size());
  LargeArray<std::uint8_t> surface_index(photons.size());
  parallel_for(0, leaves.size(), kLeafGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (i + 1 < last) prefetch_normals(places[i + 1], tree, photons.normal);
      leaves[i] = Leaf{places[i].first(), places[i].count, 0, {}};
      measure(leaves[i], tree, photons.normal, surface_index.data());
    }
  });
  found.radii.resize(photons.size());
  found.order.resize(photons.size());
  parallel_for(0, leaves.size(), kLeafGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      std::array<float, kMaxSurfaces> radius;
      for (int s = 0; s < leaves[i].surface_count; ++s) {
        radius[s] = pooled_radius(leaves.span(), i, leaves[i].surfaces[s], static_cast<float>(std::max(k, 1u)));
      }
      const std::uint32_t end = leaves[i].first + leaves[i].count;
      for (std::uint32_t p = leaves[i].first; p < end; ++p) {
        found.order[p] = tree.points[p].index;
        found.radii[found.order[p]] = radius[surface_index[p]];
      }
    }
  });
  bound_radii(found.radii, tree.bounds, static_cast<float>(std::max(k, 1u)));
  return found;
}

std::vector<float> per_photon_radii(const PhotonBatch& photons, std::uint32_t k) {
  return measured_radii(photons, k).radii;
}

float fixed_radius(const PhotonBatch& photons, std::uint32_t k) {
  if (photons.size() == 0) return 1e-3f;
  double squares = 0;
  for (const float radius : per_photon_radii(photons, k)) squares += double{radius} * radius;
  return static_cast<float>(std::sqrt(squares / static_cast<double>(photons.size())));
}

}  // namespace glowworm
