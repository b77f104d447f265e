/// What the innovations say of four offsets that may have jumped: two windows, the gyroscope and the accelerometer.
/// (A27) of docs/math/attitude.md, after Willsky and Jones, "A generalized likelihood ratio approach to the detection
/// and estimation of jumps in linear systems" (IEEE Trans. Automatic Control 21, 1976).
#pragma once
#include <array>

#include "core/types.h"

namespace stillpoint::fusion {

/// The likelihood of a jump by three numbers, in information form: J and J times the likeliest jump.
struct JumpEvidence {
  Array9 information{};
  Array3 score{};

  /// One innovation with variance `s`, of which such a jump would have made `dependence` times itself.
  void add(const Eigen::Ref<const Eigen::RowVector3d, 0, Eigen::InnerStride<>>& dependence, double innovation,
           double s) noexcept {
    mat(information) += dependence.transpose() * dependence / s;
    vec(score) += dependence.transpose() * (innovation / s);
  }
};

/// Hypothesis 2 w is a jump of the gyroscope's offset [rad/s] when window w began, 2 w + 1 one of the accelerometer's
/// [m/s^2]; body axes.
constexpr int kJumpWindows = 2, kJumps = 2 * kJumpWindows;

}  // namespace stillpoint::fusion
