// The magnetometer against the accelerometer: dm/dt = -w x m over the turns, (U5), (U6) of docs/math/mount.md.
#include <cmath>

#include "calib_online/offline/mount_ways.h"
#include "core/so3.h"

namespace stillpoint::calib {
namespace {

constexpr double kReadingNoise_uT = 0.5;
constexpr double kLeastDip = 0.15;  // of the sine; nearer to the magnetic equator the field's side is not told
constexpr Eigen::Index kIron = 0, kShape = 3, kGyrShape = 9, kGyrTurn = 15, kUnknowns = 18;

class MagFit {
 public:
  MagFit(const MountEvidence& evidence, const AccMount& acc, const SensorMount& gyr, const MountParams& params)
      : evidence_(evidence), acc_(acc), params_(params), negated_(gyr.R.determinant() < 0.0) {
    R_acc_gyr_ = negated_ ? Mat3(-gyr.R) : gyr.R;
    sd_.resize(kUnknowns);
    sd_ << VecX::Constant(3, params.hard_iron_sd_uT), VecX::Constant(6, params.mag_shape_sd),
        VecX::Constant(6, params.gyr_shape_sd), gyr.covariance.diagonal().cwiseSqrt();
    for (const MountRest& rest : evidence.rests) strength_uT_ += rest.mag_uT.norm();
    strength_uT_ /= static_cast<double>(evidence.rests.size());
  }

  MagMount run() {
    MagMount out;
    const MapSearch found =
        search_maps(sd_, [this](const Mat3& R, const VecX& x, NormalEquations& sums) { add_rows(R, x, sums); });
    const RotationFit& fit = *found.best;
    out.R = fit.R;
    out.covariance = fit.rotation_covariance() * std::max(1.0, fit.excess());
    out.misfit_rad = params_.field_sd * std::sqrt(fit.excess());
    if (fit.rows == 0) {
      out.lack = MountLack::kNoTurn;
      return out;
    }
    out.lack = fit.largest_sd_rad() > params_.open_sd_rad ? MountLack::kOneAxis
               : fit.excess() > kContradictExcess         ? MountLack::kContradiction
               : !found.unique()                          ? MountLack::kAmbiguous
                                                          : MountLack::kNone;
    if (out.known()) judge_sign(fit, out);
    return out;
  }

 private:
  /// (U5) One point of a way against its beginning.
  void add_point(const Preintegrated& way, const Vec3& mag_from_uT, const Vec3& mag_here_uT, const Mat3& R,
                 const VecX& x, NormalEquations& sums) const {
    const AccWay from_here =
        in_acc_axes(way, exp_so3(x.segment<3>(kGyrTurn)) * R_acc_gyr_, Vec6(x.segment<6>(kGyrShape)));
    const Mat3 A = R * (Mat3::Identity() + symmetric(x.segment<6>(kShape)));
    const Vec3 y_from = mag_from_uT - x.segment<3>(kIron), y_here = mag_here_uT - x.segment<3>(kIron);
    const Vec3 w_from = A * y_from, w_here = A * y_here, carried = from_here.R * w_here;
    const Mat3 lever = from_here.R * skew(w_here);
    Eigen::Matrix<double, 3, 3 + kUnknowns> J;
    J << lever - skew(w_from), from_here.R * A - A,
        R * symmetric_times(y_from) - from_here.R * R * symmetric_times(y_here), lever * from_here.d_end_d_shape,
        skew(carried) - lever;
    sums.add(J, w_from - carried, std::pow(params_.field_sd * strength_uT_, 2) + std::pow(kReadingNoise_uT, 2));
  }

  void add_rows(const Mat3& R, const VecX& x, NormalEquations& sums) const {
    for (const MountTurn& turn : evidence_.turns) {
      const MountRest& from = evidence_.rests[turn.from];
      if (!from.has_mag) continue;
      for (const MountWay& point : turn.points)
        if (point.has_mag) add_point(negated_ ? point.negated : point.as_read, from.mag_uT, point.mag_uT, R, x, sums);
      if (turn.whole.has_mag)
        add_point(negated_ ? turn.whole.negated : turn.whole.as_read, from.mag_uT, turn.whole.mag_uT, R, x, sums);
    }
  }

  /// (U6) m and -m turn alike: only the side to which the field dips tells them apart.
  void judge_sign(const RotationFit& fit, MagMount& out) const {
    const Mat3 A = fit.R * (Mat3::Identity() + symmetric(fit.x.segment<6>(kShape)));
    double sum = 0.0;
    int rests = 0;
    for (const MountRest& rest : evidence_.rests) {
      if (!rest.has_mag) continue;
      const Vec3 up = (rest.acc_mps2 - acc_.bias_mps2).normalized();
      sum -= up.dot((A * (rest.mag_uT - fit.x.segment<3>(kIron))).normalized());
      ++rests;
    }
    out.dip_sine = sum / std::max(1, rests);
    if (std::abs(out.dip_sine) < kLeastDip) {
      out.lack = MountLack::kFieldLevel;
    } else if ((out.dip_sine > 0.0) != params_.north.value_or(true)) {
      out.lack = MountLack::kMirrored;
      out.R = -fit.R;
    } else {
      out.mirror_excluded = true;
    }
  }

  const MountEvidence& evidence_;
  const AccMount& acc_;
  const MountParams& params_;
  bool negated_;
  Mat3 R_acc_gyr_;
  VecX sd_;
  double strength_uT_ = 0.0;
};

}  // namespace

MagMount fit_mag_mount(const MountEvidence& evidence, const AccMount& acc, const SensorMount& gyr,
                       const MountParams& params) {
  MagMount out;
  if (!evidence.has_mag) return out;
  if (evidence.rests.empty() || evidence.turns.empty()) {
    out.lack = evidence.rests.empty() ? MountLack::kNoRest : MountLack::kNoTurn;
    return out;
  }
  if (!gyr.known() && gyr.lack != MountLack::kMirrored) {
    out.lack = MountLack::kNoGyroscope;
    return out;
  }
  return MagFit(evidence, acc, gyr, params).run();
}

}  // namespace stillpoint::calib
