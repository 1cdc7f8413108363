#include "points/query_points.h"

namespace glowworm {

void QueryPoints::clear() {
  for_arrays([](auto& array) { array.clear(); }, *this);
  bsdfs.clear();
}

void QueryPoints::reserve(std::size_t n) {
  for_arrays([n](auto& array) { array.reserve(n); }, *this);
}

void QueryPoints::push_back(Vec3 p, Vec3 n, const QueryBsdf& b, RGB w, std::uint32_t target) {
  push_back(p, n, RGB(0.0f), w, target);
  bsdf.back() = static_cast<std::uint32_t>(bsdfs.size());
  bsdfs.push_back(b);
}

void QueryPoints::append(const QueryPoints& other) {
  const auto offset = static_cast<std::uint32_t>(bsdfs.size());
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  for_arrays(append, *this, other);
  append(bsdfs, other.bsdfs);
  if (!other.bsdfs.empty() && offset > 0)
    for (std::size_t i = size() - other.size(); i < size(); ++i)
      if (bsdf[i] != kLambertianQuery) bsdf[i] += offset;
}

}  // namespace glowworm
