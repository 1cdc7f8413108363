#include "import/obj/smooth.h"

#include <bit>
#include <unordered_map>
#include <vector>

#include "import/mesh_tools.h"

namespace glowworm {

namespace {

constexpr float kCosLimit = 0.5f;  ///< cosine of 60 degrees

FloatBits<3> place_of(Vec3 p) { return std::bit_cast<FloatBits<3>>(p + Vec3{0, 0, 0}); }  // -0 becomes 0

/// Triangles at one position whose normals are within 60 degrees of the first one's. Only about a dozen directions can
/// be farther apart than that, so a position has few bundles.
struct Bundle {
  Vec3 first, sum;
};

}  // namespace

void smooth_normals(Geometry& mesh, std::span<const std::uint32_t> chosen) {
  std::unordered_map<FloatBits<3>, std::vector<Bundle>, FloatBitsHash> places;
  std::vector<std::uint32_t> bundle_of(3 * chosen.size(), kNone);
  for (std::size_t i = 0; i < 3 * chosen.size(); ++i) {
    const std::uint32_t triangle = chosen[i / 3];
    const Vec3 normal = mesh.normal(triangle);
    if (!(length_squared(normal) > 0)) continue;  // no area, or a vertex that is not finite
    std::vector<Bundle>& bundles = places[place_of(mesh.positions[mesh.triangles[triangle][i % 3]])];
    std::size_t at = 0;
    while (at < bundles.size() && dot(bundles[at].first, normal) < kCosLimit) ++at;
    if (at == bundles.size()) bundles.push_back({normal, {}});
    bundles[at].sum += normal;
    bundle_of[i] = static_cast<std::uint32_t>(at);
  }
  for (std::size_t i = 0; i < bundle_of.size(); ++i) {
    const std::uint32_t vertex = mesh.triangles[chosen[i / 3]][i % 3];
    if (bundle_of[i] == kNone || length_squared(mesh.normals[vertex]) > 0) continue;
    const Vec3 sum = places[place_of(mesh.positions[vertex])][bundle_of[i]].sum;
    mesh.normals[vertex] = sum / length(sum);
  }
}

}  // namespace glowworm
