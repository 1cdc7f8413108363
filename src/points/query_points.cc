#include "points/query_points.h"

namespace glowworm {

void QueryPoints::clear() {
  position.clear();
  normal.clear();
  reflectance.clear();
  bsdf.clear();
  bsdfs.clear();
  weight.clear();
  gather_point.clear();
}

void QueryPoints::reserve(std::size_t n) {
  position.reserve(n);
  normal.reserve(n);
  reflectance.reserve(n);
  bsdf.reserve(n);
  weight.reserve(n);
  gather_point.reserve(n);
}

void QueryPoints::push_back(Vec3 p, Vec3 n, const QueryBsdf& b, RGB w, std::uint32_t target) {
  push_back(p, n, RGB(0.0f), w, target);
  bsdf.back() = static_cast<std::uint32_t>(bsdfs.size());
  bsdfs.push_back(b);
}

void QueryPoints::append(const QueryPoints& other) {
  const auto offset = static_cast<std::uint32_t>(bsdfs.size());
  position.insert(position.end(), other.position.begin(), other.position.end());
  normal.insert(normal.end(), other.normal.begin(), other.normal.end());
  reflectance.insert(reflectance.end(), other.reflectance.begin(), other.reflectance.end());
  weight.insert(weight.end(), other.weight.begin(), other.weight.end());
  gather_point.insert(gather_point.end(), other.gather_point.begin(), other.gather_point.end());
  bsdfs.insert(bsdfs.end(), other.bsdfs.begin(), other.bsdfs.end());
  bsdf.insert(bsdf.end(), other.bsdf.begin(), other.bsdf.end());
  if (!other.bsdfs.empty() && offset > 0)
    for (std::size_t i = size() - other.size(); i < size(); ++i)
      if (bsdf[i] != kLambertianQuery) bsdf[i] += offset;
}

}  // namespace glowworm
