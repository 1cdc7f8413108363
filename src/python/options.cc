#include "python/options.h"

#include <algorithm>

#include "glowworm/render.h"

namespace glowworm::python {

namespace py = pybind11;

namespace {

/// The text of a value on the command line. Sequences are joined, and those in them, too.
std::string text_of(const py::handle& value, const char* separator) {
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::hasattr(value, "__fspath__")) return value.attr("__fspath__")().cast<std::string>();
  if (!py::isinstance<py::sequence>(value) && !py::hasattr(value, "__len__")) return py::str(value);
  std::string text;
  for (const py::handle part : value) text += (text.empty() ? "" : separator) + text_of(part, separator);
  return text;
}

/// The words for False and True of an option that is no flag.
const char* word_of(const std::string& option, bool value) {
  if (option == "filter") return value ? "auto" : "off";
  if (option == "studio-light" || option == "lamp-openings") return value ? "on" : "off";
  return nullptr;
}

}  // namespace

Options options_of(const py::kwargs& given) {
  Options out;
  for (const auto& [key, value] : given) {
    auto name = key.cast<std::string>();
    std::replace(name.begin(), name.end(), '_', '-');
    if (value.is_none()) continue;
    if (!py::isinstance<py::bool_>(value)) {
      out.emplace_back(name, text_of(value, name == "size" ? "x" : ","));
    } else if (const char* word = word_of(name, value.cast<bool>())) {
      out.emplace_back(name, word);
    } else {
      out.emplace_back(name, value.cast<bool>() ? "" : "not given");  // of a flag
    }
  }
  return out;
}

std::uint64_t count_of(const py::handle& value, const char* name, std::uint64_t most) {
  std::uint64_t count = 0;
  try {
    count = api::parse_count(py::str(value));
  } catch (const Error& error) {
    throw py::value_error(std::string(name) + ": " + error.what());
  }
  if (count > most) throw py::value_error(std::string(name) + " is more than " + std::to_string(most));
  return count;
}

}  // namespace glowworm::python
