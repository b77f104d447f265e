#include "apps/stillpoint/estimate_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "apps/stillpoint/attitude_file.h"
#include "apps/stillpoint/live_words.h"
#include "core/so3.h"
#include "report/document.h"

namespace stillpoint::app {
namespace {

using report::Colour;
using report::escaped;
using report::Mark;
using report::Plot;

constexpr double kAnyHeading_deg = 90.0;  ///< stated so wide a heading is not known at all
constexpr double kTiltBound = 3.44;       ///< of a chi of two at the probability of three deviations of one

/// Of the moments that have a reference.
struct AgainstReference {
  std::size_t moments = 0, headings = 0;  ///< a relative heading is none
  double tilt_rms_rad = 0.0, heading_rms_rad = 0.0;
  double tilt_inside = 0.0, heading_inside = 0.0;  ///< shares within what was stated
};

double tilt_sd_rad(const fusion::AttitudeEstimate& e) {
  return std::sqrt(0.5 * (e.sigma_roll_rad * e.sigma_roll_rad + e.sigma_pitch_rad * e.sigma_pitch_rad));
}

AgainstReference against_reference(const std::vector<CoursePoint>& course) {
  AgainstReference out;
  for (const CoursePoint& p : course) {
    if (!p.off_rad) continue;
    const double tilt = p.off_rad->head<2>().norm(), heading = std::abs(p.off_rad->z());
    ++out.moments;
    out.tilt_rms_rad += tilt * tilt;
    out.tilt_inside += tilt < kTiltBound * tilt_sd_rad(p.attitude);
    if (std::isnan(heading)) continue;
    ++out.headings;
    out.heading_rms_rad += heading * heading;
    out.heading_inside += heading < 3.0 * p.attitude.sigma_yaw_rad;
  }
  const double n = std::max<double>(1.0, static_cast<double>(out.moments));
  const double h = std::max<double>(1.0, static_cast<double>(out.headings));
  out.tilt_rms_rad = std::sqrt(out.tilt_rms_rad / n);
  out.heading_rms_rad = std::sqrt(out.heading_rms_rad / h);
  out.tilt_inside /= n;
  out.heading_inside /= h;
  return out;
}

std::string file_name(const std::string& path) { return escaped(std::filesystem::path(path).filename().string()); }

/// "1.60° (100.0 %)": rms, and the share inside what was stated.
std::string cell(std::size_t moments, double rms_rad, double inside) {
  return moments == 0 ? "" : fmt::format("{:.2f}° ({:.1f} %)", kDegPerRad * rms_rad, 100.0 * inside);
}

Plot angles(const std::vector<CoursePoint>& course, const std::string& id) {
  Plot p{id, "time, s", "roll, pitch, yaw, °", {}, {}};
  p.curves = {{"roll", Colour::kBefore, {}, Mark::kLine},
              {"pitch", Colour::kAfter, {}, Mark::kLine},
              {"yaw", Colour::kAccent, {}, Mark::kDots}};  // dots: it jumps from +180 to -180
  for (const CoursePoint& moment : course) {
    const auto& q = moment.attitude.q_world_body;
    const Vec3 rpy = kDegPerRad * roll_pitch_yaw({q[1], q[2], q[3], q[0]});
    p.x.push_back(moment.t_s);
    for (std::size_t k = 0; k < 3; ++k) p.curves[k].y.push_back(rpy[static_cast<Eigen::Index>(k)]);
    p.shaded.push_back(moment.status != AttitudeStatus::kOk);
  }
  return p;
}

Plot deviations(const std::vector<CoursePoint>& course, const std::string& id) {
  Plot p{id, "time, s", "standard deviation, °", {}, {}};
  p.curves = {{"tilt", Colour::kAfter, {}, Mark::kBold}, {"yaw", Colour::kAccent, {}, Mark::kBold}};
  p.log_y = true;
  for (const CoursePoint& moment : course) {
    p.x.push_back(moment.t_s);
    p.curves[0].y.push_back(kDegPerRad * tilt_sd_rad(moment.attitude));
    p.curves[1].y.push_back(kDegPerRad * moment.attitude.sigma_yaw_rad);
  }
  return p;
}

Plot heading_error(const std::vector<CoursePoint>& course, const std::string& id) {
  Plot p{id, "time, s", "heading error, °", {}, {}};
  p.curves = {{"error", Colour::kBefore, {}, Mark::kDots},
              {"3 deviations: from", Colour::kNoise, {}, Mark::kDashed},
              {"to", Colour::kNoise, {}, Mark::kDashed}};
  for (const CoursePoint& moment : course) {
    const double stated = 3.0 * kDegPerRad * moment.attitude.sigma_yaw_rad;
    const double bound = stated < kAnyHeading_deg ? stated : std::numeric_limits<double>::quiet_NaN();
    p.x.push_back(moment.t_s);
    p.curves[0].y.push_back(moment.off_rad ? kDegPerRad * moment.off_rad->z()
                                           : std::numeric_limits<double>::quiet_NaN());
    p.curves[1].y.push_back(-bound);
    p.curves[2].y.push_back(bound);
  }
  return p;
}

Plot tilt_error(const std::vector<CoursePoint>& course, const std::string& id) {
  Plot p{id, "time, s", "tilt error, °", {}, {}};
  p.curves = {{"error", Colour::kBefore, {}, Mark::kDots}, {"what is stated", Colour::kNoise, {}, Mark::kDashed}};
  for (const CoursePoint& moment : course) {
    p.x.push_back(moment.t_s);
    p.curves[0].y.push_back(moment.off_rad ? kDegPerRad * moment.off_rad->head<2>().norm()
                                           : std::numeric_limits<double>::quiet_NaN());
    p.curves[1].y.push_back(kDegPerRad * kTiltBound * tilt_sd_rad(moment.attitude));
  }
  return p;
}

std::string table_row(const EstimateRequest& request, const Estimated& e, const AgainstReference& r) {
  const auto& b = e.calibration.gyr.bias;
  return fmt::format(
      "<tr><td>{}</td><td class=\"n\">{:.1f}</td><td class=\"n\">{:.1f} %</td><td class=\"n\">{}</td><td "
      "class=\"n\">{}</td><td class=\"n\">{:.3f} {:.3f} {:.3f}</td><td>{}</td><td class=\"n\">{}</td><td "
      "class=\"n\">{}</td></tr>",
      file_name(request.recording), e.duration_s,
      100.0 * static_cast<double>(e.degraded_rows) / static_cast<double>(std::max<std::size_t>(e.rows, 1)),
      e.guard.gaps, e.rest_windows, b[0] * kDegPerRad, b[1] * kDegPerRad, b[2] * kDegPerRad, health_of(e.health),
      cell(r.moments, r.tilt_rms_rad, r.tilt_inside), cell(r.headings, r.heading_rms_rad, r.heading_inside));
}

}  // namespace

std::string estimates_html(const std::vector<EstimateRequest>& requests,
                           const std::vector<Result<Estimated>>& estimated) {
  const auto whole =
      static_cast<std::size_t>(std::count_if(estimated.begin(), estimated.end(), [](const auto& e) { return !!e; }));
  std::string s = fmt::format(
      "<div class=\"verdict\"><div class=\"label\">Attitude{}</div><h1>{} of {} recordings estimated</h1></div>",
      !requests.empty() && requests.front().smooth ? ", smoothed" : "", whole, estimated.size());
  s += "<p class=\"how\">Errors against the reference are rms, with the share of time inside what was stated.</p><div "
       "class=\"wide\"><table><tr><th>recording</th><th class=\"n\">seconds</th><th class=\"n\">not ok</th><th "
       "class=\"n\">gaps</th><th class=\"n\">rests</th><th class=\"n\">gyroscope bias, °/s</th><th>health at the "
       "end</th><th class=\"n\">tilt error</th><th class=\"n\">heading error</th></tr>";
  std::string figures;
  std::vector<Plot> plots;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (!estimated[i]) {
      s += fmt::format("<tr><td>{}</td><td colspan=\"8\"><b>failed</b>: {}</td></tr>", file_name(requests[i].recording),
                       escaped(estimated[i].error().message));
      continue;
    }
    const Estimated& e = *estimated[i];
    const AgainstReference reference = against_reference(e.course);
    s += table_row(requests[i], e, reference);
    figures += fmt::format("<h2>{}</h2><div class=\"figures\">", file_name(requests[i].recording));
    const auto add = [&](Plot plot, const char* title, const char* how) {
      figures += report::figure_html(plot.id, title, how);
      plots.push_back(std::move(plot));
    };
    add(angles(e.course, fmt::format("angles-{}", i)), "Attitude",
        "Roll, pitch and yaw; shaded where the status is not ok.");
    add(deviations(e.course, fmt::format("deviations-{}", i)), "What is stated",
        "The standard deviations of tilt (mean of both axes) and yaw.");
    if (reference.moments > 0) {
      add(heading_error(e.course, fmt::format("heading-{}", i)), "Heading against the reference",
          "The dots have to stay between the dashed lines; where there are none, any heading was possible. A reference "
          "whose north is another one shows as a constant.");
      add(tilt_error(e.course, fmt::format("tilt-{}", i)), "Tilt against the reference",
          "The dots have to stay below the dashed line, which holds them as often as three deviations hold one axis.");
    }
    figures += "</div>";
  }
  return report::document_html("Attitude", s + "</table></div>" + figures, plots);
}

}  // namespace stillpoint::app
