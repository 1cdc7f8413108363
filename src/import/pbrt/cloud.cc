#include "import/pbrt/cloud.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/random.h"

namespace glowworm {

namespace {

constexpr int kOctaves = 5;
constexpr float kLacunarity = 1.99f;  // below 2: the lattices of the octaves do not coincide

/// Product of the offset from a lattice point with its gradient, one of twelve.
float gradient_product(int x, int y, int z, Vec3 offset) {
  std::uint32_t hash = hash_combine(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
  hash = hash_combine(hash, static_cast<std::uint32_t>(z)) % 12;
  const int skipped = static_cast<int>(hash % 3);
  const float a = offset[(skipped + 1) % 3], b = offset[(skipped + 2) % 3];
  return ((hash / 3) & 1 ? -a : a) + ((hash / 6) & 1 ? -b : b);
}

/// Gradient noise in about [-1, 1].
float noise(Vec3 p) {
  int cell[3];
  float share[3];
  Vec3 offset;
  for (int axis = 0; axis < 3; ++axis) {
    const float lower = std::floor(p[axis]), t = p[axis] - lower;
    cell[axis] = static_cast<int>(lower);
    offset[axis] = t;
    share[axis] = t * t * t * (t * (t * 6 - 15) + 10);
  }
  float sum = 0;
  for (int i = 0; i < 8; ++i) {
    const int x = i & 1, y = (i >> 1) & 1, z = i >> 2;
    const Vec3 from = offset - Vec3{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    const float weight = (x ? share[0] : 1 - share[0]) * (y ? share[1] : 1 - share[1]) * (z ? share[2] : 1 - share[2]);
    sum += weight * gradient_product(cell[0] + x, cell[1] + y, cell[2] + z, from);
  }
  return sum;
}

/// The gradient of noise().
Vec3 noise_gradient(Vec3 p) {
  constexpr float kStep = 0.01f;
  const float here = noise(p);
  return Vec3{noise(p + Vec3{kStep, 0, 0}) - here, noise(p + Vec3{0, kStep, 0}) - here,
              noise(p + Vec3{0, 0, kStep}) - here} /
         kStep;
}

float cloud_density(const PbrtCloud& cloud, Vec3 p) {
  Vec3 at = p * cloud.frequency;
  float strength = 0.05f * cloud.wispiness, frequency = 10;
  for (int octave = 0; octave < 2 && strength > 0; ++octave) {
    at += strength * noise_gradient(at * frequency);
    strength *= 0.5f;
    frequency *= kLacunarity;
  }
  float sum = 0, weight = 0.5f;
  frequency = 1;
  for (int octave = 0; octave < kOctaves; ++octave) {
    sum += weight * noise(at * frequency);
    weight *= 0.5f;
    frequency *= kLacunarity;
  }
  const float thinning = std::clamp((1 - p.y) * 4.5f * cloud.density * sum, 0.0f, 1.0f);
  return std::clamp(thinning + 2 * std::max(0.0f, 0.5f - p.y), 0.0f, 1.0f);
}

/// Cells along a side: two for each cell of the finest octave's lattice, within bounds.
int cells_along(float side, float frequency) {
  constexpr float kLeast = 16, kMost = 192;
  const float finest = frequency * std::pow(kLacunarity, static_cast<float>(kOctaves - 1));
  return static_cast<int>(std::ceil(std::clamp(2 * side * finest, kLeast, kMost)));
}

}  // namespace

MediumGridValues cloud_grid(const PbrtCloud& cloud, const Box3& bounds, MemoryBudget& budget) {
  MediumGridValues grid;
  const Vec3 sides = bounds.diagonal();
  for (int axis = 0; axis < 3; ++axis)
    grid.size[static_cast<std::size_t>(axis)] = cells_along(sides[axis], cloud.frequency);
  const Reservation room(budget, "cloud", grid.cell_count() * sizeof(float));
  grid.density.resize(grid.cell_count());
  const auto [nx, ny, nz] = grid.size;
  const Vec3 cell{sides.x / static_cast<float>(nx), sides.y / static_cast<float>(ny), sides.z / static_cast<float>(nz)};
  const std::array<int, 3> size = grid.size;
  parallel_for_each(static_cast<std::size_t>(size[1] * size[2]), 64, [&](std::size_t row) {
    const float y = static_cast<float>(row % static_cast<std::size_t>(size[1])) + 0.5f;
    const float z = static_cast<float>(row / static_cast<std::size_t>(size[1])) + 0.5f;
    for (int x = 0; x < size[0]; ++x)
      grid.density[row * static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(x)] =
          cloud_density(cloud, bounds.min + cell * Vec3{static_cast<float>(x) + 0.5f, y, z});
  });
  return grid;
}

}  // namespace glowworm
