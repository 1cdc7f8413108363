// The main function of a program of tables.
#pragma once
#include <cstdio>
#include <exception>

namespace glowworm::bench {

/// Calls write(); where it throws, says what went wrong. Returns the status of the program.
template <typename Write>
int run_tables(const char* program, Write&& write) {
  try {
    write();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return 1;
  }
}

}  // namespace glowworm::bench
