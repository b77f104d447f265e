#include "python/native.h"

namespace stillpoint::python {

void raise(const Error& error) {
  PyObject* const type = error.kind == ErrorKind::kNoInput        ? PyExc_FileNotFoundError
                         : error.kind == ErrorKind::kCannotCreate ? PyExc_OSError
                                                                  : PyExc_ValueError;
  PyErr_SetString(type, error.message.c_str());
  throw py::error_already_set();
}

c_api::Settings settings_from(const SettingList& list) {
  c_api::Settings settings;
  for (const auto& [name, value] : list)
    if (const std::string fault = c_api::set(settings, name, value); !fault.empty())
      raise({ErrorKind::kBadConfig, fault});
  if (const std::string fault = check(settings); !fault.empty()) raise({ErrorKind::kBadConfig, fault});
  return settings;
}

namespace {

template <std::size_t N>
void read_numbers(const py::dict& d, const char* key, std::array<double, N>& out) {
  if (!d.contains(key)) return;
  const auto numbers = Doubles::ensure(d[key]);
  if (!numbers || numbers.size() != static_cast<py::ssize_t>(N))
    raise({ErrorKind::kUsage, std::string(key) + " must hold " + std::to_string(N) + " numbers"});
  std::copy(numbers.data(), numbers.data() + N, out.begin());
}

void read_triad(const py::dict& all, const char* sensor, TriadCalibration& out) {
  if (!all.contains(sensor)) return;
  const auto d = all[sensor].cast<py::dict>();
  read_numbers(d, "bias", out.bias);
  read_numbers(d, "matrix", out.matrix);
  read_numbers(d, "bias_per_K", out.bias_per_K);
  read_numbers(d, "bias_per_K2", out.bias_per_K2);
  for (const auto& [key, to] :
       {std::pair{"temp_ref_degC", &out.temp_ref_degC}, std::pair{"temp_min_degC", &out.temp_min_degC},
        std::pair{"temp_max_degC", &out.temp_max_degC}})
    if (d.contains(key)) *to = d[key].cast<double>();
}

py::array_t<double> matrix_to(const Array9& m) {
  return make_array<double>({3, 3}, [&](double* to) { std::copy(m.begin(), m.end(), to); });
}
py::array_t<double> vector_to(const Array3& v) {
  return make_array<double>({3}, [&](double* to) { std::copy(v.begin(), v.end(), to); });
}

py::dict triad_to(const TriadCalibration& t) {
  py::dict d;
  d["bias"] = vector_to(t.bias);
  d["matrix"] = matrix_to(t.matrix);
  d["bias_per_K"] = vector_to(t.bias_per_K);
  d["bias_per_K2"] = vector_to(t.bias_per_K2);
  d["temp_ref_degC"] = t.temp_ref_degC;
  d["temp_min_degC"] = t.temp_min_degC;
  d["temp_max_degC"] = t.temp_max_degC;
  d["bias_covariance"] = matrix_to(t.bias_covariance);
  d["norm_sd"] = t.norm_sd;
  d["windows"] = t.windows;
  d["status"] = std::string(name(t.status));
  return d;
}

}  // namespace

CalibrationSnapshot calibration_from(const py::dict& d) {
  CalibrationSnapshot snapshot;
  read_triad(d, "acc", snapshot.acc);
  read_triad(d, "gyr", snapshot.gyr);
  read_triad(d, "mag", snapshot.mag);
  return snapshot;
}

py::dict calibration_to(const CalibrationSnapshot& snapshot) {
  py::dict d;
  d["version"] = snapshot.version;
  d["acc"] = triad_to(snapshot.acc);
  d["gyr"] = triad_to(snapshot.gyr);
  d["mag"] = triad_to(snapshot.mag);
  return d;
}

}  // namespace stillpoint::python

PYBIND11_MODULE(_native, m) {
  m.attr("__version__") = STILLPOINT_VERSION;
  m.def("setting_names", &stillpoint::c_api::setting_names);
  stillpoint::python::bind_recording(m);
  stillpoint::python::bind_estimate(m);
  stillpoint::python::bind_simulation(m);
}
