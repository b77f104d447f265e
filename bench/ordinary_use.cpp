#include "bench/ordinary_use.h"

#include <numbers>

namespace stillpoint::bench {
namespace {

constexpr double kRate_hz = 50.0;
constexpr double kDt_s = 1.0 / kRate_hz;
constexpr double kAccNoise_mps2 = 0.02, kGyrNoise_radps = 0.001, kMagNoise_uT = 0.3;
const Vec3 kField_uT(0.0, 20.0, -43.0);

Vec3 diagonal_of(const Array9& covariance) {
  return Vec3(covariance[0], covariance[4], covariance[8]).cwiseMax(0.0).cwiseSqrt();
}

}  // namespace

UsedSensor::UsedSensor(Random& random) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) {
      const double off = random.normal(i == j ? 0.006 : 0.003);
      H_acc(i, j) += off;
      if (i != j) H_acc(j, i) += off;  // a rotation of the accelerometer is not visible in its norm
    }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) H_gyr(i, j) += random.normal(i == j ? 0.015 : 0.01);
  b_acc_mps2 = random.normal3(0.2);
  b_gyr_radps = random.normal3(0.5 * kRadPerDeg);
}

OrdinaryUse::OrdinaryUse(unsigned seed, bool has_mag)
    : random_(seed), sensor_(random_), has_mag_(has_mag), calibrator_({}, CalibrationSnapshot{}) {
  q_world_body_ = random_.rotation();
}

Vec3 OrdinaryUse::acc_bias_mps2() const {
  return sensor_.b_acc_mps2 + (surroundings_.temp_degC(t_s_) - Surroundings::kTold_degC) * sensor_.b_acc_mps2_per_K;
}

Vec3 OrdinaryUse::gyr_bias_radps() const {
  return sensor_.b_gyr_radps + (surroundings_.temp_degC(t_s_) - Surroundings::kTold_degC) * sensor_.b_gyr_radps_per_K;
}

void OrdinaryUse::step(const Vec3& rate_body_radps) {
  const Mat3 R_body_world = q_world_body_.toRotationMatrix().transpose();
  const Vec3 rate = rate_body_radps + R_body_world * Vec3(0, 0, surroundings_.vertical_rate_radps);
  const Vec3 force = R_body_world * (Vec3(0, 0, kStandardGravity_mps2) + surroundings_.force_mps2(t_s_));
  const double phase = 2.0 * std::numbers::pi * 29.0 * t_s_;
  const Vec3 shaken = surroundings_.shaking_mps2 * Vec3(std::sin(phase), std::sin(phase + 1.0), std::cos(phase));
  RawSample s;
  s.t_ns = static_cast<std::int64_t>(std::llround(t_s_ * 1e9));
  s.has = static_cast<std::uint8_t>(kAcc | kGyr | kTemp | (has_mag_ ? kMag : 0));
  const double limit = sensor_.acc_limit_mps2;
  const auto on_lattice = [](const Vec3& v, double step) {
    return step > 0.0 ? Vec3(step * (v / step).array().round()) : v;
  };
  const Vec3 acc = sensor_.H_acc.inverse() * (force + shaken) + acc_bias_mps2() + random_.normal3(kAccNoise_mps2);
  s.acc_mps2 = array(Vec3(on_lattice(acc, sensor_.acc_lattice_mps2).cwiseMax(-limit).cwiseMin(limit)));
  const Vec3 gyr = sensor_.H_gyr.inverse() * rate + gyr_bias_radps() + random_.normal3(kGyrNoise_radps);
  s.gyr_radps = array(on_lattice(gyr, sensor_.gyr_lattice_radps));
  s.mag_uT = array(Vec3(R_body_world * kField_uT + random_.normal3(kMagNoise_uT)));
  s.temp_degC = Surroundings::kTold_degC;
  if (const auto window = detector_.push(s, calibrator_.snapshot())) calibrator_.absorb(*window);
  if (const auto turn = turns_.push(s, 0, calibrator_.snapshot(), {})) calibrator_.absorb(*turn);
  q_world_body_ = (q_world_body_ * exp_quat(Vec3(kDt_s * rate))).normalized();
  t_s_ += kDt_s;
}

void OrdinaryUse::rest(double seconds) {
  for (double s = 0.0; s < seconds; s += kDt_s) step(Vec3::Zero());
}

void OrdinaryUse::turn() {
  const Vec3 rate = 1.2 * random_.direction();
  const double seconds = random_.uniform(0.8, 1.8);
  for (double s = 0.0; s < seconds; s += kDt_s) step(rate);
}

void OrdinaryUse::handle(int attitudes) {
  for (int k = 0; k < attitudes; ++k) {
    turn();
    rest(random_.uniform(4.6, 7.0));
  }
}

void OrdinaryUse::tilt(const Vec3& axis_world, double angle_rad, double seconds) {
  for (double s = 0.0; s < seconds; s += kDt_s)
    step(q_world_body_.conjugate() * Vec3(axis_world * (angle_rad / seconds)));
}

std::map<std::string, OrdinaryUse::Judgement> OrdinaryUse::judge() const {
  const CalibrationSnapshot& c = calibrator_.snapshot();
  std::map<std::string, Judgement> out;
  const auto add_bias = [&out](const char* name, const Vec3& error, const TriadCalibration& t, double unit) {
    const Vec3 sd = diagonal_of(t.bias_covariance);
    for (int k = 0; k < 3; ++k) {
      out[name].error.push_back(error[k] * unit);
      out[name].stated.push_back(sd[k] * unit);
    }
  };
  add_bias("acc bias, m/s2", c.acc.bias_at(Surroundings::kTold_degC) - acc_bias_mps2(), c.acc, 1.0);
  add_bias("gyr bias, deg/s", c.gyr.bias_at(Surroundings::kTold_degC) - gyr_bias_radps(), c.gyr, kDegPerRad);
  double sq = 0.0;
  const auto directions = even_directions(60);
  for (const Vec3& u : directions) {
    const Vec3 y = sensor_.H_acc.inverse() * (kStandardGravity_mps2 * u) + acc_bias_mps2();
    sq += std::pow(c.acc.apply(array(y), Surroundings::kTold_degC).norm() - kStandardGravity_mps2, 2) / 60.0;
  }
  out["acc norm, m/s2"] = {{std::sqrt(sq)}, {c.acc.norm_sd}};
  out["gyr matrix"] = {{(mat(c.gyr.matrix) - sensor_.H_gyr).norm() / 3.0}, {calibrator_.state().gyr_matrix_sd}};
  return out;
}

std::map<std::string, UseScore> score(const UseCase& use, unsigned first_seed, unsigned seeds) {
  std::map<std::string, UseScore> out;
  for (unsigned seed = first_seed; seed < first_seed + seeds; ++seed) {
    OrdinaryUse life(seed, use.has_mag);
    std::map<std::string, OrdinaryUse::Judgement> last;
    use.live(life, [&] {
      last = life.judge();
      for (const auto& [name, j] : last) {
        UseScore& s = out[name];
        for (std::size_t k = 0; k < j.error.size(); ++k) {
          ++s.judged;
          if (!(j.stated[k] > 0.0)) continue;  // nothing is stated
          ++s.stated_at_all;
          s.inside_percent += std::abs(j.error[k]) > 3.0 * j.stated[k] ? -1.0 : 0.0;
        }
      }
    });
    for (const auto& [name, j] : last) {
      UseScore& s = out[name];
      s.error += std::pow(rms(j.error), 2) / seeds;
      s.stated += std::pow(rms(j.stated), 2) / seeds;
    }
  }
  for (auto& [name, s] : out) {
    const double outside = 100.0 - s.inside_percent;
    s.inside_percent = s.stated_at_all > 0 ? 100.0 - 100.0 * outside / s.stated_at_all : 0.0;
    s.error = std::sqrt(s.error);
    s.stated = std::sqrt(s.stated);
  }
  return out;
}

}  // namespace stillpoint::bench
