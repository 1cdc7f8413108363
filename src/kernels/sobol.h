// Sample numbers of many samplers at once.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// The same pair of numbers of n samplers (SamplerKind::sobol) that differ in their sample number alone:
/// x[i], y[i] are what Sampler(kind, seed, sequence, index[i]).next2() gives, bit for bit, after as many earlier calls
/// as `key` was made for. Runs on the instruction set of set_simd().
/// @param key Sampler::pair_key()
void sobol_pairs(std::uint32_t key, const std::uint32_t* index, std::size_t n, float* x, float* y);

/// One pair of numbers each of n samplers (SamplerKind::sobol) that differ in their sequence alone: x[i], y[i] are what
/// Sampler(kind, seed, sequence[i], index).next2() gives, bit for bit, after `dimension` earlier calls.
void sobol_pairs_of(std::uint32_t seed, const std::uint32_t* sequence, std::size_t n, std::uint32_t index,
                    std::uint32_t dimension, float* x, float* y);

}  // namespace glowworm
