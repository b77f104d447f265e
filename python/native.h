/// The compiled half of `import stillpoint`: arrays in and out of the algorithms. What a Python user sees, with its
/// checks of shapes and its descriptions, is python/stillpoint/.
#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "c_api/settings.h"
#include "core/calibration.h"
#include "core/result.h"
#include "io/recording.h"

namespace stillpoint::python {

namespace py = pybind11;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Errors become Python's own: no such file FileNotFoundError, cannot create OSError, all else ValueError.
[[noreturn]] void raise(const Error& error);

template <class T>
T value_or_raise(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(*result);
}

/// A fresh array of these dimensions, filled by fill(data).
template <class T, class Fill>
py::array_t<T> make_array(std::vector<py::ssize_t> shape, const Fill& fill) {
  py::array_t<T> out(std::move(shape));
  fill(out.mutable_data());
  return out;
}

using SettingList = std::vector<std::pair<std::string, double>>;
/// Raises ValueError with the name that was meant.
c_api::Settings settings_from(const SettingList& list);

/// From and to {"acc": {"bias": ..., "matrix": ...}, ...}; keys that are absent keep the factory's values.
CalibrationSnapshot calibration_from(const py::dict& d);
py::dict calibration_to(const CalibrationSnapshot& snapshot);

void bind_recording(py::module_& m);
void bind_estimate(py::module_& m);
void bind_simulation(py::module_& m);

}  // namespace stillpoint::python
