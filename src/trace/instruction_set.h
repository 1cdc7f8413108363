// Version and instruction set of the ray tracer.
#pragma once
#include <string>
#include <vector>

namespace glowworm {

/// Version of Embree and the instruction set that it uses, for example "Embree 3.13.5, avx2". The bits of hits depend
/// on both.
std::string ray_instruction_set();

/// The instruction sets that rays can use on this machine, best first; the first is the default.
std::vector<std::string> ray_instruction_sets();

/// Chooses the instruction set of every Tracer that is made from now on. Throws Error if the machine does not have it.
void set_ray_instruction_set(const std::string& name);

/// Argument of rtcNewDevice() for the chosen instruction set; "" for the default.
const std::string& ray_device_configuration();

}  // namespace glowworm
