// Arrays of NumPy to spans of the library, and back.
#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "glowworm/error.h"
#include "glowworm/types.h"

namespace glowworm::python {

namespace py = pybind11;

/// Contiguous floats that an argument holds, or a copy where it holds others.
using Floats = py::array_t<float, py::array::c_style>;

/// Whether numbers must be finite, or their receiver checks that.
enum class Check : std::uint8_t { finite, later };

/// An argument as floats. Throws TypeError unless it is an array, or nested sequences, of real numbers, and as
/// check_finite() does. @param name of the argument
Floats floats(const py::handle& argument, const char* name, Check check = Check::finite);
/// As above, of shape (n, 3); throws ValueError for another.
Floats vectors(const py::handle& argument, const char* name, Check check = Check::finite);
/// As above; throws ValueError for another length than `count`. @param of "points"
Floats vectors(const py::handle& argument, const char* name, py::ssize_t count, const char* of,
               Check check = Check::finite);
/// Throws ValueError for the first number that is not finite, with its index.
void check_finite(const Floats& array, const char* name);
/// Indices of shape (n, 3). Throws TypeError unless they are whole numbers, and ValueError for negative ones.
py::array_t<std::uint32_t, py::array::c_style> triangles(const py::handle& argument, const char* name);

/// One point or direction of three numbers.
api::Vec3 vector(const py::handle& argument, const char* name);
/// A colour: three numbers, or one for all.
api::Rgb color(const py::handle& argument, const char* name);

/// The value of an enumeration by its name. Throws Error, which lists the names, for another.
/// @param names in the order of the enumeration
template <typename Enum>
Enum choice(const char* what, const std::string& text, const std::vector<std::string>& names) {
  std::string all;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (text == names[i]) return static_cast<Enum>(i);
    all += (i > 0 ? ", " : "") + names[i];
  }
  throw Error(std::string(what) + " '" + text + "' is not known", "Choose from: " + all + ".");
}

/// The elements of an array whose rows have the layout of T.
template <typename T, typename Number>
std::span<const T> rows(const py::array_t<Number, py::array::c_style>& array) {
  static_assert(sizeof(T) % sizeof(Number) == 0);
  return {reinterpret_cast<const T*>(array.data()),
          static_cast<std::size_t>(array.size()) * sizeof(Number) / sizeof(T)};
}

/// An array of shape `shape` over memory that `owner` keeps alive.
template <typename Number>
py::array view(const Number* data, const std::vector<py::ssize_t>& shape, const py::handle& owner, bool writable) {
  py::array_t<Number> out(shape, data, owner);
  if (!writable) out.attr("flags").attr("writeable") = false;
  return out;
}

/// An array of shape (n, sizeof(T) / sizeof(Number)), or (n) where they are the same, over values that `owner` keeps
/// alive.
template <typename Number, typename T>
py::array view_of(std::span<const T> values, const py::handle& owner, bool writable = false) {
  static_assert(sizeof(T) % sizeof(Number) == 0);
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values.size())};
  if (sizeof(T) != sizeof(Number)) shape.push_back(sizeof(T) / sizeof(Number));
  return view(reinterpret_cast<const Number*>(values.data()), shape, owner, writable);
}

/// The same over a vector that the array owns.
template <typename Number, typename T>
py::array owned(std::vector<T> values) {
  auto holder = std::make_unique<std::vector<T>>(std::move(values));
  const std::span<const T> kept(*holder);
  const py::capsule owner(holder.release(), [](void* vector) { delete static_cast<std::vector<T>*>(vector); });
  return view_of<Number>(kept, owner, true);
}

/// owned() of the vector that work() returns, which runs without the lock of the interpreter.
template <typename Number, typename Work>
py::array owned_result(Work&& work) {
  auto values = [&] {
    const py::gil_scoped_release release;
    return work();
  }();
  return owned<Number>(std::move(values));
}

}  // namespace glowworm::python
