#include "photon/emission_guide.h"

#include <algorithm>
#include <cmath>

#include "core/archive.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

constexpr int kAxes = 5;
constexpr int kBins = 16;  // candidate planes along an axis
/// Least number of paths with a score in a cell that is split.
constexpr std::size_t kMinHits = 16;
/// A split must gain this many times the best gain expected from chance.
constexpr double kSignificance = 6;
/// Weight of the larger cell's mean against the cell's own, in paths.
constexpr double kPrior = 8;
constexpr int kDeepest = 48;

double volume(const EmissionNumbers& low, const EmissionNumbers& high) {
  double v = 1;
  for (int a = 0; a < kAxes; ++a) v *= static_cast<double>(high[a]) - low[a];
  return v;
}

struct Split {
  int axis = -1;
  float place = 0;
  double gain = 0;
};

}  // namespace

class EmissionGuide::Learner {
 public:
  Learner(std::span<const PilotPath> paths, double floor) : paths_(paths), floor_(floor) {
    for (std::uint32_t i = 0; i < paths.size(); ++i) order_.push_back(i);
  }

  void learn(std::vector<Node>& nodes) {
    nodes_.assign(1, {});
    means_.assign(1, 0);
    nodes_[0].high.fill(1);
    means_[0] = mass(0, order_.size());
    grow(0, 0, order_.size(), 0);
    share_out();
    nodes = nodes_;
  }

  /// Mean score by the density of the nodes over the mean score of the uniform density.
  double gain() const {
    double guided = 0, uniform = 0;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].child) continue;
      guided += nodes_[n].probability * means_[n];
      uniform += volume(nodes_[n].low, nodes_[n].high) * means_[n];
    }
    return uniform > 0 ? guided / uniform : 1;
  }

 private:
  double weight(std::uint32_t path) const { return static_cast<double>(paths_[path].score) / paths_[path].density; }

  /// Integral of the score over a cell, estimated from the paths order_[first..last).
  double mass(std::size_t first, std::size_t last) const {
    double sum = 0;
    for (std::size_t i = first; i < last; ++i) sum += weight(order_[i]);
    return sum / static_cast<double>(paths_.size());
  }

  Split best_split(const Node& node, std::size_t first, std::size_t last) const {
    double bins[kAxes][kBins] = {};
    double whole = 0;
    std::size_t hits = 0;
    for (std::size_t i = first; i < last; ++i) {
      const double w = weight(order_[i]);
      if (!(w > 0)) continue;
      ++hits;
      whole += w;
      for (int a = 0; a < kAxes; ++a) {
        const float at = (paths_[order_[i]].numbers[a] - node.low[a]) / (node.high[a] - node.low[a]);
        bins[a][std::clamp(static_cast<int>(at * kBins), 0, kBins - 1)] += w;
      }
    }
    Split best;
    if (hits < kMinHits) return best;
    const double fewest = kSignificance / static_cast<double>(hits);
    for (int a = 0; a < kAxes; ++a) {
      // Beyond this, 24-bit random numbers cannot distinguish parts of a cell.
      if (node.high[a] - node.low[a] < 0x1p-14f) continue;
      double left = 0;
      for (int b = 1; b < kBins; ++b) {
        left += bins[a][b - 1];
        const double share = static_cast<double>(b) / kBins, of = left / whole;
        // Squared mean scores, weighted by volume, relative to the cell as a whole.
        const double gain = of * of / share + (1 - of) * (1 - of) / (1 - share) - 1;
        if (gain > best.gain && gain > fewest)
          best = {a, node.low[a] + (node.high[a] - node.low[a]) * static_cast<float>(share), gain};
      }
    }
    return best;
  }

  void grow(std::uint32_t n, std::size_t first, std::size_t last, int depth) {
    if (depth >= kDeepest) return;
    check_cancelled();
    const Split split = best_split(nodes_[n], first, last);
    if (split.axis < 0) return;
    const auto axis = static_cast<std::size_t>(split.axis);
    const auto middle = static_cast<std::size_t>(
        std::partition(order_.begin() + static_cast<std::ptrdiff_t>(first),
                       order_.begin() + static_cast<std::ptrdiff_t>(last),
                       [&](std::uint32_t i) { return paths_[i].numbers[axis] < split.place; }) -
        order_.begin());
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[n].child = child;
    nodes_[n].axis = static_cast<std::uint8_t>(split.axis);
    nodes_[n].split = split.place;
    for (int side = 0; side < 2; ++side) {
      Node node;
      node.low = nodes_[n].low;
      node.high = nodes_[n].high;
      (side ? node.low : node.high)[axis] = split.place;
      const std::size_t from = side ? middle : first, to = side ? last : middle;
      const auto count = static_cast<double>(to - from);
      const double mean = mass(from, to) / volume(node.low, node.high);
      means_.push_back((count * mean + kPrior * means_[n]) / (count + kPrior));
      nodes_.push_back(node);
    }
    grow(child, first, middle, depth + 1);
    grow(child + 1, middle, last, depth + 1);
  }

  /// Probabilities of the cells, and of all nodes from the bottom up. Children follow their parents.
  void share_out() {
    double sum = 0;
    for (std::size_t n = 0; n < nodes_.size(); ++n)
      if (!nodes_[n].child) sum += volume(nodes_[n].low, nodes_[n].high) * std::sqrt(means_[n]);
    std::vector<double> probability(nodes_.size());
    for (std::size_t n = nodes_.size(); n-- > 0;) {
      Node& node = nodes_[n];
      const double v = volume(node.low, node.high);
      if (node.child) {
        probability[n] = probability[node.child] + probability[node.child + 1];
        node.left_share = static_cast<float>(probability[node.child] / probability[n]);
      } else {
        probability[n] = sum > 0 ? (1 - floor_) * v * std::sqrt(means_[n]) / sum + floor_ * v : v;
      }
      node.probability = static_cast<float>(probability[n]);
    }
  }

  std::span<const PilotPath> paths_;
  double floor_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
  std::vector<double> means_;  // mean score of each node's cell
};

EmissionGuide::EmissionGuide() : nodes_(1) {
  nodes_[0].high.fill(1);
  nodes_[0].probability = 1;
}

EmissionGuide EmissionGuide::learn(std::span<const PilotPath> paths, float floor) {
  EmissionGuide guide;
  if (paths.empty()) return guide;
  Learner learner(paths, floor);
  learner.learn(guide.nodes_);
  guide.gain_ = learner.gain();
  return guide;
}

template <typename Archive>
void EmissionGuide::Node::transfer(Archive& archive) {
  transfer_all(archive, child, axis, split, left_share, probability, low, high);
}

template <typename Archive>
void EmissionGuide::transfer(Archive& archive) {
  transfer_all(archive, gain_, nodes_);
  if constexpr (Archive::kReads) check();
}
template void EmissionGuide::transfer(ArchiveWriter& archive);
template void EmissionGuide::transfer(ArchiveReader& archive);

void EmissionGuide::check() const {
  require(std::isfinite(gain_) && gain_ >= 0 && !nodes_.empty());
  // Wherever the values come from, a density can be found, and every walk ends.
  const auto is_share = [](float x) { return x >= 0 && x <= 1; };
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Node& node = nodes_[n];
    for (int a = 0; a < kAxes; ++a)
      require(is_share(node.low[a]) && is_share(node.high[a]) && node.low[a] < node.high[a]);
    require(is_share(node.left_share) && node.probability > 0 && std::isfinite(node.probability));
    if (node.child == 0) continue;
    require(node.child > n && node.child < nodes_.size() - 1 && node.axis < kAxes);
    require(node.split > node.low[node.axis] && node.split < node.high[node.axis]);
  }
}

float EmissionGuide::warp(EmissionNumbers& numbers) const {
  const Node* node = nodes_.data();
  double density = 1;
  while (node->child) {
    float& u = numbers[node->axis];
    const float p = node->left_share;
    const Node* child = &nodes_[node->child];
    const double left_volume = (static_cast<double>(node->split) - node->low[node->axis]) /
                               (static_cast<double>(node->high[node->axis]) - node->low[node->axis]);
    if (u < p) {
      u = std::min(u / p, kBelowOne);
      density *= p / left_volume;
    } else {
      u = std::min((u - p) / (1 - p), kBelowOne);
      density *= (1 - static_cast<double>(p)) / (1 - left_volume);
      ++child;
    }
    node = child;
  }
  for (int a = 0; a < kAxes; ++a)
    numbers[a] = std::min(node->low[a] + numbers[a] * (node->high[a] - node->low[a]), kBelowOne);
  return static_cast<float>(1 / density);
}

float EmissionGuide::density(const EmissionNumbers& numbers) const {
  const Node* node = nodes_.data();
  double density = 1;
  while (node->child) {
    const std::size_t axis = node->axis;
    const double left_volume = (static_cast<double>(node->split) - node->low[axis]) /
                               (static_cast<double>(node->high[axis]) - node->low[axis]);
    const bool right = numbers[axis] >= node->split;
    density *= right ? (1 - static_cast<double>(node->left_share)) / (1 - left_volume) : node->left_share / left_volume;
    node = &nodes_[node->child + (right ? 1 : 0)];
  }
  return static_cast<float>(density);
}

}  // namespace glowworm
