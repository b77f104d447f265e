#include "diagnosis/no_reference/model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/so3.h"
#include "diagnosis/no_reference/closure.h"

namespace stillpoint::diag::detail {
namespace {

constexpr std::size_t kMostMagRows = 9000;
// Of motion integrated at a stretch: between rests far apart the attitude is put right too.
constexpr double kLeastLeg_s = 1.0, kLeg_s = 8.0;
constexpr double kLeastClosure_rad = 1e-4;
// How far the simulation's calibration may be off (matrix entries; offsets in the sensor's unit).
constexpr double kMatrixPrior = 0.05, kGyroOffsetPrior = 0.05, kAccOffsetPrior = 0.5, kMagOffsetPrior = 10.0,
                 kFieldPrior_uT = 8.0, kAttitudePrior_rad = 0.5, kFixed = 1e-9;

/// By the nuisances as well.
Vec3 corrected(const Eigen::VectorXd& x, long at, const Vec3& u) {
  Vec3 d = x.segment<3>(at + 9);
  for (int i = 0; i < 3; ++i) d[i] += x.segment<3>(at + 3 * i).dot(u);
  return u - d;
}

/// The reading that `corrected` makes `c` of.
struct Uncorrected {
  Mat3 gain;
  Vec3 offset;
  Uncorrected(const Eigen::VectorXd& x, long at)
      : gain((Mat3::Identity() - Eigen::Map<const RowMajor3>(x.data() + at)).inverse()), offset(x.segment<3>(at + 9)) {}
  Vec3 operator()(const Vec3& c) const { return gain * (c + offset); }
};

std::vector<Vec3> integral(const LawColumn& column, const std::vector<Mat3>& R, const io::Recording& r) {
  std::vector<Vec3> sum(R.size(), Vec3::Zero());
  for (std::size_t i = 1; i < sum.size(); ++i)
    sum[i] = sum[i - 1] + 0.5 * (r.t_s(i) - r.t_s(i - 1)) * (R[i - 1] * column.at(i - 1) + R[i] * column.at(i));
  return sum;
}

}  // namespace

SelfConsistency::SelfConsistency(const io::Recording& recording, const sim::SimulationConfig& simulation,
                                 const Forensics& raw, std::vector<RestWindow> rest)
    : recording_(recording), simulation_(simulation), rest_(std::move(rest)), field_world_(simulation.field_world_uT) {
  const std::size_t n = recording.size();
  const bool has_mag = simulation.magnetometer && !recording.mag_uT.empty();
  const std::size_t stride = std::max<std::size_t>(1, n / kMostMagRows);
  for (std::size_t i = first_row(); has_mag && i < n; i += stride)
    if (recording.mag_uT[i].allFinite() && !raw.muted(kMag, i)) mag_rows_.push_back(i);
  const auto cell =
      std::max<std::size_t>(2, static_cast<std::size_t>(std::lround(kRestCell_s / recording.median_step_s())));
  for (const auto& w : rest_)
    for (std::size_t i = w.first; i + cell <= w.last + 1; i += cell) cells_.push_back({i, i + cell - 1});
  place_knots();
  for (std::size_t k = 1; k < knots_.size() && rest_.empty(); ++k)  // which way is up, roughly
    if (knots_[k - 1] + cell <= knots_[k]) cells_.push_back({knots_[k - 1], knots_[k - 1] + cell - 1});
  first_attitude_ = first_attitude();
  prior_sd_ = Eigen::VectorXd::Constant(numbers(), kMatrixPrior);
  // A common turn of all sensors against the body changes nothing that they see: the body's axes are those in which the
  // accelerometer's matrix is triangular (Tedaldi, Pretto and Menegatti, ICRA 2014).
  for (const long below : {3, 6, 7}) prior_sd_[kAccAt + below] = kFixed;
  prior_sd_.segment<3>(kGyroAt + 9).setConstant(kGyroOffsetPrior);
  prior_sd_.segment<3>(kAccAt + 9).setConstant(kAccOffsetPrior);
  prior_sd_.segment<3>(kMagAt + 9).setConstant(kMagOffsetPrior);
  prior_sd_.segment<3>(kFieldAt).setConstant(kFieldPrior_uT);
  prior_sd_.segment<3>(kLegsAt).setConstant(kAttitudePrior_rad);
  start_anew();
}

void SelfConsistency::start_anew() {
  x_ = Eigen::VectorXd::Zero(numbers());
  if (rest_.empty())
    start_in_motion();
  else
    x_.segment<3>(kGyroAt + 9) = offset_at_rest();
}

/// The time in which the gyroscope's noise turns the field as much as the magnetometer's own leaves open over that
/// time.
double SelfConsistency::even_leg_s() const {
  if (!simulation_.magnetometer || mag_rows_.empty()) return kLeg_s;
  const double read_uT =
      simulation_.magnetometer->noise_sd * std::sqrt(span_s() / static_cast<double>(mag_rows_.size()));
  const double turned_uT =
      simulation_.gyroscope->noise_sd * std::sqrt(recording_.median_step_s()) * field_world_.norm();
  return read_uT / std::max(turned_uT, 1e-12);
}

/// At the first row, at every rest after the first, and so often in between that no leg of motion is too long.
void SelfConsistency::place_knots() {
  leg_s_ = std::clamp(0.5 * even_leg_s(), kLeastLeg_s, kLeg_s);
  knots_ = {0};
  const auto go_to = [this](std::size_t row) {
    const std::size_t from = std::max(knots_.back(), first_row());
    const auto legs = static_cast<std::size_t>((recording_.t_s(row) - recording_.t_s(from)) / leg_s_);
    for (std::size_t k = 1; k <= legs; ++k) knots_.push_back(from + k * (row - from) / (legs + 1));
  };
  for (std::size_t w = 1; w < rest_.size(); ++w) {
    go_to(rest_[w].first);
    knots_.push_back(rest_[w].first);
  }
  go_to(recording_.size() - 1);
}

/// How far the attitude may have to be put right at each knot: what the noise of the rate adds up to since the one
/// before, and what sampling loses.
void SelfConsistency::expect_closure() {
  const double at_rest = rest_.empty() ? 0.0 : std::sqrt(rate_sd_.squaredNorm() / 3.0 * kRestCell_s);
  const double walk = std::max(simulation_.gyroscope->noise_sd * std::sqrt(recording_.median_step_s()), at_rest);
  for (std::size_t k = 1; k < knots_.size(); ++k) {
    const double span_s = recording_.t_s(knots_[k]) - recording_.t_s(knots_[k - 1]);
    const double sd =
        std::hypot(walk * std::sqrt(span_s), integration_error_rad(recording_, rate_, knots_[k - 1], knots_[k]));
    prior_sd_.segment<3>(kLegsAt + 3 * static_cast<long>(k)).setConstant(sd + kLeastClosure_rad);
  }
}

/// Rates, forces and attitude of every row from the nuisances as they stand.
void SelfConsistency::integrate() {
  const auto n = recording_.size();
  const auto &gyro = *simulation_.gyroscope, &acc = *simulation_.accelerometer;
  rate_.assign(n, Vec3::Zero()), force_.assign(n, Vec3::Zero()), R_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (recording_.gyr_radps[i].allFinite())
      rate_[i] = corrected(x_, kGyroAt, corrected(gyro, recording_.gyr_radps[i]));
    else if (i > 0)
      rate_[i] = rate_[i - 1];
    if (!applied_[kGyr].empty()) rate_[i] -= applied_[kGyr][i];
    if (recording_.acc_mps2[i].allFinite())
      force_[i] = corrected(x_, kAccAt, corrected(acc, recording_.acc_mps2[i]));
    else if (i > 0)
      force_[i] = force_[i - 1];
    if (!applied_[kAcc].empty()) force_[i] -= applied_[kAcc][i];
  }
  Quat q = first_attitude_;  // of the first rest; what lies before it is not looked at
  std::size_t knot = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > first_row()) q = (q * turn_between(recording_, rate_, i - 1, i)).normalized();
    for (; knot < knots_.size() && knots_[knot] == i; ++knot) {
      const long leg = kLegsAt + 3 * static_cast<long>(knot);
      const Vec3 before = knot == 0 ? Vec3::Zero().eval() : x_.segment<3>(leg - 3).eval();
      q = (exp_quat(x_.segment<3>(leg) - before) * q).normalized();
    }
    R_[i] = q.toRotationMatrix();
  }
}

void SelfConsistency::predict() {
  const Vec3 m_w = field_world_ + x_.segment<3>(kFieldAt);
  mag_.assign(recording_.size(), Vec3::Zero()), field_.resize(recording_.size());
  for (std::size_t i = 0; i < recording_.size(); ++i) field_[i] = R_[i].transpose() * m_w;
  for (const std::size_t i : mag_rows_) {
    mag_[i] = corrected(x_, kMagAt, corrected(*simulation_.magnetometer, recording_.mag_uT[i]));
    if (!applied_[kMag].empty()) mag_[i] -= applied_[kMag][i];
  }
}

/// Around the attitude as it stands; a step that is only tried needs none of it.
void SelfConsistency::find_turned() {
  turned_.clear();
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  const Mat3 turns_field = skew(field_world_ + x_.segment<3>(kFieldAt)),
             turns_up = skew(Vec3(0, 0, simulation_.gravity_mps2));
  for (const std::size_t row : mag_rows_)
    turned_.push_back({row, static_cast<long>(turned_.size()), nm, R_[row].transpose() * turns_field});
  for (long c = 0; c < nc; ++c) {
    const auto& cell = cells_[static_cast<std::size_t>(c)];
    const auto row = (cell.first + cell.last) / 2;
    turned_.push_back({row, 3 * nm + c, nc, R_[row].transpose() * turns_up});
  }
}

Vec3 SelfConsistency::cell_mean(const std::vector<Vec3>& v, const Cell& cell) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = cell.first; i <= cell.last; ++i) sum += v[i];
  return sum / static_cast<double>(cell.last - cell.first + 1);
}

Eigen::VectorXd SelfConsistency::residual() const {
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  Eigen::VectorXd r(3 * nm + 6 * nc);
  for (long i = 0; i < nm; ++i) {
    const auto row = mag_rows_[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) r[k * nm + i] = mag_[row][k] - field_[row][k];
  }
  for (long c = 0; c < nc; ++c) {
    const auto& cell = cells_[static_cast<std::size_t>(c)];
    const Vec3 up = R_[(cell.first + cell.last) / 2].transpose() * Vec3(0, 0, simulation_.gravity_mps2);
    const Vec3 f = cell_mean(force_, cell) - up, w = cell_mean(rate_, cell);
    for (int k = 0; k < 3; ++k) r[3 * nm + k * nc + c] = f[k], r[3 * nm + (3 + k) * nc + c] = w[k];
  }
  return r;
}

void SelfConsistency::attitude_column(const std::vector<Vec3>& eps_world, Eigen::Ref<Eigen::VectorXd> out) const {
  for (const Turned& reading : turned_) {
    const Vec3 d = reading.by * eps_world[reading.row];
    for (int k = 0; k < 3; ++k) out[reading.at + k * reading.apart] += d[k];
  }
}

void SelfConsistency::sensor_column(const LawColumn& column, Eigen::Ref<Eigen::VectorXd> out) const {
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  if (column.sensor == kMag) {
    for (long i = 0; i < nm; ++i) {
      const Vec3 d = column.at(mag_rows_[static_cast<std::size_t>(i)]);
      for (int k = 0; k < 3; ++k) out[k * nm + i] += d[k];
    }
    return;
  }
  const long at = 3 * nm + (column.sensor == kGyr ? 3 * nc : 0);
  for (long c = 0; c < nc; ++c) {
    const Cell& cell = cells_[static_cast<std::size_t>(c)];
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = cell.first; i <= cell.last; ++i) sum += column.at(i);
    for (int k = 0; k < 3; ++k) out[at + k * nc + c] += sum[k] / static_cast<double>(cell.last - cell.first + 1);
  }
  if (column.sensor != kGyr) return;
  auto eps = integral(column, R_, recording_);
  // A rate error before the first rest turns nothing that is compared: the attitude starts there.
  const Vec3 start = eps[first_row()];
  for (std::size_t i = 0; i < eps.size(); ++i) eps[i] = i < first_row() ? Vec3::Zero().eval() : (start - eps[i]).eval();
  attitude_column(eps, out);
}

Eigen::MatrixXd SelfConsistency::columns(const std::vector<LawColumn>& law) const {
  const auto rows = static_cast<long>(3 * mag_rows_.size() + 6 * cells_.size());
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(rows, static_cast<long>(law.size()));
  for (std::size_t j = 0; j < law.size(); ++j) sensor_column(law[j], m.col(static_cast<long>(j)));
  return m;
}

NuisanceColumns SelfConsistency::nuisance_columns() const {
  const std::size_t n = recording_.size();
  const auto rows = static_cast<long>(3 * mag_rows_.size() + 6 * cells_.size());
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(rows, kLegsAt);
  const std::array<std::pair<Sensor, long>, 3> blocks{{{kGyr, kGyroAt}, {kAcc, kAccAt}, {kMag, kMagAt}}};
  LawColumn column{kGyr, std::vector<Vec3>(n)};
  for (const auto& [sensor, at] : blocks) {
    column.sensor = sensor;
    const auto& value = sensor == kGyr ? rate_ : sensor == kAcc ? force_ : field_;
    const Uncorrected reading(x_, at);
    std::vector<Vec3> u(n);
    for (std::size_t r = 0; r < n; ++r) u[r] = reading(value[r]);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 4; ++j) {
        for (std::size_t r = 0; r < n; ++r) column.unit[r] = Vec3::Unit(i) * (j < 3 ? u[r][j] : 1.0);
        sensor_column(column, m.col(j < 3 ? at + 3 * i + j : at + 9 + i));
      }
    }
  }
  for (int j = 0; j < 3; ++j) {
    for (std::size_t r = 0; r < n; ++r) column.unit[r] = R_[r].row(j).transpose();
    sensor_column(column, m.col(kFieldAt + j));
  }
  return {std::move(m), local_columns(), Eigen::MatrixXd(rows, 0)};
}

}  // namespace stillpoint::diag::detail
