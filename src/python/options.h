// Keywords of Python to options of the library.
#pragma once
#include <pybind11/pybind11.h>

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace glowworm::python {

/// Options by name without dashes, with their text.
using Options = std::vector<std::pair<std::string, std::string>>;

/// Keywords as options. None, and False of a flag, are left out.
Options options_of(const pybind11::kwargs& given);

/// A whole number of 0 or more: an int, a float such as 1e4, or a text such as "10k". Throws ValueError, which names
/// the argument, for another.
std::uint64_t count_of(const pybind11::handle& value, const char* name,
                       std::uint64_t most = std::numeric_limits<std::uint64_t>::max());
inline std::uint32_t count32_of(const pybind11::handle& value, const char* name) {
  return static_cast<std::uint32_t>(count_of(value, name, std::numeric_limits<std::uint32_t>::max()));
}

}  // namespace glowworm::python
