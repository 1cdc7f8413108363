// The instruction set of the SIMD kernels.
#pragma once
#include <string>
#include <vector>

namespace glowworm {

/// Sets the instruction set of all kernels: one of simd_names(), or "auto" for the best one of the machine. Do not call
/// it while kernels run. Throws Error if the name is unknown or the machine lacks the instruction set.
void set_simd(const std::string& name);

/// The current instruction set, by its name for set_simd(): "avx512", "avx2", "sse4", "ssse3", "neon", "scalar", ...
std::string simd_name();

/// Number of floats in a vector of the current instruction set.
int simd_lanes();

/// The instruction sets that both this machine and this program support, best first.
std::vector<std::string> simd_names();

}  // namespace glowworm
