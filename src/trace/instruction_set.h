// What rays are traced with on this machine.
#pragma once
#include <string>

namespace glowworm {

/// Version of Embree and the instruction set that it takes, for example "Embree 3.13.5, avx2": the bits of hits depend
/// on them.
std::string ray_instruction_set();

}  // namespace glowworm
