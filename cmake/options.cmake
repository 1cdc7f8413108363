# One interface target carries what every part of the project is compiled with.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# Without sanitizers, for the program that runs under limits on memory (src/CMakeLists.txt).
add_library(glowworm_plain_options INTERFACE)
target_compile_options(glowworm_plain_options INTERFACE -Wall -Wextra -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(glowworm_plain_options INTERFACE -Wno-restrict)  # false alarms on std::string, GCC bug 105651
endif()
if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(glowworm_plain_options INTERFACE -Wno-subobject-linkage)  # a type of one file's own, in a class
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 takes (double)(float)x for x where it makes a vector of two neighbouring scalars: what rounding a position to
  # floats leaves is lost (core_test's TransformDouble.RoundingLeavesItsRemainder). Rooms that trace and sum light round
  # no positions, and keep these vectors, which make paths a tenth faster.
  target_compile_options(glowworm_plain_options INTERFACE
    $<$<NOT:$<BOOL:$<TARGET_PROPERTY:GLOWWORM_ROUNDS_NO_POSITIONS>>>:-fno-tree-slp-vectorize>)
endif()
# Fused multiply-add only where a kernel asks for it by name: the same bits from every compiler.
target_compile_options(glowworm_plain_options INTERFACE -ffp-contract=off)
target_include_directories(glowworm_plain_options INTERFACE ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/include)
add_library(glowworm_options INTERFACE)
target_link_libraries(glowworm_options INTERFACE glowworm_plain_options)
# Kernels have arrays and members of vectors, so these need a size at compile time, which SVE's and RISC-V's lack.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64|riscv64)$")
  target_compile_definitions(glowworm_options INTERFACE "HWY_DISABLED_TARGETS=(HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128|HWY_RVV)")
endif()
# Highway's NEON has AES in its target, which GCC does not give to members that it makes itself; nothing uses AES.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  target_compile_options(glowworm_options INTERFACE -march=armv8-a+crypto)
endif()
if(GLOWWORM_SCALAR_ONLY)
  target_compile_definitions(glowworm_options INTERFACE HWY_COMPILE_ONLY_SCALAR)
endif()
if(GLOWWORM_SANITIZE)
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
    # AVX2 and plain code, of five instruction sets: kernels are the same source in all.
    target_compile_definitions(glowworm_options INTERFACE
      "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3|HWY_AVX3_DL)")
  endif()
  target_compile_options(glowworm_options INTERFACE -fsanitize=${GLOWWORM_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(glowworm_options INTERFACE -fsanitize=${GLOWWORM_SANITIZE})
endif()
