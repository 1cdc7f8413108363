// Test names for tests with a built-in scene as parameter.
#pragma once
#include <algorithm>
#include <string>

namespace glowworm {

/// The scene's name with what GoogleTest takes for a name: for INSTANTIATE_TEST_SUITE_P.
inline constexpr auto scene_test_name = [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
};

}  // namespace glowworm
