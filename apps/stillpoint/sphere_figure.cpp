#include "apps/stillpoint/sphere_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "report/document.h"

namespace stillpoint::app {
namespace {

constexpr double kRadius = 130.0, kTop = 180.0, kLeft = 175.0, kApart = 350.0;

struct Place {
  double x, y;
};

/// Lambert's azimuthal equal-area map of either half, its pole in the middle; x to the right, y up in both.
Place on_disc(const Vec3& u) {
  const double across = std::sqrt(1.0 - std::min(1.0, std::abs(u.z()))), level = std::hypot(u.x(), u.y());
  const double scale = level > 0.0 ? kRadius * across / level : 0.0;
  return {(u.z() < 0.0 ? kLeft + kApart : kLeft) + scale * u.x(), kTop - scale * u.y()};
}

std::string disc(double middle, const char* title) {
  std::string s = fmt::format(
      "<circle cx=\"{0}\" cy=\"{1}\" r=\"{2}\" fill=\"none\" stroke=\"var(--rule)\" stroke-width=\"1.5\"/><text "
      "x=\"{0}\" y=\"14\" text-anchor=\"middle\">{3}</text>",
      middle, kTop, kRadius, title);
  // 30 and 60 degrees from the pole.
  for (const double level : {std::cos(std::numbers::pi / 6), std::cos(std::numbers::pi / 3)})
    s += fmt::format("<circle class=\"line\" cx=\"{}\" cy=\"{}\" r=\"{:.1f}\" fill=\"none\" stroke-dasharray=\"2 4\"/>",
                     middle, kTop, kRadius * std::sqrt(1.0 - level));
  const std::array<std::pair<const char*, Place>, 4> faces{{{"+x", {middle + kRadius + 6, kTop + 4}},
                                                            {"-x", {middle - kRadius - 22, kTop + 4}},
                                                            {"+y", {middle - 7, kTop - kRadius - 6}},
                                                            {"-y", {middle - 7, kTop + kRadius + 16}}}};
  for (const auto& [name, at] : faces)
    s += fmt::format("<text class=\"quiet\" x=\"{}\" y=\"{}\">{}</text>", at.x, at.y, name);
  return s;
}

}  // namespace

std::string sphere_svg(const std::vector<MarkedDirection>& directions) {
  std::string s = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"directions on the sphere\">",
                              2 * kLeft + kApart, 2 * kTop);
  s += disc(kLeft, "z up") + disc(kLeft + kApart, "z down");
  for (const MarkedDirection& d : directions) {
    const Place at = on_disc(d.direction);
    s += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"var(--before)\" fill-opacity=\"{:.2f}\" "
        "stroke=\"var(--after)\"><title>{}</title></circle>",
        at.x, at.y, std::clamp(d.share, 0.0, 1.0), report::escaped(d.tip));
  }
  return s + "</svg>";
}

}  // namespace stillpoint::app
