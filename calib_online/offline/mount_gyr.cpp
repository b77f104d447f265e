// The gyroscope against the accelerometer: gravity carried over the turns, (U3), (U4) of docs/math/mount.md.
#include <cmath>

#include "calib_online/offline/mount_ways.h"
#include "core/so3.h"

namespace stillpoint::calib {
namespace {

constexpr double kBiasChange_radps = 1e-4;             // within the seconds of a turn
constexpr double kContradict_rad = 10.0 * kRadPerDeg;  // between rests; the rough readings on the way would hide it
constexpr double kContradictSd = 6.0;                  // so far from its prior no scale and no bias lies

}  // namespace

SensorMount fit_gyr_mount(const MountEvidence& evidence, const AccMount& acc, const MountParams& params) {
  SensorMount out;
  if (!evidence.has_gyr) return out;
  out.lack = evidence.rests.empty() ? MountLack::kNoRest : MountLack::kNoTurn;
  if (evidence.turns.empty()) return out;
  VecX sd(9);
  sd << VecX::Constant(3, acc.bias_sd_mps2 > 0.0 ? acc.bias_sd_mps2 : params.acc_bias_sd_mps2),
      VecX::Constant(6, params.gyr_shape_sd);
  // (U3) At rest gravity is read well; on the way roughly, but only there a quarter turn shows all of its axis.
  const auto add_point = [&](const MountRest& from, const MountWay& here, double read_var, bool negated,
                             const Mat3& R_acc_gyr, const VecX& x, NormalEquations& sums) {
    const AccWay way = in_acc_axes(negated ? here.negated : here.as_read, R_acc_gyr, Vec6(x.tail<6>()));
    const Vec3 bias = acc.bias_mps2 + x.head<3>();
    const Vec3 f_from = from.acc_mps2 - bias, f_here = here.acc_mps2 - bias;
    const Vec3 up_from = f_from.normalized(), up_here = f_here.normalized();
    const Vec3 carried = way.R * up_here;
    const Mat3 lever = way.R * skew(up_here);
    Eigen::Matrix<double, 3, 12> J;
    J << skew(carried) - lever,
        way.R * (Mat3::Identity() - up_here * up_here.transpose()) / f_here.norm() -
            (Mat3::Identity() - up_from * up_from.transpose()) / f_from.norm(),
        lever * way.d_end_d_shape;
    const double variance = 2.0 * std::pow(params.acc_shape_sd, 2) + from.acc_var / f_from.squaredNorm() + read_var +
                            std::pow(params.gyr_way_sd_rad, 2) + std::pow(kBiasChange_radps * here.duration_s, 2);
    sums.add(J, up_from - carried, variance, 2);
  };
  const auto residuals = [&](bool negated) -> Residuals {
    return [&, negated](const Mat3& R_acc_gyr, const VecX& x, NormalEquations& sums) {
      for (const MountTurn& turn : evidence.turns) {
        const MountRest& from = evidence.rests[turn.from];
        const MountRest& to = evidence.rests[turn.to];
        add_point(from, turn.whole, to.acc_var / to.acc_mps2.squaredNorm(), negated, R_acc_gyr, x, sums);
        for (const MountWay& point : turn.points)
          add_point(from, point, std::pow(params.motion_sd, 2), negated, R_acc_gyr, x, sums);
      }
    };
  };
  const MapSearch as_read = search_maps(sd, residuals(false)), negated = search_maps(sd, residuals(true));
  const double margin = negated.best->chi2 - as_read.best->chi2;
  const double worth = kRivalChi2 * std::max(1.0, std::min(negated.best->excess(), as_read.best->excess()));
  const bool mirrored = margin < -worth;
  const MapSearch& found = mirrored ? negated : as_read;
  out.mirror_excluded = margin > worth;
  out.R = mirrored ? Mat3(-found.best->R) : found.best->R;
  out.covariance = found.best->rotation_covariance() * std::max(1.0, found.best->excess());
  double off2 = 0.0;
  for (const MountTurn& turn : evidence.turns) {
    const AccWay way =
        in_acc_axes(mirrored ? turn.whole.negated : turn.whole.as_read, found.best->R, Vec6(found.best->x.tail<6>()));
    const auto up = [&](std::size_t rest) { return (evidence.rests[rest].acc_mps2 - acc.bias_mps2).normalized(); };
    off2 += (up(turn.from) - way.R * up(turn.to)).squaredNorm();
  }
  out.misfit_rad = std::sqrt(off2 / static_cast<double>(evidence.turns.size()));
  const bool contradiction = found.best->excess() > kContradictExcess || out.misfit_rad > kContradict_rad ||
                             found.best->x.cwiseQuotient(sd).cwiseAbs().maxCoeff() > kContradictSd;
  out.lack = found.best->largest_sd_rad() > params.open_sd_rad ? MountLack::kOneAxis
             : contradiction                                   ? MountLack::kContradiction
             : !found.unique()                                 ? MountLack::kAmbiguous
             : mirrored                                        ? MountLack::kMirrored
                                                               : MountLack::kNone;
  return out;
}

}  // namespace stillpoint::calib
