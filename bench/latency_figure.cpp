/// The percentile figure of bench/latency as one SVG.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bench/latency_report.h"

namespace stillpoint::bench {
namespace {

constexpr double kPanelWidth = 620, kPanelHeight = 300, kLeft = 70, kTop = 44, kRight = 190, kBottom = 46;
constexpr double kDecades = 4;  // of 1/(1 - p): up to 99.99 %
constexpr double kLowest_us = 1, kHighest_us = 100'000;

// Hue names the transport (Okabe and Ito's palette, told apart by the colour-blind), dashes the floor of Fast DDS
// alone.
const char* colour(const std::string& channel) {
  if (channel == "shm_futex") return "#000000";
  if (channel == "udp_socket") return "#888888";
  if (channel.ends_with("/udp")) return "#0072b2";
  if (channel.ends_with("/shm")) return "#d55e00";
  return "#009e73";
}

double x_of(double p) {
  return kLeft + kPanelWidth * std::min(-std::log10(std::max(1 - p, 1e-9)), kDecades) / kDecades;
}
double y_of(double us, double top) {
  const double share = (std::log10(std::clamp(us, kLowest_us, kHighest_us)) - std::log10(kLowest_us)) /
                       (std::log10(kHighest_us) - std::log10(kLowest_us));
  return top + kPanelHeight * (1 - share);
}

std::string curve(const Series& s, double top) {
  std::string points;
  const std::size_t n = s.sorted_us.size();
  double last_x = -1;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = x_of((static_cast<double>(i) + 0.5) / static_cast<double>(n));
    if (x - last_x < 1) continue;  // a point a pixel
    last_x = x;
    points += fmt::format("{:.1f},{:.1f} ", x, y_of(s.sorted_us[i], top));
  }
  return fmt::format("<polyline fill='none' stroke='{}' stroke-width='1.8'{} points='{}'/>\n", colour(s.channel),
                     s.channel.starts_with("fastdds/") ? " stroke-dasharray='5 3'" : "", points);
}

std::string axes(double top, double rate_hz) {
  std::string out = fmt::format("<text x='{}' y='{}' font-weight='bold'>{:.0f} Hz</text>\n", kLeft, top - 10, rate_hz);
  for (double us = kLowest_us; us <= kHighest_us * 1.01; us *= 10)
    out += fmt::format(
        "<line x1='{0}' x2='{1}' y1='{2:.1f}' y2='{2:.1f}' stroke='#ddd'/><text x='{3}' y='{4:.1f}' "
        "text-anchor='end'>{5:g} us</text>\n",
        kLeft, kLeft + kPanelWidth, y_of(us, top), kLeft - 6, y_of(us, top) + 4, us);
  for (const double p : {0.0, 0.5, 0.9, 0.99, 0.999, 0.9999})
    out += fmt::format(
        "<line x1='{0:.1f}' x2='{0:.1f}' y1='{1}' y2='{2}' stroke='#ddd'/><text x='{0:.1f}' y='{3}' "
        "text-anchor='middle'>{4:g} %</text>\n",
        x_of(p), top, top + kPanelHeight, top + kPanelHeight + 16, 100 * p);
  return out;
}

}  // namespace

std::string svg(const LatencyReport& report) {
  std::set<double> rates;
  for (const Series& s : report.series) rates.insert(s.rate_hz);
  const double width = kLeft + kPanelWidth + kRight;
  const double height = static_cast<double>(rates.size()) * (kTop + kPanelHeight + kBottom) + 30;
  std::string out = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0:.0f}' height='{1:.0f}' viewBox='0 0 {0:.0f} {1:.0f}' "
      "font-family='sans-serif' font-size='12'>\n<rect width='100%' height='100%' fill='white'/>\n"
      "<text x='{2}' y='20'>Latency over percentile: instant a sample was due to the callback in another "
      "process</text>\n",
      width, height, kLeft);
  double top = 30 + kTop;
  for (const double rate_hz : rates) {
    out += axes(top, rate_hz);
    double legend_y = top + 12;
    for (const Series& s : report.series) {
      if (s.rate_hz != rate_hz) continue;
      out += curve(s, top);
      out += fmt::format(
          "<line x1='{0}' x2='{1}' y1='{2}' y2='{2}' stroke='{3}' stroke-width='2'{4}/><text x='{5}' "
          "y='{6}'>{7}</text>\n",
          kLeft + kPanelWidth + 14, kLeft + kPanelWidth + 38, legend_y - 4, colour(s.channel),
          s.channel.starts_with("fastdds/") ? " stroke-dasharray='5 3'" : "", kLeft + kPanelWidth + 44, legend_y,
          s.channel);
      legend_y += 18;
    }
    top += kTop + kPanelHeight + kBottom;
  }
  return out + "</svg>\n";
}

}  // namespace stillpoint::bench
