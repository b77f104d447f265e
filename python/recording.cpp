/// Recordings as arrays.
#include <cmath>
#include <cstring>

#include "python/native.h"

namespace stillpoint::python {
namespace {

using io::Recording;

py::object vectors_to(const std::vector<Vec3>& rows) {
  if (rows.empty()) return py::none();
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  return make_array<double>({static_cast<py::ssize_t>(rows.size()), 3},
                            [&](double* to) { std::memcpy(to, rows.data(), rows.size() * sizeof(Vec3)); });
}

py::object numbers_to(const std::vector<double>& rows) {
  if (rows.empty()) return py::none();
  return make_array<double>({static_cast<py::ssize_t>(rows.size())},
                            [&](double* to) { std::copy(rows.begin(), rows.end(), to); });
}

void vectors_from(const py::object& o, std::vector<Vec3>& rows) {
  if (o.is_none()) return;
  const auto a = o.cast<Doubles>();
  rows.resize(static_cast<std::size_t>(a.shape(0)));
  std::memcpy(rows.data()->data(), a.data(), rows.size() * sizeof(Vec3));
}

void numbers_from(const py::object& o, std::vector<double>& rows) {
  if (o.is_none()) return;
  const auto a = o.cast<Doubles>();
  rows.assign(a.data(), a.data() + a.size());
}

py::array_t<double> times_to(const Recording& r) {
  return make_array<double>({static_cast<py::ssize_t>(r.size())}, [&](double* to) {
    for (std::size_t i = 0; i < r.size(); ++i) to[i] = r.t_s(i);
  });
}

/// Columns by the names of the CSV without their axes. Shapes and times were checked by the caller.
Recording from_columns(const py::dict& columns) {
  const auto column = [&](const char* name) -> py::object {
    return columns.contains(name) ? columns[name] : py::object(py::none());
  };
  Recording r;
  const auto t = columns["time_s"].cast<Doubles>();
  for (py::ssize_t i = 0; i < t.size(); ++i) r.t_ns.push_back(std::llround(1e9 * t.data()[i]));
  vectors_from(column("acc_mps2"), r.acc_mps2);
  vectors_from(column("gyr_radps"), r.gyr_radps);
  vectors_from(column("mag_uT"), r.mag_uT);
  vectors_from(column("ref_position_m"), r.ref_position_m);
  numbers_from(column("temp_degC"), r.temp_degC);
  numbers_from(column("current_A"), r.current_A);
  numbers_from(column("supply_V"), r.supply_V);
  numbers_from(column("ref_moving"), r.ref_moving);
  if (const py::object q = column("ref_q_wxyz"); !q.is_none()) {
    const auto a = q.cast<Doubles>();
    for (py::ssize_t i = 0; i < a.shape(0); ++i) r.ref_q_world_body.emplace_back(a.data() + 4 * i);
  }
  return r;
}

py::dict to_columns(const Recording& r) {
  py::dict d;
  d["time_s"] = times_to(r);
  d["acc_mps2"] = vectors_to(r.acc_mps2);
  d["gyr_radps"] = vectors_to(r.gyr_radps);
  d["mag_uT"] = vectors_to(r.mag_uT);
  d["temp_degC"] = numbers_to(r.temp_degC);
  d["current_A"] = numbers_to(r.current_A);
  d["supply_V"] = numbers_to(r.supply_V);
  d["ref_position_m"] = vectors_to(r.ref_position_m);
  d["ref_moving"] = numbers_to(r.ref_moving);
  d["ref_q_wxyz"] = py::none();
  if (!r.ref_q_world_body.empty())
    d["ref_q_wxyz"] = make_array<double>({static_cast<py::ssize_t>(r.size()), 4}, [&](double* to) {
      for (const auto& q : r.ref_q_world_body) to = std::copy(q.data(), q.data() + 4, to);
    });
  return d;
}

}  // namespace

void bind_recording(py::module_& m) {
  py::class_<Recording>(m, "Recording")
      .def_static("read",
                  [](const std::string& path, bool skip_malformed) {
                    const py::gil_scoped_release free;
                    auto recording = io::read_recording(
                        path, skip_malformed ? io::OnMalformedRow::kCount : io::OnMalformedRow::kFail);
                    const py::gil_scoped_acquire held;
                    return value_or_raise(std::move(recording));
                  })
      .def_static("from_columns", &from_columns)
      .def("columns", &to_columns)
      .def("__len__", &Recording::size)
      .def("notices", [](const Recording& r) { return io::describe(r.issues); })
      .def("write", [](const Recording& r, const std::string& path) {
        if (const auto written = io::write_recording(r, path); !written) raise(written.error());
      });
}

}  // namespace stillpoint::python
