// The accelerometer on the body: (U1), (U2) of docs/math/mount.md.
#include <algorithm>
#include <cmath>

#include "calib_online/offline/mount_fit.h"
#include "calib_online/offline/rotation_fit.h"
#include "core/directions.h"
#include "core/so3.h"

namespace stillpoint::calib {
namespace {

/// (U1) The orthogonal matrix of determinant `sign` that takes the rests' directions nearest to their faces.
Mat3 wahba(const std::vector<Vec3>& faces, const std::vector<Vec3>& up, double sign) {
  Mat3 B = Mat3::Zero();
  for (std::size_t i = 0; i < faces.size(); ++i) B += faces[i] * up[i].transpose();
  return nearest_orthogonal(B, sign);
}

class AccFit {
 public:
  AccFit(const MountEvidence& evidence, const MountParams& params) : evidence_(evidence), params_(params) {
    for (const MountRest& rest : evidence.rests) up_.push_back(rest.acc_mps2.normalized());
    out_.poses.resize(up_.size());
  }

  AccMount run() {
    if (up_.empty()) return lacking(MountLack::kNoRest);
    if (!give_stated_faces()) return lacking(MountLack::kOnePose);
    out_.R = start(1.0);
    if (mirrored()) return lacking(MountLack::kMirrored);
    refine();
    recognise_further_faces();
    refine();
    for (std::size_t i = 0; i < up_.size(); ++i)
      if (out_.poses[i].face) out_.poses[i].off_rad = angle_rad(*out_.poses[i].face, out_.R * corrected(i));
    out_.lack = MountLack::kNone;
    return out_;
  }

 private:
  AccMount lacking(MountLack lack) {
    out_.lack = lack;
    return out_;
  }
  [[nodiscard]] bool alike(const Vec3& a, const Vec3& b) const { return angle_rad(a, b) < params_.alike_rad; }
  [[nodiscard]] Vec3 corrected(std::size_t i) const {
    return (evidence_.rests[i].acc_mps2 - out_.bias_mps2).normalized();
  }

  /// Each stated face to the next rest that differs from the one before. False when the poses leave a rotation open.
  bool give_stated_faces() {
    std::size_t given = 0, last = 0;
    for (std::size_t i = 0; i < up_.size() && given < params_.faces.size(); ++i) {
      if (given > 0 && alike(up_[i], up_[last])) continue;
      out_.poses[i].face = params_.faces[given++];
      out_.poses[i].stated = true;
      last = i;
    }
    const double right_angle_gate_rad = 3.0 * kRadPerDeg + 4.0 * std::sqrt(2.0) * params_.pose_sd_rad;
    bool two = false;
    for (std::size_t i = 1; i < up_.size(); ++i) {
      RestPose& pose = out_.poses[i];
      if (!pose.face) continue;
      const double stated_rad = angle_rad(params_.faces[0], *pose.face), seen_rad = angle_rad(up_[0], up_[i]);
      const bool as_stated = std::abs(seen_rad - stated_rad) <= right_angle_gate_rad;
      if (std::sin(stated_rad) > 0.5) {
        const bool tipped = !alike(up_[0], up_[i]) && !alike(-up_[0], up_[i]);
        pose.direction_only = !as_stated;
        two = two || tipped;
        if (!tipped) pose = {};
      } else if (!as_stated) {
        pose = {};
      }
    }
    return two;
  }

  /// The face, or where it would be had the body been tipped by a right angle.
  [[nodiscard]] Vec3 wanted(std::size_t i) const {
    const RestPose& pose = out_.poses[i];
    if (!pose.direction_only) return *pose.face;
    const double seen_rad = angle_rad(up_[0], up_[i]);
    return std::cos(seen_rad) * params_.faces[0] + std::sin(seen_rad) * *pose.face;
  }

  [[nodiscard]] Mat3 start(double sign) const {
    std::vector<Vec3> faces, up;
    for (std::size_t i = 0; i < up_.size(); ++i)
      if (out_.poses[i].face) faces.push_back(wanted(i)), up.push_back(up_[i]);
    return wahba(faces, up, sign);
  }

  /// Two faces never show it; three that are stated do.
  bool mirrored() {
    Mat3 faces = Mat3::Zero();
    for (const RestPose& pose : out_.poses)
      if (pose.face) faces += *pose.face * pose.face->transpose();
    if (faces.determinant() < 0.25) return false;
    const Mat3 other = start(-1.0);
    double as_is = 0.0, as_mirror = 0.0;
    for (std::size_t i = 0; i < up_.size(); ++i)
      if (out_.poses[i].face) {
        as_is += (wanted(i) - out_.R * up_[i]).squaredNorm();
        as_mirror += (wanted(i) - other * up_[i]).squaredNorm();
      }
    out_.mirror_excluded = as_is < as_mirror;
    if (!out_.mirror_excluded) out_.R = other;
    return !out_.mirror_excluded;
  }

  void recognise_further_faces() {
    for (std::size_t i = 0; i < up_.size(); ++i) {
      if (out_.poses[i].face) continue;
      const Vec3 up_body = out_.R * corrected(i);
      Eigen::Index axis = 0;
      up_body.cwiseAbs().maxCoeff(&axis);
      const Vec3 face = std::copysign(1.0, up_body[axis]) * Vec3::Unit(axis);
      if (angle_rad(face, up_body) < params_.face_rad) out_.poses[i].face = face;
    }
  }

  /// (U2) With the accelerometer's bias beside the rotation.
  void refine() {
    const auto residuals = [this](const Mat3& R, const VecX& bias, NormalEquations& sums) {
      for (std::size_t i = 0; i < up_.size(); ++i) {
        const RestPose& pose = out_.poses[i];
        if (!pose.face) continue;
        const Vec3 f = evidence_.rests[i].acc_mps2 - bias, u = f.normalized(), face = wanted(i);
        Eigen::Matrix<double, 3, 6> J;
        J << skew(R * u), R * (Mat3::Identity() - u * u.transpose()) / f.norm();
        const Vec3 across = params_.faces[0].cross(*pose.face);
        const Mat3 seen = pose.direction_only ? Mat3(across * across.transpose() / across.squaredNorm())
                                              : Mat3(Mat3::Identity() - face * face.transpose());
        const double variance = std::pow(params_.pose_sd_rad, 2) + std::pow(params_.acc_shape_sd, 2) +
                                evidence_.rests[i].acc_var / f.squaredNorm();
        sums.add(seen * J, seen * (face - R * u), variance, pose.direction_only ? 1 : 2);
      }
    };
    const RotationFit fit = fit_rotation(out_.R, VecX::Constant(3, params_.acc_bias_sd_mps2), residuals);
    out_.R = fit.R;
    out_.covariance = fit.rotation_covariance() * std::max(1.0, fit.excess());
    out_.bias_mps2 = fit.x;
    out_.bias_sd_mps2 = std::sqrt(fit.covariance.bottomRightCorner<3, 3>().trace() / 3.0);
    out_.misfit_rad = params_.pose_sd_rad * std::sqrt(fit.excess());
  }

  const MountEvidence& evidence_;
  const MountParams& params_;
  std::vector<Vec3> up_;
  AccMount out_;
};

}  // namespace

AccMount fit_acc_mount(const MountEvidence& evidence, const MountParams& params) {
  return AccFit(evidence, params).run();
}

}  // namespace stillpoint::calib
