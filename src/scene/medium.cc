#include "scene/medium.h"

#include <fmt/format.h>

#include "core/error.h"

namespace glowworm {

namespace {

/// Most blocks along an axis: a walk through all of them costs about as much as a few lookups of textures.
constexpr int kMaxBlocks = 64;

void check_values(std::size_t wanted, const char* what, const std::vector<float>& values) {
  if (values.empty()) return;
  if (values.size() != wanted)
    throw Error(fmt::format("a grid of {} cells has {} values of {}", wanted, values.size(), what),
                "Give one value for each cell.");
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(values[i] >= 0) || !std::isfinite(values[i]))
      throw Error(fmt::format("value {} of a grid's {} is {:g}", i + 1, what, values[i]),
                  "Give finite numbers of 0 or more.");
}

void check_values(std::size_t wanted, const char* what, const std::vector<RGB>& values) {
  if (values.empty()) return;
  if (values.size() != wanted)
    throw Error(fmt::format("a grid of {} cells has {} values of {}", wanted, values.size(), what),
                "Give one value for each cell.");
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!is_finite(values[i]) || !(std::min({values[i].r, values[i].g, values[i].b}) >= 0))
      throw Error(fmt::format("value {} of a grid's {} is ({:g}, {:g}, {:g})", i + 1, what, values[i].r, values[i].g,
                              values[i].b),
                  "Give finite numbers of 0 or more.");
}

float greater(float a, float b) { return std::max(a, b); }
RGB greater(RGB a, RGB b) { return {std::max(a.r, b.r), std::max(a.g, b.g), std::max(a.b, b.b)}; }

/// The eight cells around a place and their weights.
struct Neighbours {
  std::array<std::size_t, 8> cell{};
  std::array<float, 8> weight{};

  Neighbours(const std::array<int, 3>& size, Vec3 at) {
    std::array<std::array<int, 2>, 3> index{};
    std::array<std::array<float, 2>, 3> share{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const float x = std::clamp(at[axis], 0.0f, 1.0f) * static_cast<float>(size[a]) - 0.5f;
      const float lower = std::floor(x);
      const int first = static_cast<int>(lower);
      share[a] = {first >= 0 ? 1 - (x - lower) : 0, first + 1 < size[a] ? x - lower : 0};
      index[a] = {std::max(first, 0), std::min(first + 1, size[a] - 1)};
    }
    for (std::size_t i = 0; i < 8; ++i) {
      const std::size_t x = i & 1, y = (i >> 1) & 1, z = i >> 2;
      const auto row = static_cast<std::size_t>(index[2][z]) * static_cast<std::size_t>(size[1]) +
                       static_cast<std::size_t>(index[1][y]);
      cell[i] = row * static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(index[0][x]);
      weight[i] = share[0][x] * share[1][y] * share[2][z];
    }
  }
  template <typename Value>
  Value of(const std::vector<Value>& values) const {
    Value sum{};
    for (std::size_t i = 0; i < 8; ++i) sum = sum + values[cell[i]] * weight[i];
    return sum;
  }
};

/// The largest value of each block and of its neighbouring cells, between which at() interpolates.
template <typename Value>
std::vector<Value> maxima(const MediumGridValues& grid, const std::vector<Value>& values,
                          const std::array<int, 3>& blocks, int cells) {
  std::vector<Value> most;
  if (values.empty()) return most;
  most.resize(static_cast<std::size_t>(blocks[0] * blocks[1] * blocks[2]));
  const auto blocks_of = [&](int axis, int cell) {
    const auto a = static_cast<std::size_t>(axis);
    return std::array<int, 2>{std::max(cell - 1, 0) / cells, std::min(cell + 1, grid.size[a] - 1) / cells};
  };
  std::size_t i = 0;
  for (int z = 0; z < grid.size[2]; ++z)
    for (int y = 0; y < grid.size[1]; ++y)
      for (int x = 0; x < grid.size[0]; ++x, ++i) {
        const auto bx = blocks_of(0, x), by = blocks_of(1, y), bz = blocks_of(2, z);
        for (int c = bz[0]; c <= bz[1]; ++c)
          for (int b = by[0]; b <= by[1]; ++b)
            for (int a = bx[0]; a <= bx[1]; ++a) {
              Value& block = most[static_cast<std::size_t>((c * blocks[1] + b) * blocks[0] + a)];
              block = greater(block, values[i]);
            }
      }
  return most;
}

template <typename Value>
Value greatest_of(const std::vector<Value>& values) {
  Value out = values.front();
  for (const Value& value : values) out = greater(out, value);
  return out;
}

float extinction(const Medium& medium, const MediumGrid::Point& factors) {
  return max_component(medium.sigma_a * factors.sigma_a + medium.sigma_s * factors.sigma_s);
}

/// A place of the medium's own coordinates, across its bounds.
Vec3 across(const Box3& bounds, Vec3 own) {
  const Vec3 from = own - bounds.min, size = bounds.diagonal();
  return {from.x / size.x, from.y / size.y, from.z / size.z};
}

}  // namespace

MediumGrid::MediumGrid(MediumGridValues values) : values_(std::move(values)) {
  for (const int cells : values_.size)
    if (cells < 1)
      throw Error(fmt::format("a grid has {} x {} x {} cells", values_.size[0], values_.size[1], values_.size[2]),
                  "Give one or more along each axis.");
  const std::size_t wanted = values_.cell_count();
  check_values(wanted, "density", values_.density);
  check_values(wanted, "sigma_a", values_.sigma_a);
  check_values(wanted, "sigma_s", values_.sigma_s);
  check_values(wanted, "emission", values_.emission);
  const int longest = *std::max_element(values_.size.begin(), values_.size.end());
  cells_per_block_ = std::max(2, (longest + kMaxBlocks - 1) / kMaxBlocks);
  for (std::size_t axis = 0; axis < 3; ++axis)
    blocks_[axis] = (values_.size[axis] + cells_per_block_ - 1) / cells_per_block_;
  most_density_ = maxima(values_, values_.density, blocks_, cells_per_block_);
  most_sigma_a_ = maxima(values_, values_.sigma_a, blocks_, cells_per_block_);
  most_sigma_s_ = maxima(values_, values_.sigma_s, blocks_, cells_per_block_);
  const float density = most_density_.empty() ? 1 : greatest_of(most_density_);
  greatest_.sigma_a = (most_sigma_a_.empty() ? RGB(1.0f) : greatest_of(most_sigma_a_)) * density;
  greatest_.sigma_s = (most_sigma_s_.empty() ? RGB(1.0f) : greatest_of(most_sigma_s_)) * density;
  if (!values_.emission.empty()) greatest_.emission = greatest_of(values_.emission);
}

MediumGrid::Point MediumGrid::at(Vec3 at) const {
  const Neighbours near(values_.size, at);
  const float density = values_.density.empty() ? 1 : near.of(values_.density);
  Point out{RGB(density), RGB(density)};
  if (!values_.sigma_a.empty()) out.sigma_a *= near.of(values_.sigma_a);
  if (!values_.sigma_s.empty()) out.sigma_s *= near.of(values_.sigma_s);
  if (!values_.emission.empty()) out.emission = near.of(values_.emission);
  return out;
}

MediumGrid::Point MediumGrid::bound(const std::array<int, 3>& block) const {
  const auto i = static_cast<std::size_t>((block[2] * blocks_[1] + block[1]) * blocks_[0] + block[0]);
  const float density = most_density_.empty() ? 1 : most_density_[i];
  Point out{RGB(density), RGB(density)};
  if (!most_sigma_a_.empty()) out.sigma_a *= most_sigma_a_[i];
  if (!most_sigma_s_.empty()) out.sigma_s *= most_sigma_s_[i];
  return out;
}

MediumPoint medium_point(const Medium& medium, Vec3 position) {
  MediumGrid::Point factors;
  if (medium.bounds) {
    const Vec3 own = medium.to_medium.point(position);
    if (!medium.bounds->contains(own)) return {};
    if (medium.grid) factors = medium.grid->at(across(*medium.bounds, own));
  }
  MediumPoint out{medium.sigma_a * factors.sigma_a, medium.sigma_s * factors.sigma_s};
  out.emission = medium.emission * factors.emission * out.sigma_a;
  return out;
}

bool emits(const Medium& medium) {
  const MediumGrid::Point most = medium.grid ? medium.grid->greatest() : MediumGrid::Point();
  return !is_black(medium.emission * most.emission * medium.sigma_a * most.sigma_a);
}

float greatest_extinction(const Medium& medium) {
  return extinction(medium, medium.grid ? medium.grid->greatest() : MediumGrid::Point());
}

MediumSpan span_in(const Medium& medium, Vec3 origin, Vec3 direction, float first, float last) {
  if (!medium.bounds) return {first, last};
  const Vec3 from = medium.to_medium.point(origin), along = medium.to_medium.vector(direction);
  for (int axis = 0; axis < 3; ++axis) {
    const float low = medium.bounds->min[axis] - from[axis], high = medium.bounds->max[axis] - from[axis];
    if (along[axis] == 0) {
      if (low > 0 || high < 0) return {};
      continue;
    }
    const float a = low / along[axis], b = high / along[axis];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return {first, last};
}

BlockWalk::BlockWalk(const Medium& medium, Vec3 origin, Vec3 direction, MediumSpan span)
    : medium_(medium), last_(span.last) {
  const MediumGrid& grid = *medium.grid;
  const Vec3 size = medium.bounds->diagonal(), from = medium.to_medium.point(origin) - medium.bounds->min;
  const Vec3 along = medium.to_medium.vector(direction);
  for (std::size_t a = 0; a < 3; ++a) {
    const int axis = static_cast<int>(a);
    // In blocks: the last one may reach beyond the bounds.
    const float per_length =
        static_cast<float>(grid.values().size[a]) / (size[axis] * static_cast<float>(grid.cells_per_block()));
    const float start = from[axis] * per_length, speed = along[axis] * per_length;
    block_[a] = std::clamp(static_cast<int>(std::floor(start + speed * span.first)), 0, grid.blocks()[a] - 1);
    step_[a] = speed < 0 ? -1 : 1;
    by_[a] = speed == 0 ? std::numeric_limits<float>::infinity() : 1 / std::abs(speed);
    const int plane = block_[a] + (speed < 0 ? 0 : 1);
    next_[a] = speed == 0 ? by_[a] : (static_cast<float>(plane) - start) / speed;
  }
}

float BlockWalk::majorant() const { return extinction(medium_, medium_.grid->bound(block_)); }

bool BlockWalk::advance() {
  if (leaves() >= last_) return false;
  const std::size_t a = next_[0] <= next_[1] ? (next_[0] <= next_[2] ? 0 : 2) : (next_[1] <= next_[2] ? 1 : 2);
  block_[a] += step_[a];
  next_[a] += by_[a];
  return block_[a] >= 0 && block_[a] < medium_.grid->blocks()[a];
}

}  // namespace glowworm
