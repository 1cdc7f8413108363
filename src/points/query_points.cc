#include "points/query_points.h"

namespace glowworm {

void QueryPoints::clear() {
  Batch::clear();
  bsdfs.clear();
}

void QueryPoints::push_back(Vec3 p, Vec3 n, const QueryBsdf& b, RGB w, std::uint32_t target) {
  push_back(p, n, RGB(0.0f), w, target);
  bsdf.back() = static_cast<std::uint32_t>(bsdfs.size());
  bsdfs.push_back(b);
}

void QueryPoints::append(const QueryPoints& other) {
  const auto offset = static_cast<std::uint32_t>(bsdfs.size());
  Batch::append(other);
  bsdfs.insert(bsdfs.end(), other.bsdfs.begin(), other.bsdfs.end());
  if (!other.bsdfs.empty() && offset > 0)
    for (std::size_t i = size() - other.size(); i < size(); ++i)
      if (bsdf[i] != kLambertianQuery) bsdf[i] += offset;
}

}  // namespace glowworm
