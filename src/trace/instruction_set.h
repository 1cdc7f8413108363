// Version and instruction set of the ray tracer.
#pragma once
#include <string>

namespace glowworm {

/// Version of Embree and the instruction set that it uses, for example "Embree 3.13.5, avx2". The bits of hits depend
/// on both.
std::string ray_instruction_set();

}  // namespace glowworm
