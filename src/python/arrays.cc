#include "python/arrays.h"

#include <cmath>
#include <limits>

namespace glowworm::python {

namespace {

std::string shape_of(const py::array& array) { return py::str(array.attr("shape")); }

/// The argument as an array of any numbers.
py::array numbers(const py::handle& argument, const char* name, const std::string& kinds, const char* wanted) {
  const py::array array = py::array::ensure(argument);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + " is not an array: it is " +
                         std::string(py::str(py::type::of(argument).attr("__name__"))));
  }
  // An empty list is an array of no floats.
  if (array.size() > 0 && kinds.find(array.dtype().kind()) == std::string::npos)
    throw py::type_error(std::string(name) + " has dtype " + std::string(py::str(array.dtype())) + "; expected " +
                         wanted);
  return array;
}

[[noreturn]] void refuse_shape(const char* name, const py::array& array, const char* wanted) {
  throw py::value_error(std::string(name) + " has shape " + shape_of(array) + "; expected " + wanted);
}

/// The index of an element as NumPy writes it: "[3, 1]".
std::string index_text(const py::array& array, py::ssize_t element) {
  std::string text;
  for (py::ssize_t axis = array.ndim() - 1; axis >= 0; --axis) {
    text = std::to_string(element % array.shape(axis)) + (text.empty() ? "" : ", ") + text;
    element /= array.shape(axis);
  }
  return "[" + text + "]";
}

}  // namespace

Floats floats(const py::handle& argument, const char* name, Check check) {
  const py::array given = numbers(argument, name, "fiu", "real numbers");
  // Conversion of numbers beyond the range of float warns; they are refused below.
  const py::object quiet = py::module_::import("numpy").attr("errstate")(py::arg("over") = "ignore");
  quiet.attr("__enter__")();
  const auto array = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(given);
  quiet.attr("__exit__")(py::none(), py::none(), py::none());
  if (!array) throw py::error_already_set();
  if (check == Check::finite) check_finite(array, name);
  return array;
}

void check_finite(const Floats& array, const char* name) {
  for (py::ssize_t i = 0; i < array.size(); ++i)
    if (!std::isfinite(array.data()[i]))
      throw py::value_error(std::string(name) + index_text(array, i) + " is " + std::to_string(array.data()[i]) +
                            "; expected finite numbers within the range of float32");
}

Floats vectors(const py::handle& argument, const char* name, Check check) {
  Floats array = floats(argument, name, check);
  if (array.ndim() == 1 && array.size() == 0) return array;
  if (array.ndim() != 2 || array.shape(1) != 3) refuse_shape(name, array, "(n, 3)");
  return array;
}

Floats vectors(const py::handle& argument, const char* name, py::ssize_t count, const char* of, Check check) {
  Floats array = vectors(argument, name, check);
  if (array.shape(0) != count)
    throw py::value_error("there are " + std::to_string(array.shape(0)) + " " + name + " for " + std::to_string(count) +
                          " " + of);
  return array;
}

py::array_t<std::uint32_t, py::array::c_style> triangles(const py::handle& argument, const char* name) {
  const py::array given = numbers(argument, name, "iu", "whole numbers");
  if (given.ndim() != 2 || given.shape(1) != 3) refuse_shape(name, given, "(m, 3)");
  using Indices = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;
  const auto wide = Indices::ensure(given);
  if (!wide) throw py::error_already_set();
  py::array_t<std::uint32_t, py::array::c_style> out({wide.shape(0), wide.shape(1)});
  for (py::ssize_t i = 0; i < wide.size(); ++i) {
    const std::int64_t index = wide.data()[i];
    if (index < 0 || index > std::numeric_limits<std::uint32_t>::max())
      throw py::value_error(std::string(name) + index_text(wide, i) + " is " + std::to_string(index) +
                            ", which is no index of a vertex");
    out.mutable_data()[i] = static_cast<std::uint32_t>(index);
  }
  return out;
}

api::Vec3 vector(const py::handle& argument, const char* name) {
  const Floats array = floats(argument, name);
  if (array.ndim() != 1 || array.size() != 3) refuse_shape(name, array, "(3,)");
  return {array.data()[0], array.data()[1], array.data()[2]};
}

api::Rgb color(const py::handle& argument, const char* name) {
  const Floats array = floats(argument, name);
  const float* c = array.data();
  if (array.ndim() == 0) return {c[0], c[0], c[0]};
  if (array.ndim() != 1 || array.size() != 3) refuse_shape(name, array, "(3,), or one number");
  return {c[0], c[1], c[2]};
}

}  // namespace glowworm::python
