/// The simulator, and the diagnosis of a recording against a simulation.
#include "diagnosis/diagnose.h"
#include "diagnosis/report/report.h"
#include "diagnosis/summary.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"
#include "python/native.h"

namespace stillpoint::python {
namespace {

io::Recording simulate(const std::string& yaml, const std::string& name, std::uint64_t seed,
                       const io::Recording* motion) {
  auto config = value_or_raise(io::parse_simulation(yaml, name));
  if (motion == nullptr && !config.motion)
    raise({ErrorKind::kBadConfig, name + ": no 'motion:'; add {kind: hand, duration_s: 60} or give motion=RECORDING"});
  if (motion == nullptr) {
    const py::gil_scoped_release free;
    return io::to_recording(sim::simulate(config, seed));
  }
  config.motion.reset();
  auto path = value_or_raise(sim::RecordedMotion::from(io::reference_track(*motion)));
  const auto surroundings = io::recorded_environment(*motion);
  const py::gil_scoped_release free;
  return io::to_recording(sim::simulate(config, std::move(path), seed, surroundings));
}

/// The answer as JSON, the improved simulation as YAML and the report as HTML.
py::tuple diagnose(const io::Recording& recording, const std::string& yaml, const std::string& name,
                   const std::vector<std::string>& without, std::size_t twins, const py::object& progress) {
  const auto config = value_or_raise(io::parse_simulation(yaml, name));
  std::function<void(double)> tell;
  if (!progress.is_none())
    tell = [&progress](double share) {
      const py::gil_scoped_acquire held;
      progress(share);
    };
  std::string json, improved_yaml, html;
  {
    const py::gil_scoped_release free;
    diag::Answer answer = diag::diagnose(recording, config, without, twins, tell);
    for (const auto& line : io::describe(recording.issues)) answer.diagnosis.notices.push_back(line);
    sim::SimulationConfig improved = config;
    improved.effects.insert(improved.effects.end(), answer.effects.begin(), answer.effects.end());
    json = diag::to_json(answer.diagnosis);
    improved_yaml = io::format_simulation(improved);
    html = diag::report_html(answer.diagnosis, {"recording", name, "", ""});
  }
  return py::make_tuple(json, improved_yaml, html);
}

}  // namespace

void bind_simulation(py::module_& m) {
  m.def("simulate", &simulate, py::arg("yaml"), py::arg("name"), py::arg("seed"), py::arg("motion").none(true));
  m.def("diagnose", &diagnose);
}

}  // namespace stillpoint::python
