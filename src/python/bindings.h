// The parts of the module, each in its file.
#pragma once
#include <pybind11/pybind11.h>

#include <chrono>
#include <future>
#include <utility>

#include "glowworm/interrupt.h"

namespace glowworm::python {

void bind_scene(pybind11::module_& module);
void bind_picture(pybind11::module_& module);
void bind_render(pybind11::module_& module);
void bind_photons(pybind11::module_& module);
void bind_rays(pybind11::module_& module);
void bind_sensors(pybind11::module_& module);
void bind_bake(pybind11::module_& module);

/// A function that reports the finished share to `progress`, unless that is None. It throws what `progress` and
/// handlers of signals raise, and may be called without the lock of the interpreter.
inline auto reporter(const pybind11::object& progress) {
  return [&progress](double share) {
    const pybind11::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
    if (!progress.is_none()) progress(share);
  };
}

/// Runs work(const Interrupt&) in a thread, without the lock of the interpreter, and returns its result. A signal whose
/// handler raises, such as Ctrl-C, interrupts the work, and the handler's exception is thrown.
template <typename Work>
auto interruptible(Work&& work) {
  namespace py = pybind11;
  constexpr std::chrono::milliseconds kInterval{20};
  Interrupt interrupt;
  auto result = std::async(std::launch::async, [&] { return work(std::as_const(interrupt)); });
  for (;;) {
    std::future_status status;
    {
      const py::gil_scoped_release release;
      status = result.wait_for(kInterval);
    }
    if (status == std::future_status::ready) return result.get();
    if (PyErr_CheckSignals() != 0) {
      interrupt.request();
      {
        const py::gil_scoped_release release;
        result.wait();
      }
      throw py::error_already_set();
    }
  }
}

}  // namespace glowworm::python
