// The Allan deviations of a sensor and the terms that explain them, drawn log-log (SVG).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/stillpoint/noise_report.h"

namespace stillpoint::app {
namespace {

constexpr double kWidth = 420, kHeight = 340, kLeft = 64, kTop = 30, kWide = 340, kTall = 250;
constexpr std::array<const char*, 3> kColour{"#c0392b", "#27864a", "#2b6cb0"};

/// One sensor's plot: whole decades on both axes.
class Panel {
 public:
  Panel(const SensorNoise& sensor, double left) : sensor_(sensor), left_(left + kLeft) {
    double t0 = 1e300, t1 = 0.0, d0 = 1e300, d1 = 0.0;
    for (const AxisNoise& a : sensor.axes)
      for (const sim::AllanPoint& p : a.points) {
        t0 = std::min(t0, p.tau_s), t1 = std::max(t1, p.tau_s);
        d0 = std::min(d0, p.deviation), d1 = std::max(d1, p.deviation);
      }
    empty_ = t1 <= 0.0;
    if (empty_) return;
    x0_ = std::floor(std::log10(t0)), x1_ = std::max(x0_ + 1.0, std::ceil(std::log10(t1)));
    y0_ = std::floor(std::log10(d0)), y1_ = std::max(y0_ + 1.0, std::ceil(std::log10(d1)));
  }

  [[nodiscard]] std::string svg() const {
    if (empty_) return "";
    std::string out = grid();
    for (std::size_t k = 0; k < sensor_.axes.size(); ++k) out += curve(sensor_.axes[k], k);
    return out;
  }

 private:
  [[nodiscard]] double x(double tau_s) const { return left_ + kWide * (std::log10(tau_s) - x0_) / (x1_ - x0_); }
  /// Held inside the plot.
  [[nodiscard]] double y(double deviation) const {
    const double decade = std::clamp(deviation > 0.0 ? std::log10(deviation) : y0_, y0_, y1_);
    return kTop + kTall * (y1_ - decade) / (y1_ - y0_);
  }

  [[nodiscard]] std::string grid() const {
    std::string out =
        fmt::format("<text x='{}' y='20' font-weight='bold'>{} [{}]: overlapping Allan deviation</text>\n", left_,
                    sensor_.key, sensor_.unit);
    for (double e = x0_; e <= x1_; ++e)
      out +=
          fmt::format("<path d='M{0} {1}V{2}' stroke='#ddd'/><text x='{0}' y='{3}' text-anchor='middle'>1e{4}</text>\n",
                      x(std::pow(10, e)), kTop, kTop + kTall, kTop + kTall + 16, e);
    for (double e = y0_; e <= y1_; ++e)
      out += fmt::format("<path d='M{0} {1}H{2}' stroke='#ddd'/><text x='{3}' y='{4}' text-anchor='end'>1e{5}</text>\n",
                         left_, y(std::pow(10, e)), left_ + kWide, left_ - 6, y(std::pow(10, e)) + 4, e);
    return out + fmt::format("<text x='{}' y='{}' text-anchor='middle'>averaging time, s</text>\n", left_ + kWide / 2,
                             kTop + kTall + 34);
  }

  [[nodiscard]] std::string curve(const AxisNoise& a, std::size_t k) const {
    std::string law, bars;
    for (const sim::AllanPoint& p : a.points) {
      const double half = 1.96 * p.relative_error * p.deviation;
      bars += fmt::format("M{0:.1f} {1:.1f}V{2:.1f}M{3:.1f} {4:.1f}h4", x(p.tau_s), y(p.deviation - half),
                          y(p.deviation + half), x(p.tau_s) - 2, y(p.deviation));
      law += fmt::format("{}{:.1f} {:.1f}", law.empty() ? "M" : "L", x(p.tau_s),
                         y(sim::predicted_deviation(a.terms, p.tau_s)));
    }
    return fmt::format("<path d='{}' stroke='{}'/><path d='{}' stroke='{}' stroke-dasharray='4 3' fill='none'/>\n",
                       bars, kColour[k], law, kColour[k]) +
           fmt::format("<text x='{}' y='{}' fill='{}'>{}</text>\n", left_ + kWide - 40,
                       kTop + 16 + 14 * static_cast<double>(k), kColour[k], a.channel);
  }

  const SensorNoise& sensor_;
  double left_;
  bool empty_ = false;
  double x0_ = 0.0, x1_ = 1.0, y0_ = 0.0, y1_ = 1.0;  ///< decades
};

}  // namespace

std::string noise_figure_svg(const std::vector<SensorNoise>& sensors) {
  std::string panels;
  double left = 0.0;
  for (const SensorNoise& sensor : sensors) {
    panels += Panel(sensor, left).svg();
    left += kWidth;
  }
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{}' height='{}' font-family='sans-serif' font-size='11'>\n"
      "<rect width='100%' height='100%' fill='white'/>\n{}<text x='{}' y='{}'>bars: 95 % confidence; dashed: the "
      "fitted terms</text></svg>\n",
      std::max(left, kWidth), kHeight, panels, kLeft, kHeight - 4);
}

}  // namespace stillpoint::app
