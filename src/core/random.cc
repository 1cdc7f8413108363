#include "core/random.h"

#include <array>

namespace glowworm {

namespace {

/// The second Sobol' dimension: column k of its generator matrix, from the primitive polynomial x + 1 (Pascal's
/// triangle mod 2). With four tables of 256 entries, a point takes four look-ups.
struct SobolTables {
  std::array<std::array<std::uint32_t, 256>, 4> y{};  // bits reversed
  constexpr SobolTables() {
    std::array<std::uint32_t, 32> column{};
    column[0] = 1u << 31;
    for (int k = 1; k < 32; ++k) column[k] = column[k - 1] ^ (column[k - 1] >> 1);
    for (int byte = 0; byte < 4; ++byte)
      for (int value = 0; value < 256; ++value) {
        std::uint32_t sum = 0;
        for (int bit = 0; bit < 8; ++bit)
          if (value >> bit & 1) sum ^= column[byte * 8 + bit];
        y[byte][value] = reverse_bits(sum);
      }
  }
};
constexpr SobolTables tables;

std::uint32_t reversed_sobol_y(std::uint32_t index) {
  return tables.y[0][index & 255] ^ tables.y[1][index >> 8 & 255] ^ tables.y[2][index >> 16 & 255] ^
         tables.y[3][index >> 24];
}

/// The hash of Laine and Karras; it scrambles bits in reversed order.
std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1;
  x ^= x * 0x05526c56u;
  return x ^ x * 0x53a22864u;
}

}  // namespace

std::uint32_t nested_uniform_scramble(std::uint32_t x, std::uint32_t seed) {
  return reverse_bits(scramble_reversed(reverse_bits(x), seed));
}

Vec2 Sampler::next2() {
  const std::uint32_t key = hash_combine(key_, dimension_++);
  if (kind_ == SamplerKind::independent) {
    const std::uint32_t x = hash_combine(key, index_);
    return {to_unit_float(x), to_unit_float(hash32(x ^ 0xa511e9b3u))};
  }
  // Shuffling the index with its own scramble decorrelates the pairs of dimensions. Every power-of-two block of samples
  // remains a block of a (0,2)-sequence.
  const std::uint32_t shuffled = nested_uniform_scramble(index_, key);
  // nested_uniform_scramble() of the Sobol' point of that index, without the reversals that cancel.
  const std::uint32_t x = scramble_reversed(shuffled, hash32(key ^ 0x68bc21ebu));
  const std::uint32_t y = scramble_reversed(reversed_sobol_y(shuffled), hash32(key ^ 0x02e5be93u));
  return {to_unit_float(reverse_bits(x)), to_unit_float(reverse_bits(y))};
}

}  // namespace glowworm
