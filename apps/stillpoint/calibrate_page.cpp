#include "apps/stillpoint/calibrate_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/stillpoint/calibrate_quantities.h"
#include "apps/stillpoint/sphere_figure.h"
#include "report/document.h"

namespace stillpoint::app {
namespace {

using report::Colour;
using report::Curve;
using report::escaped;
using report::kAxisColour;
using report::Mark;
using report::Plot;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A triad as the page shows it: its values times `factor` are in `unit`.
struct Shown {
  const char *id, *name, *unit;
  double factor;
  TriadCalibration CalibrationSnapshot::*triad;
};

std::vector<Shown> shown(const CalibrationRun& run) {
  std::vector<Shown> out{{"acc", "Accelerometer", "m/s²", 1.0, &CalibrationSnapshot::acc},
                         {"gyr", "Gyroscope", "°/s", kDegPerRad, &CalibrationSnapshot::gyr}};
  if (run.has_mag) out.push_back({"mag", "Magnetometer", "µT", 1.0, &CalibrationSnapshot::mag});
  return out;
}

std::string verdict(const std::string& recording, const CalibrationRun& run) {
  std::vector<std::string> open;
  const auto all = quantities(run);
  for (const Quantity& q : all)
    if (!q.known) open.push_back(q.name);
  return fmt::format(
      "<div class=\"verdict\"><div class=\"label\">Calibration</div><h1>{} of {} quantities are known</h1>{}<p "
      "class=\"small\">{}: {:.1f} s, {} windows of rest; gravity {} m/s², {}</p></div>",
      all.size() - open.size(), all.size(),
      open.empty() ? "" : fmt::format("<p>Not yet: {}.</p>", fmt::join(open, "; ")), escaped(recording), run.duration_s,
      run.windows.size(), run.gravity_mps2, run.gravity_stated ? "as stated" : "assumed");
}

std::string quantity_table(const CalibrationRun& run) {
  std::string s =
      "<h2>What is known</h2><table><tr><th>quantity</th><th></th><th class=\"n\">deviation</th><th>unit</th><th "
      "class=\"n\">evidence used</th><th class=\"n\">refused</th></tr>";
  for (const Quantity& q : quantities(run))
    s += fmt::format(
        "<tr><td>{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td><td class=\"n\">{} {}</td><td "
        "class=\"n\">{}</td></tr>",
        q.name, q.known ? "known" : "<b>not yet</b>", q.sd > 0.0 ? fmt::format("{:.3g}", q.sd) : "", q.unit, q.used,
        q.evidence, q.refused);
  s += "</table>";
  const auto lacks = missing(run);
  if (lacks.empty()) return s;
  s += "<h2>What to do for the rest</h2><ul>";
  for (const std::string& line : lacks) s += "<li>" + escaped(line) + "</li>";
  return s + "</ul>";
}

std::string row_of(const char* head, const std::array<std::string, 3>& cells) {
  return fmt::format("<tr><th>{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>", head,
                     cells[0], cells[1], cells[2]);
}

std::string value_table(const Shown& sensor, const TriadCalibration& t) {
  std::string s = fmt::format(
      "<h3>{}: {}</h3><table><tr><th>{}</th><th class=\"n\">x</th><th class=\"n\">y</th><th class=\"n\">z</th></tr>",
      sensor.name, name(t.status), sensor.unit);
  const auto cells = [](const auto& cell) { return std::array<std::string, 3>{cell(0), cell(1), cell(2)}; };
  s += row_of("bias", cells([&](std::size_t k) { return fmt::format("{:.5f}", sensor.factor * t.bias[k]); }));
  s += row_of("its deviation", cells([&](std::size_t k) {
                const double variance = t.bias_covariance[4 * k];
                return variance > 0.0 ? fmt::format("{:.5f}", sensor.factor * std::sqrt(variance)) : "unknown";
              }));
  if (t.temp_max_degC > t.temp_min_degC)
    s += row_of("per kelvin",
                cells([&](std::size_t k) { return fmt::format("{:+.6f}", sensor.factor * t.bias_per_K[k]); }));
  for (std::size_t r = 0; r < 3; ++r)
    s += row_of(r == 0 ? "matrix" : "",
                cells([&](std::size_t k) { return fmt::format("{:.6f}", t.matrix[3 * r + k]); }));
  s += "</table>";
  if (t.bias_covariance[0] > 0.0) {
    s += fmt::format("<details><summary>covariance of the bias, ({})²</summary><table>", sensor.unit);
    for (std::size_t r = 0; r < 3; ++r)
      s += row_of("", cells([&](std::size_t k) {
                    return fmt::format("{:.3e}", sensor.factor * sensor.factor * t.bias_covariance[3 * r + k]);
                  }));
    s += "</table></details>";
  }
  return s;
}

double norm_error(const TriadCalibration& c, const calib::Window& w, double gravity_mps2) {
  return c.apply(w.acc_mps2, w.temp_degC).norm() - gravity_mps2;
}

bool has(const calib::Window& w, SamplePart part) { return (w.has & part) != 0; }

std::string coverage(const CalibrationRun& run) {
  double worst = 1e-12;
  for (const auto& w : run.windows)
    if (has(w, kAcc)) worst = std::max(worst, std::abs(norm_error(run.learnt.acc, w, run.gravity_mps2)));
  std::vector<MarkedDirection> marks;
  for (const auto& w : run.windows) {
    if (!has(w, kAcc)) continue;
    const double left = norm_error(run.learnt.acc, w, run.gravity_mps2);
    marks.push_back({run.learnt.acc.apply(w.acc_mps2, w.temp_degC).normalized(),
                     fmt::format("{:.1f} s: norm {:+.4f} m/s² off", run.seconds(w), left), std::abs(left) / worst});
  }
  return fmt::format(
      "<h2>Directions of gravity that were seen</h2><p class=\"how\">Each mark is a rest, in the sensor's axes; the "
      "fuller, the more of its norm is left over ({:.4f} m/s² at the fullest). A half without marks is a half whose "
      "scale and offset nobody can tell apart.</p><div class=\"wide\">{}</div>",
      worst, sphere_svg(marks));
}

Plot residuals(const CalibrationRun& run) {
  Plot p{"norm", "time, s", "length less gravity, m/s²", {}, {}};
  Curve before{"as configured", Colour::kBefore, {}, Mark::kDots}, after{"as learnt", Colour::kAfter, {}, Mark::kDots};
  for (const auto& w : run.windows) {
    if (!has(w, kAcc)) continue;
    p.x.push_back(run.seconds(w));
    before.y.push_back(norm_error(run.factory.acc, w, run.gravity_mps2));
    after.y.push_back(norm_error(run.learnt.acc, w, run.gravity_mps2));
  }
  p.curves = {before, after};
  return p;
}

/// The bias over the recording, less the last one: with it three curves of any size fit in one picture.
Plot course(const CalibrationRun& run, const Shown& sensor) {
  Plot p{std::string("course-") + sensor.id, "time, s", fmt::format("bias less the last, {}", sensor.unit), {}, {}};
  const TriadCalibration& last = run.learnt.*sensor.triad;
  for (std::size_t k = 0; k < 3; ++k) p.curves.push_back({std::string(1, "xyz"[k]), kAxisColour[k], {}, Mark::kBold});
  for (const char* bound : {"3 deviations of the worst axis: from", "to"})
    p.curves.push_back({bound, Colour::kNoise, {}, Mark::kDashed});
  for (const CalibrationMoment& moment : run.course) {
    const TriadCalibration& now = moment.known.*sensor.triad;
    p.x.push_back(moment.t_s);
    for (std::size_t k = 0; k < 3; ++k) p.curves[k].y.push_back(sensor.factor * (now.bias[k] - last.bias[k]));
    const double variance = std::max({now.bias_covariance[0], now.bias_covariance[4], now.bias_covariance[8]});
    const double bound = variance > 0.0 ? 3.0 * sensor.factor * std::sqrt(variance) : kNone;
    p.curves[3].y.push_back(-bound);
    p.curves[4].y.push_back(bound);
  }
  return p;
}

/// The gyroscope's reading at rest over temperature, with the bias that was learnt.
Plot over_temperature(const CalibrationRun& run) {
  Plot p{"temperature", "temperature, °C", "reading at rest, °/s", {}, {}};
  for (std::size_t k = 0; k < 3; ++k) p.curves.push_back({std::string(1, "xyz"[k]), kAxisColour[k], {}, Mark::kDots});
  for (std::size_t k = 0; k < 3; ++k)
    p.curves.push_back({fmt::format("bias {}", "xyz"[k]), kAxisColour[k], {}, Mark::kBold});
  for (const auto& w : run.windows) {
    if (!has(w, kGyr) || w.refusal != calib::Refusal::kNone) continue;
    p.x.push_back(w.temp_degC);
    const Vec3 bias = run.learnt.gyr.bias_at(w.temp_degC);
    for (std::size_t k = 0; k < 3; ++k) {
      p.curves[k].y.push_back(kDegPerRad * w.gyr_radps[k]);
      p.curves[3 + k].y.push_back(kDegPerRad * bias[static_cast<Eigen::Index>(k)]);
    }
  }
  return report::in_order_of_x(std::move(p));
}

std::string known_turn_table(const CalibrationRun& run) {
  if (run.known_turns.empty()) return "";
  std::string s =
      "<h2>Turns of known angle</h2><p class=\"how\">What the gyroscope read of them with the matrix at first, and "
      "with the one that was learnt.</p><table><tr><th>from, to</th><th class=\"n\">stated</th><th "
      "class=\"n\">before</th>"
      "<th class=\"n\">after</th><th>unit</th><th class=\"n\">off, in deviations</th><th></th></tr>";
  for (const KnownTurnReport& t : run.known_turns)
    s += fmt::format(
        "<tr><td>{:g} to {:g} s</td><td class=\"n\">{:.6g} ± {:.3g}</td><td class=\"n\">{:.2f}</td><td "
        "class=\"n\">{:.2f}</td><td>{}</td><td class=\"n\">{:+.1f}</td><td>{}</td></tr>",
        t.stated.begin_s, t.stated.end_s, t.in_unit(t.turn.angle_rad), t.in_unit(t.stated.sd_rad),
        t.in_unit(t.before.angle_rad), t.in_unit(t.after.angle_rad), t.unit(), t.residual_sd(),
        t.turn.used ? "used" : "<b>not used</b>");
  return s + "</table>";
}

std::string time_table(const CalibrationRun& run) {
  std::string s =
      "<h2>Where the time went</h2><table><tr><th>at rest, or why not</th><th class=\"n\">seconds</th></tr>";
  for (const auto& [reason, seconds] : run.refused_s)
    if (seconds > 0.0)
      s += fmt::format("<tr><td>{}</td><td class=\"n\">{:.1f}</td></tr>",
                       reason == "none" ? "at rest" : escaped(reason), seconds);
  for (const CalibrationFault& f : run.faults)
    s += fmt::format("<tr><td>the {} is {}</td><td class=\"n\">from {:.1f}</td></tr>", f.sensor, name(f.status), f.t_s);
  return s + "</table>";
}

}  // namespace

std::string calibration_html(const std::string& recording, const CalibrationRun& run) {
  std::string s = verdict(recording, run) + quantity_table(run) +
                  "<h2>Values</h2><p class=\"how\">What is measured is matrix · (reading − bias).</p>";
  std::vector<Plot> plots;
  std::string courses;
  for (const Shown& sensor : shown(run)) {
    s += value_table(sensor, run.learnt.*sensor.triad);
    plots.push_back(course(run, sensor));
    courses += report::figure_html(plots.back().id, fmt::format("{}: how the bias was learnt", sensor.name),
                                   "Each axis less its last value; inside the dashed lines the earlier ones agree with "
                                   "it.");
  }
  s += known_turn_table(run);
  if (!run.windows.empty()) {
    s += coverage(run);
    s += "<h2>Course</h2><div class=\"figures\">";
    plots.push_back(residuals(run));
    s +=
        report::figure_html("norm", "What is left of the norm",
                            "At rest the force has the length of gravity: what the accelerometer still misses, rest by "
                            "rest, with the configured and with the learnt calibration.");
    s += courses;
    plots.push_back(over_temperature(run));
    s += report::figure_html("temperature", "Gyroscope at rest over temperature",
                             "Each dot is a rest, each line the bias that was learnt. Outside of the temperatures "
                             "seen the bias stays as at their end.");
    s += "</div>";
  }
  return report::document_html("Calibration of " + recording, s + time_table(run), plots);
}

}  // namespace stillpoint::app
