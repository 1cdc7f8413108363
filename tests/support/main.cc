// The main program of all tests.
#include <gtest/gtest.h>

#include "core/option_names.h"
#include "core/parallel.h"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  glowworm::name_options_with_dashes(true);
  const int status = RUN_ALL_TESTS();
  glowworm::end_threads();
  return status;
}
