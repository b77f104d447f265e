#include "diagnosis/reference/curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "diagnosis/discovery/law_curves.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kMostPoints = 2000;
constexpr Eigen::Index kLongestWindow = 1024;  // of the spectrum
constexpr Eigen::Index kFewestWindows = 8;
constexpr Eigen::Index kLags = 40;
constexpr std::size_t kLongestLabel = 40;  // more does not fit below a plot; the finding's table has it in full

/// What a finding's law says in one channel, and the quantity to draw it against.
struct Against {
  Series driver;
  Series law;  ///< the part of the effect that this driver explains
  std::string label;
  Eigen::Index begin = 0, end = 0;  ///< samples where the law is a function of the driver
};

/// One-sided power density by Welch's method (1967): Hann windows that overlap by half. Muted samples are left out,
/// and each window is scaled by what is left of it. From one period a window up to below the Nyquist frequency.
Series density(const Series& x, const Layout& layout, Eigen::Index length, double dt_s) {
  Eigen::FFT<double> fft;
  const Series w = 0.5 * (1.0 - (Series::LinSpaced(length, 0.0, static_cast<double>(length - 1)) * 2.0 *
                                 std::numbers::pi / static_cast<double>(length))
                                    .array()
                                    .cos());
  Series sum = Series::Zero(length / 2 - 1);
  double weight = 0.0;
  for (Eigen::Index b = 0; b + length <= x.size(); b += length / 2) {
    const Series here = w.array() * layout.present.segment(b, length);
    const double mean = here.dot(x.segment(b, length)) / std::max(here.sum(), 1e-300);
    const Series tapered = here.array() * (x.segment(b, length).array() - mean);
    Eigen::VectorXcd spectrum;
    fft.fwd(spectrum, tapered);
    sum += spectrum.segment(1, length / 2 - 1).cwiseAbs2();
    weight += here.squaredNorm();
  }
  return 2.0 * dt_s * sum / std::max(weight, 1e-300);
}

void fill_spectrum(const Series& before, const Series& after, const NoiseModel& noise, const Layout& layout,
                   double dt_s, int axis, FindingFigures& out) {
  Eigen::Index length = 16;
  while (2 * length <= kLongestWindow && kFewestWindows * length <= layout.n) length *= 2;
  if (length > layout.n) return;
  const Eigen::Index bins = length / 2 - 1;
  const Series f = Series::LinSpaced(bins, 1.0, static_cast<double>(bins)) / (static_cast<double>(length) * dt_s);
  const auto stored = [](const Series& v) { return std::vector<double>(v.data(), v.data() + v.size()); };
  out.frequency_hz = stored(f);
  out.psd_before = stored(density(before, layout, length, dt_s));
  out.psd_after = stored(density(after, layout, length, dt_s));
  out.psd_noise = stored(noise.density(layout, f, dt_s, axis));
}

std::vector<double> autocorrelation(const Series& whitened) {
  const double power = std::max(whitened.squaredNorm(), 1e-300);
  std::vector<double> out;
  for (Eigen::Index lag = 0; lag <= std::min(kLags, whitened.size() - 1); ++lag)
    out.push_back(whitened.head(whitened.size() - lag).dot(whitened.tail(whitened.size() - lag)) / power);
  return out;
}

/// The unit of a driver whose coefficient has `coefficient` and whose product has `channel`.
std::string driver_unit(const std::string& channel, const std::string& coefficient) {
  if (coefficient == "1") return channel;
  if (coefficient == channel) return "1";
  for (const std::string& between : {std::string("/"), std::string(" per ")})
    if (coefficient.rfind(channel + between, 0) == 0) return coefficient.substr(channel.size() + between.size());
  return channel + " per " + coefficient;
}

bool ends_with_one_of(const std::string& id, std::initializer_list<const char*> ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const char* end) { return id.ends_with(end); });
}

/// Laws that are a function of one recorded quantity, in which they bend: drawn against that quantity itself.
bool curve_of_one_quantity(const Signals& s, const Found& f, Sensor sensor, int axis, Against& out) {
  if (f.kind != Kind::kNamed || f.shape_name == kTrackerShape) return false;
  const std::string channel = fmt::format("{}_{}", kSensorName[sensor], kAxisName[static_cast<std::size_t>(axis)]);
  if (ends_with_one_of(f.id, {"_temp_lin", "_temp_quad"})) {
    out.driver = s.temperature_K.array() + sim::kReferenceTemp_degC;
    out.label = "temperature, degC";
  } else if (ends_with_one_of(f.id, {"_quad", "_cubic", "_asym", "_sat"})) {
    out.driver = s.vector[sensor].col(axis);
    out.label = fmt::format("true {}, {}", channel, kSensorUnit[sensor]);
  } else if (f.id == "mag_hard_step") {
    out.driver = s.t_s;
    out.label = "time, s";
    out.begin = 0;
    out.end = s.n;
  } else {
    return false;
  }
  return true;
}

/// A law of several columns is drawn against the one that does most; what the others explain is taken off both.
void strongest_column(const SensorSearch& search, const Found& f, const Eigen::VectorXd& theta, int axis,
                      Against& out) {
  double most = -1.0;
  for (std::size_t j = 0; j < f.columns.size(); ++j) {
    const auto shown = shown_in(f.columns[j], axis);
    if (!shown) continue;
    const Series part = theta[static_cast<Eigen::Index>(j)] * *shown;
    if (part.squaredNorm() <= most) continue;
    most = part.squaredNorm();
    out.law = part;
    out.driver = *shown;
    out.label = f.driver.size() > kLongestLabel ? "driver" : f.driver;
    if (j >= f.names.size()) continue;
    if (f.kind == Kind::kNamed) out.label += fmt::format(" (factor of {})", f.names[j]);
    out.label += ", " + driver_unit(kSensorUnit[search.sensor], f.units[j]);
  }
}

Against against(const Signals& s, const SensorSearch& search, const Found& f, const Eigen::VectorXd& theta,
                const Series& effect, int axis) {
  Against out;
  out.begin = f.window.local ? f.window.begin : 0;
  out.end = f.window.local ? f.window.end : s.n;
  if (f.offset.size()) {  // a filter has no driver of the same moment
    out.driver = effect;
    out.law = effect;
    out.label = fmt::format("what the law predicts, {}", kSensorUnit[search.sensor]);
  } else if (curve_of_one_quantity(s, f, search.sensor, axis, out)) {
    out.law = effect;
  } else {
    strongest_column(search, f, theta, axis, out);
  }
  return out;
}

void fill_driver(const Against& a, const Series& leftover, const Layout& layout, FindingFigures& out) {
  if (a.driver.size() == 0) return;
  const Eigen::Index step = std::max<Eigen::Index>(1, (a.end - a.begin) / kMostPoints);
  for (Eigen::Index i = a.begin; i < a.end; i += step) {
    if (layout.present[i] == 0.0) continue;
    out.driver.push_back(a.driver[i]);
    out.residual_at_driver.push_back(leftover[i] + a.law[i]);
    out.law_at_driver.push_back(a.law[i]);
  }
  out.driver_label = a.label;
}

}  // namespace

FindingFigures curves_of(const Signals& s, const SensorSearch& search, std::size_t index, const Finished& finished) {
  const Found& f = search.found[index];
  const Layout& layout = search.target.layout;
  const Eigen::VectorXd theta =
      finished.fit.theta.segment(first_column(search, index), static_cast<Eigen::Index>(f.columns.size()));
  Series3 effect = contribution_of(f.columns, theta, s.n);
  if (f.offset.size()) effect += f.offset;
  Eigen::Index strongest = 0;
  effect.colwise().squaredNorm().maxCoeff(&strongest);
  const int axis = static_cast<int>(strongest);
  const Series after = finished.fit.leftover.col(axis), before = after + effect.col(axis);

  FindingFigures out;
  out.channel = fmt::format("{}_{}", kSensorName[search.sensor], kAxisName[static_cast<std::size_t>(axis)]);
  out.unit = kSensorUnit[search.sensor];
  for (Eigen::Index i = 0; i < s.n; i += std::max<Eigen::Index>(1, s.n / kMostPoints)) {
    if (layout.present[i] == 0.0) continue;
    out.t_s.push_back(s.t_s[i]);
    out.residual_after.push_back(after[i]);
    out.residual_before.push_back(before[i]);
    out.held_out.push_back(static_cast<int>(s.t_s[i] / 4.0) % 2 == 0);
  }
  fill_driver(against(s, search, f, theta, effect.col(axis), axis), after, layout, out);
  if (f.kind == Kind::kUnknown) out.against_each = against_each(s, f.id, axis, before, after, layout);
  const NoiseModel noise(layout, finished.fit.leftover);
  fill_spectrum(before, after, noise, layout, s.dt_s, axis, out);
  out.autocorrelation_before = autocorrelation(noise.whiten(layout, before, axis));
  out.autocorrelation_after = autocorrelation(noise.whiten(layout, after, axis));
  out.autocorrelation_band = 1.96 / std::sqrt(std::max(layout.used(), 1.0));
  return out;
}

void heat_of(const Signals& s, const SensorSearch& search, Diagnosis& out) {
  Target t = search.target;
  for (const Found& f : search.found)
    if (f.offset.size()) t.residual += f.offset;
  const Layout& layout = t.layout;
  const NoiseModel noise(layout, fit_profile(search.target, search.explained()).leftover);
  const Series3 left = fit_with(t, {}, noise, {}).leftover;
  for (int axis = 0; axis < 3; ++axis) {
    const Series w = noise.whiten(layout, left.col(axis), axis);
    std::vector<double> row, times;
    for (Eigen::Index b = 0; b < layout.n; b += layout.block) {
      const Eigen::Index length = std::min(layout.block, layout.n - b);
      row.push_back(0.5 * (w.segment(b, length).squaredNorm() - layout.counts.segment(b, length).sum()));
      times.push_back((static_cast<double>(b) + 0.5 * static_cast<double>(length)) * s.dt_s);
    }
    out.heat_channels.push_back(
        fmt::format("{}_{}", kSensorName[search.sensor], kAxisName[static_cast<std::size_t>(axis)]));
    out.heat_t_s = times;
    out.heat_nats.push_back(row);
  }
}

}  // namespace stillpoint::diag
