/// Is the reference what it claims to be: body to world, ENU, w first, right-handed, and in time with the sensors?
#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/so3.h"
#include "diagnosis/sanity/sanity.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kAgree_rad = 0.45;   // median angle between measured and predicted specific force
constexpr double kAnswer_rad = 0.35;  // a convention is named when it brings the angle below this
constexpr double kLateness_s = 0.15;  // lags up to this are physics (T1), larger ones are a mix-up
constexpr std::size_t kParts = 4;
constexpr double kPositionStencil_s = 0.06;  // second differences over this long, against the noise of the position

using Convention = std::function<Quat(const Eigen::Vector4d&)>;
struct NamedConvention {
  const char* mistake;
  Convention to_enu;
};

Quat wxyz(const Eigen::Vector4d& q) { return Quat(q[0], q[1], q[2], q[3]).normalized(); }

const std::vector<NamedConvention>& conventions() {
  const Quat ned = Quat(0.0, std::sqrt(0.5), std::sqrt(0.5), 0.0);   // ENU from NED; its own inverse
  const Quat flip_body = Quat(0.0, 1.0, 0.0, 0.0);                   // forward-left-up from forward-right-down
  const Quat z_up = Quat(std::sqrt(0.5), std::sqrt(0.5), 0.0, 0.0);  // z up from y up
  static const std::vector<NamedConvention> list{
      {"", wxyz},
      {"conjugated (world to body instead of body to world)", [](const auto& q) { return wxyz(q).conjugate(); }},
      {"in the order x,y,z,w", [](const auto& q) { return Quat(q[3], q[0], q[1], q[2]).normalized(); }},
      {"in a north-east-down world", [ned](const auto& q) { return ned * wxyz(q); }},
      {"north-east-down to forward-right-down", [=](const auto& q) { return ned * wxyz(q) * flip_body; }},
      {"of a body with y right and z down", [flip_body](const auto& q) { return wxyz(q) * flip_body; }},
      {"in a world with y up", [z_up](const auto& q) { return z_up * wxyz(q); }},
      {"left-handed (one axis mirrored)", [](const auto& q) { return Quat(q[0], -q[1], q[2], -q[3]).normalized(); }},
      {"left-handed (one axis mirrored)", [](const auto& q) { return Quat(q[0], q[1], -q[2], -q[3]).normalized(); }},
      {"left-handed (one axis mirrored)", [](const auto& q) { return Quat(q[0], -q[1], -q[2], q[3]).normalized(); }},
  };
  return list;
}

class Comparison {
 public:
  Comparison(const io::Recording& r, const sim::SimulationConfig& config) : r_(r), config_(config) {
    step_s_ = std::max(r.median_step_s(), 1e-6);
    stencil_ = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kPositionStencil_s / step_s_)));
    stride_ = std::max<std::size_t>(1, r.size() / 4000);
  }

  /// Median angle between measured and predicted specific force; negative when there is nothing to compare.
  [[nodiscard]] double force_angle(const Convention& to_enu) const {
    std::vector<double> angles;
    for (std::size_t i = stencil_; i + stencil_ < r_.size(); i += stride_) {
      Vec3 measured, predicted;
      if (force(i, to_enu, measured, predicted)) angles.push_back(angle(measured, predicted));
    }
    return median(angles);
  }

  /// Share of the measured rate explained by the reference's, 1 - residual/total over the moving rows, in the quarter
  /// of the recording where it is highest: a wrong convention is wrong everywhere, lost samples only after the loss.
  [[nodiscard]] double rate_agreement(const Convention& to_enu) const {
    std::array<double, kParts> residual{}, total{};
    for (std::size_t i = stencil_; i + stencil_ < r_.size(); i += stride_) {
      Vec3 measured, predicted;
      if (!rate(i, to_enu, measured, predicted)) continue;
      const std::size_t part = i * kParts / r_.size();
      residual[part] += (measured - predicted).squaredNorm(), total[part] += measured.squaredNorm();
    }
    double best = -1.0;
    bool any = false;
    for (std::size_t part = 0; part < kParts; ++part)
      if (total[part] > 0) best = std::max(best, 1.0 - residual[part] / total[part]), any = true;
    return any ? best : 1.0;
  }

  bool force(std::size_t i, const Convention& to_enu, Vec3& measured, Vec3& predicted) const {
    const auto* acc = triad(config_, kAcc);
    if (acc == nullptr || r_.acc_mps2.empty() || !r_.acc_mps2[i].allFinite() || !r_.ref_q_world_body[i].allFinite())
      return false;
    measured = acc->matrix * (r_.acc_mps2[i] - acc->bias);
    Vec3 a_world = Vec3::Zero();
    if (!r_.ref_position_m.empty()) {
      const double h = static_cast<double>(stencil_) * step_s_;
      a_world =
          (r_.ref_position_m[i + stencil_] - 2 * r_.ref_position_m[i] + r_.ref_position_m[i - stencil_]) / (h * h);
    }
    // Without a position only moments near 1 g show which way is up.
    if (r_.ref_position_m.empty() && std::abs(measured.norm() / config_.gravity_mps2 - 1.0) > 0.05) return false;
    predicted = to_enu(r_.ref_q_world_body[i]).conjugate() * (a_world + Vec3(0, 0, config_.gravity_mps2));
    return predicted.allFinite();
  }

  bool rate(std::size_t i, const Convention& to_enu, Vec3& measured, Vec3& predicted) const {
    const auto* gyr = triad(config_, kGyr);
    if (gyr == nullptr || r_.gyr_radps.empty() || !r_.gyr_radps[i].allFinite()) return false;
    const auto &before = r_.ref_q_world_body[i - 1], &after = r_.ref_q_world_body[i + 1];
    if (!before.allFinite() || !after.allFinite()) return false;
    measured = gyr->matrix * (r_.gyr_radps[i] - gyr->bias);
    predicted = log_quat(to_enu(before).conjugate() * to_enu(after)) / (r_.t_s(i + 1) - r_.t_s(i - 1));
    return predicted.allFinite() && measured.norm() > 0.2;
  }

  /// Median angle between the measured field and the simulation's; negative when there is none to compare.
  [[nodiscard]] double field_angle() const {
    std::vector<double> angles;
    for (std::size_t i = stencil_; i + stencil_ < r_.size(); i += stride_) {
      Vec3 measured, predicted;
      if (field(i, measured, predicted)) angles.push_back(angle(measured, predicted));
    }
    return median(angles);
  }

  bool field(std::size_t i, Vec3& measured, Vec3& predicted) const {
    const auto* mag = triad(config_, kMag);
    if (mag == nullptr || r_.mag_uT.empty() || !r_.mag_uT[i].allFinite() || !r_.ref_q_world_body[i].allFinite())
      return false;
    measured = mag->matrix * (r_.mag_uT[i] - mag->bias);
    predicted = wxyz(r_.ref_q_world_body[i]).conjugate() * config_.field_world_uT;
    return true;
  }

  static double angle(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }
  static double median(std::vector<double> v) {
    if (v.size() < 20) return -1.0;
    std::nth_element(v.begin(), v.begin() + static_cast<long>(v.size() / 2), v.end());
    return v[v.size() / 2];
  }

  [[nodiscard]] std::size_t first() const { return stencil_; }
  [[nodiscard]] std::size_t stride() const { return stride_; }

 private:
  const io::Recording& r_;
  const sim::SimulationConfig& config_;
  double step_s_ = 0.0;
  std::size_t stencil_ = 1, stride_ = 1;
};

/// Orthogonal map (a reflection allowed) from measured to predicted vectors, in the sense of least squares.
Mat3 best_orthogonal(const Mat3& predicted_measured_T) {
  const Eigen::JacobiSVD<Mat3> svd(predicted_measured_T, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

/// "sensor x is body -y, ..." when the map is nearly a signed permutation other than the identity; empty otherwise.
std::string axes_in_words(const Mat3& Q) {
  std::string words;
  bool identity = true;
  for (int body = 0; body < 3; ++body) {
    int sensor = 0;
    const double size = Q.row(body).cwiseAbs().maxCoeff(&sensor);
    if (size < 0.85) return {};
    const bool minus = Q(body, sensor) < 0;
    identity = identity && sensor == body && !minus;
    words += fmt::format("{}body {} is sensor {}{}", body ? ", " : "", "xyz"[body], minus ? "-" : "+", "xyz"[sensor]);
  }
  return identity ? std::string{} : words;
}

void check_axes(const Comparison& c, const io::Recording& r, Sanity& out) {
  for (const Sensor s : {kAcc, kGyr, kMag}) {
    if (out.unusable[s]) continue;
    Mat3 sum = Mat3::Zero();
    double pm = 0, mm = 0;
    for (std::size_t i = c.first(); i + c.first() < r.size(); i += c.stride()) {
      Vec3 measured, predicted;
      const bool there = s == kAcc   ? c.force(i, wxyz, measured, predicted)
                         : s == kGyr ? c.rate(i, wxyz, measured, predicted)
                                     : c.field(i, measured, predicted);
      if (!there) continue;
      sum += predicted * measured.transpose();
      pm += predicted.norm() * measured.norm(), mm += measured.squaredNorm();
    }
    // A map is determined only where the vectors came from more than one plane.
    const Eigen::JacobiSVD<Mat3> svd(sum);
    if (svd.singularValues()[2] < 0.02 * svd.singularValues()[0] || svd.singularValues().sum() < 0.7 * pm) continue;
    const Mat3 Q = best_orthogonal(sum);
    const std::string words = axes_in_words(Q);
    const double scale = svd.singularValues().sum() / mm;
    if (!words.empty()) {
      out.notices.push_back(fmt::format(
          "{}: agrees with the reference only with other axes ({}){}", kSensorName[s], words,
          Q.isApprox(-Mat3::Identity(), 0.5) && s == kAcc ? ": it gives gravity where specific force is expected"
          : Q.determinant() < 0                           ? ": its axes are left-handed"
                                                          : ""));
      out.unusable[s] = true;
    } else if (s == kGyr && scale > 1.0 / 90 && scale < 1.0 / 35) {
      out.notices.push_back(
          "gyr: 57 times the rate of the reference: the readings look like degrees per second; "
          "name the columns gyr_x_dps ... or convert them");
      out.unusable[s] = true;
    }
  }
}

/// The field as the sensors see it in the world of the reference, against the one of the simulation. A motion-capture
/// world has its own heading, and then no calibration of the body's axes can help.
void check_heading(const Comparison& c, const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  if (out.unusable[kMag]) return;
  Vec3 mean = Vec3::Zero();
  double count = 0;
  for (std::size_t i = c.first(); i + c.first() < r.size(); i += c.stride()) {
    Vec3 measured, predicted;
    if (!c.field(i, measured, predicted)) continue;
    mean += wxyz(r.ref_q_world_body[i]) * measured;
    count += 1;
  }
  if (count < 100) return;
  mean /= count;
  const Vec3& field = config.field_world_uT;
  if (mean.norm() < 0.7 * field.norm() || Comparison::angle(mean, field) < 0.5) return;
  out.notices.push_back(fmt::format(
      "mag: in the world of the reference the field is ({:.1f}, {:.1f}, {:.1f}) uT, {:.0f} degrees from the "
      "simulation's field_world_uT: set that field, or turn the reference to ENU",
      mean.x(), mean.y(), mean.z(), Comparison::angle(mean, field) * 180 / M_PI));
  out.unusable[kMag] = true;
}

/// Time shift that brings the rate of the reference and of the gyro together, where it is too large for a delay.
void check_lateness(const Comparison& c, const io::Recording& r, Sanity& out) {
  const double step_s = r.median_step_s();
  const auto piece = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(0.02 / step_s)));
  std::vector<double> gyro, reference;
  for (std::size_t i = c.first(); i + c.first() + piece < r.size(); i += piece) {
    Vec3 measured = Vec3::Zero(), predicted = Vec3::Zero();
    const bool there = c.rate(i, wxyz, measured, predicted);
    gyro.push_back(there || measured.allFinite() ? measured.norm() : 0.0);
    reference.push_back(predicted.allFinite() ? predicted.norm() : 0.0);
  }
  const auto correlation = [&](long lag) {
    double gr = 0, gg = 0, rr = 0;
    for (long i = 0; i < static_cast<long>(gyro.size()); ++i) {
      const long j = i + lag;
      if (j < 0 || j >= static_cast<long>(gyro.size())) continue;
      const double g = gyro[static_cast<std::size_t>(i)], p = reference[static_cast<std::size_t>(j)];
      gr += g * p, gg += g * g, rr += p * p;
    }
    return gg > 0 && rr > 0 ? gr / std::sqrt(gg * rr) : 0.0;
  };
  const double piece_s = static_cast<double>(piece) * step_s;
  const auto reach = std::min(static_cast<long>(2.0 / piece_s), static_cast<long>(gyro.size() / 4));
  long best = 0;
  double highest = correlation(0);
  const double now = highest;
  for (long lag = -reach; lag <= reach; ++lag)
    if (const double q = correlation(lag); q > highest) highest = q, best = lag;
  const double late_s = static_cast<double>(best) * piece_s;
  if (std::abs(late_s) < kLateness_s || highest < 0.8 || highest < now + 0.1) return;
  out.notices.push_back(fmt::format("reference: it is {:.2f} s {} the sensors; align the clocks before comparing",
                                    std::abs(late_s), late_s > 0 ? "behind" : "ahead of"));
  out.reference_unusable = true;
}

}  // namespace

void check_reference(const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  std::size_t present = 0, off_norm = 0;
  for (const auto& q : r.ref_q_world_body)
    if (q.allFinite()) ++present, off_norm += std::abs(q.norm() - 1.0) > 0.01;
  if (present < 100) {
    out.notices.push_back(
        "reference: present in fewer than 100 rows; the recording is treated as one without a reference");
    out.reference_unusable = true;
    return;
  }
  if (off_norm > present / 20) {
    out.notices.push_back("reference: the quaternions are not of unit length: the four columns are something else");
    out.reference_unusable = true;
    return;
  }
  const Comparison c(r, config);
  const auto fits = [&](const Convention& to_enu, double limit) {
    const double force = out.unusable[kAcc] ? -1.0 : c.force_angle(to_enu);
    const double rate = out.unusable[kGyr] ? 1.0 : c.rate_agreement(to_enu);
    return force < limit && rate > 0.3;
  };
  if (fits(wxyz, kAgree_rad)) {
    check_axes(c, r, out);
    check_heading(c, r, config, out);
    return;
  }
  // Gyro and magnetometer agree with the reference as it is: then it is the accelerometer that is not what it claims.
  const double field = out.unusable[kMag] ? -1.0 : c.field_angle();
  if (field >= 0 && field < kAgree_rad && !out.unusable[kGyr] && c.rate_agreement(wxyz) > 0.8) {
    const auto before = out.notices.size();
    check_axes(c, r, out);
    if (out.notices.size() > before) return;
  }
  check_lateness(c, r, out);
  if (out.reference_unusable) return;
  for (const auto& convention : conventions()) {
    if (*convention.mistake == '\0' || !fits(convention.to_enu, kAnswer_rad)) continue;
    out.notices.push_back(
        fmt::format("reference: the sensors agree with it only if the quaternions are {}; expected are Hamilton "
                    "quaternions, w first, body to world, in ENU",
                    convention.mistake));
    out.reference_unusable = true;
    return;
  }
  const auto before = out.notices.size();
  check_axes(c, r, out);
  if (out.notices.size() > before) return;
  out.notices.push_back(
      "reference: it agrees with the sensors in no usual convention (frame, order, handedness, time): "
      "it is treated as absent");
  out.reference_unusable = true;
}

}  // namespace stillpoint::diag::detail
