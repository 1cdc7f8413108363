#include "import/window/tensor_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/lines.h"
#include "core/parallel.h"
#include "core/warp.h"

namespace glowworm {

namespace {

void skip_between(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n,"), text.size()));
}

bool take_brace(std::string_view& text, char brace) {
  skip_between(text);
  if (!text.starts_with(brace)) return false;
  text.remove_prefix(1);
  return true;
}

/// Directions in a patch, evenly by the cosine: a square number of them.
std::vector<Vec3> directions_in(const PatchBasis& basis, std::size_t patch, int across) {
  std::vector<Vec3> out;
  for (int i = 0; i < across * across; ++i)
    out.push_back(basis.sample(patch, {(static_cast<float>(i % across) + 0.5f) / static_cast<float>(across),
                                       (static_cast<float>(i / across) + 0.5f) / static_cast<float>(across)}));
  return out;
}

Vec2 square_of(Vec3 d) { return disk_to_square({d.x, d.y}); }

}  // namespace

TensorTree::TensorTree(std::string_view text, int rank, double most) : rank_(rank) {
  read(text, most, 0);
  skip_between(text);
  if (!text.empty()) throw Error("the tree ends before its text");
}

std::uint32_t TensorTree::read(std::string_view& text, double most, int level) {
  constexpr int kMostLevels = 16;
  if (level > kMostLevels) throw Error("the tree has too many levels");
  if (!take_brace(text, '{')) throw Error("the tree lacks a '{'");
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  skip_between(text);
  Node node;
  if (text.starts_with('{')) {
    const std::size_t branches = std::size_t{1} << rank_;
    node.first = static_cast<std::uint32_t>(children_.size());
    children_.resize(children_.size() + branches);
    for (std::size_t i = 0; i < branches; ++i) {
      const std::uint32_t child = read(text, most, level + 1);
      children_[node.first + i] = child;
    }
  } else {
    read_grid(text, most, node);
  }
  if (!take_brace(text, '}')) throw Error("the tree lacks a '}'");
  nodes_[index] = node;
  return index;
}

void TensorTree::read_grid(std::string_view& text, double most, Node& node) {
  node.first = static_cast<std::uint32_t>(values_.size());
  for (skip_between(text); !text.empty() && !text.starts_with('}'); skip_between(text)) {
    const std::string_view word = text.substr(0, text.find_first_of(" \t\r\n,}"));
    double value = 0;
    if (!take_number(text, value) || !(std::abs(value) <= most))
      throw Error(fmt::format("the tree holds '{}', which is no number", word.substr(0, 40)));
    values_.push_back(std::max(static_cast<float>(value), 0.0f));
  }
  const std::size_t count = values_.size() - node.first;
  node.log2 = 0;
  while ((std::size_t{1} << (node.log2 * rank_)) < count) ++node.log2;
  if ((std::size_t{1} << (node.log2 * rank_)) != count)
    throw Error(fmt::format("a grid of the tree has {} values, which is no power of {}", count, 1 << rank_));
}

float TensorTree::value(Position p) const {
  const Node* node = &nodes_.front();
  while (node->log2 < 0) {
    std::uint32_t child = 0;
    for (int k = 0; k < rank_; ++k) {
      double& at = p[static_cast<std::size_t>(k)];
      at *= 2;
      if (at >= 1) {
        at -= 1;
        child |= 1u << k;
      }
    }
    node = &nodes_[children_[node->first + child]];
  }
  const std::size_t side = std::size_t{1} << node->log2;
  std::size_t index = 0;
  for (int k = 0; k < rank_; ++k) {
    const double at = std::clamp(p[static_cast<std::size_t>(k)], 0.0, 1.0);
    index = index * side + std::min(static_cast<std::size_t>(at * static_cast<double>(side)), side - 1);
  }
  return values_[node->first + index];
}

std::vector<float> matrix_of_tree(const TensorTree& tree, const PatchBasis& basis) {
  constexpr int kWays = 4, kOutgoing = 6;
  const std::size_t n = basis.size();
  std::vector<std::vector<Vec3>> outgoing;
  for (std::size_t o = 0; o < n; ++o) outgoing.push_back(directions_in(basis, o, kOutgoing));
  std::vector<float> out(n * n);
  parallel_for_each(n, 1, [&](std::size_t i) {
    for (const Vec3 way : directions_in(basis, i, kWays)) {
      const float sine = std::hypot(way.x, way.y);
      const float turn_x = sine > 0 ? way.x / sine : 1, turn_y = sine > 0 ? way.y / sine : 0;
      const Vec2 in = square_of(way);
      for (std::size_t o = 0; o < n; ++o) {
        double sum = 0;
        for (const Vec3 d : outgoing[o]) {
          if (tree.rank() == 4) {
            const Vec2 at = square_of(d);
            sum += tree.value({in.x, in.y, at.x, at.y});
          } else {
            const Vec2 at = square_of({d.x * turn_x + d.y * turn_y, d.y * turn_x - d.x * turn_y, d.z});
            sum += tree.value({0.5 * (1 - double{sine}), at.x, at.y, 0});
          }
        }
        out[o * n + i] += static_cast<float>(sum / (kWays * kWays * kOutgoing * kOutgoing));
      }
    }
  });
  return out;
}

}  // namespace glowworm
