// Which instruction set the SIMD kernels run on.
#pragma once
#include <string>
#include <vector>

namespace glowworm {

/// Chooses the instruction set of all kernels from now on: "auto" is the best that the machine has, else one of
/// simd_names(). Not to be called while kernels run. Throws Error for names and instruction sets that are not there.
void set_simd(const std::string& name);

/// The instruction set in use, by the names of set_simd: "avx512", "avx2", "sse4", "ssse3", "neon", "scalar", ...
std::string simd_name();

/// Floats in a vector of the instruction set in use.
int simd_lanes();

/// The instruction sets that this machine can run and this program holds kernels for, best first.
std::vector<std::string> simd_names();

}  // namespace glowworm
