#include "core/distribution.h"

namespace glowworm {

Distribution1D::Distribution1D(std::span<const float> weights)
    : cdf_(weights.size() + 1, 0.0),
      steps_(static_cast<double>(weights.size())),
      last_step_(static_cast<std::uint32_t>(weights.size()) - 1) {
  for (std::size_t i = 0; i < weights.size(); ++i) cdf_[i + 1] = cdf_[i] + weights[i];
  total_ = cdf_.back();
  for (std::size_t i = 0; i < cdf_.size(); ++i)
    cdf_[i] = total_ > 0 ? cdf_[i] / total_ : static_cast<double>(i) / static_cast<double>(weights.size());
  first_of_step_.reserve(weights.size() + 1);
  std::uint32_t index = 0;
  for (std::size_t step = 0; step < weights.size(); ++step) {
    const double u = static_cast<double>(step) / static_cast<double>(weights.size());
    while (index + 1 < weights.size() && cdf_[index + 1] <= u) ++index;
    first_of_step_.push_back(index);
  }
  first_of_step_.push_back(static_cast<std::uint32_t>(weights.size()) - 1);
}

Distribution2D::Distribution2D(std::span<const float> weights, int width, int height) : width_(width), height_(height) {
  std::vector<float> sums(height);
  for (int y = 0; y < height; ++y) {
    rows_.emplace_back(weights.subspan(static_cast<std::size_t>(y) * width, width));
    sums[y] = static_cast<float>(rows_.back().total());
  }
  marginal_ = Distribution1D(sums);
}

Distribution2D::Sample Distribution2D::sample(Vec2 u) const {
  const auto row = marginal_.sample(u.y);
  const auto column = rows_[row.index].sample(u.x);
  return {{(column.index + column.remapped) / width_, (row.index + row.remapped) / height_},
          row.probability * column.probability * static_cast<float>(width_) * static_cast<float>(height_),
          column.index,
          row.index};
}

float Distribution2D::pdf(Vec2 point) const {
  const int x = std::clamp(static_cast<int>(point.x * width_), 0, width_ - 1);
  const int y = std::clamp(static_cast<int>(point.y * height_), 0, height_ - 1);
  return marginal_.probability(y) * rows_[y].probability(x) * static_cast<float>(width_) * static_cast<float>(height_);
}

}  // namespace glowworm
