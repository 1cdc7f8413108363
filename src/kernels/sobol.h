// Random numbers of many samplers at once.
#pragma once
#include <cstddef>
#include <cstdint>

namespace glowworm {

/// One pair of numbers for each of n samplers (SamplerKind::sobol) that differ only in their sample number: x[i], y[i]
/// equal Sampler(kind, seed, sequence, index[i]).next2(), bit for bit, after the number of earlier calls encoded in
/// `key`. Runs on the instruction set of set_simd().
/// @param key Sampler::pair_key()
void sobol_pairs(std::uint32_t key, const std::uint32_t* index, std::size_t n, float* x, float* y);

/// One pair of numbers for each of n samplers (SamplerKind::sobol) that differ only in their sequence: x[i], y[i] equal
/// Sampler(kind, seed, sequence[i], index).next2(), bit for bit, after `dimension` earlier calls.
void sobol_pairs_of(std::uint32_t seed, const std::uint32_t* sequence, std::size_t n, std::uint32_t index,
                    std::uint32_t dimension, float* x, float* y);

}  // namespace glowworm
