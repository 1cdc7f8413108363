// Runs checks of kernels on every instruction set of the machine.
#pragma once
#include <gtest/gtest.h>

#include <string>

#include "kernels/simd.h"

namespace glowworm {

/// Runs the check on every instruction set of the machine.
template <typename Check>
void on_every_instruction_set(Check&& check) {
  for (const std::string& name : simd_names()) {
    SCOPED_TRACE(name);
    set_simd(name);
    check();
  }
  set_simd("auto");
}

}  // namespace glowworm
