/// The self-consistency of gyroscope, magnetometer and rest windows as one linear model around an attitude integrated
/// from the gyro. Rows: the field at (thinned) samples, specific force and rate in cells of rest; where nothing rests
/// the force of one cell a leg, which says roughly which way is up. Columns: the nuisances (calibration of the three
/// sensors, field, attitude of every leg of the motion), and whatever law is put beside them. With R = exp([eps]x)
/// R_hat and a rate error D: eps(t) = -int R_hat D dt, and the field error is R_hat^T (m_w x eps).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/forensics/forensics.h"
#include "diagnosis/no_reference/nuisances.h"
#include "diagnosis/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag::detail {

struct RestWindow {
  std::size_t first = 0, last = 0;  ///< rows, inclusive
};

/// What the simulation takes a reading for.
[[nodiscard]] inline Vec3 corrected(const sim::TriadConfig& simulated, const Vec3& reading) {
  return simulated.matrix * (reading - simulated.bias);
}

/// Windows of at least a second in which nothing turns and nothing shakes.
[[nodiscard]] std::vector<RestWindow> find_rest(const io::Recording& recording,
                                                const sim::SimulationConfig& simulation);

/// One coefficient of a law: its unit contribution to one sensor, sensor frame.
struct LawColumn {
  Sensor sensor = kGyr;
  std::vector<Vec3> unit;
  std::size_t first = 0;  ///< row of the recording where it begins; outside of them there is none

  [[nodiscard]] Vec3 at(std::size_t row) const {
    return row < first || row >= first + unit.size() ? Vec3::Zero().eval() : unit[row - first];
  }
};

struct LawFit {
  double gain_nats = 0.0;  ///< likelihood gain over the nuisances alone, reduced by the overdispersion that remains
  Eigen::VectorXd value, sd;
  Eigen::MatrixXd covariance;  ///< of which sd holds the diagonal
};

struct BesideWander {
  double gain_nats = 0.0;
  Eigen::VectorXd sd;  ///< of the law's values
};

struct HeldOutGain {
  double nats = 0.0;
  int blocks_better = 0, blocks = 0;
};

inline constexpr double kRestCell_s = 0.5;  ///< means over it are the readings of the rests

/// Layout of the nuisances: three blocks of 9 (rows of the matrix) + 3 (gyr, acc, mag), the field, then three per leg
/// from knot to knot (its attitude, world frame).
inline constexpr long kGyroAt = 0, kAccAt = 12, kMagAt = 24, kFieldAt = 36, kLegsAt = 39;

class SelfConsistency {
 public:
  SelfConsistency(const io::Recording& recording, const sim::SimulationConfig& simulation, const Forensics& raw,
                  std::vector<RestWindow> rest);

  /// Settles the nuisances (three to eight damped Gauss-Newton steps). Call once, before fit().
  void settle();
  /// From here on the noise stays what it was found to be: laws are compared by one measure.
  void keep_noise() { noise_kept_ = true; }
  /// `applied` is what of the law replace() has already taken out; the fit is of the whole.
  [[nodiscard]] LawFit fit(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied = {}) const;
  /// The values with which `law` does most nearly what `other` does with its own.
  [[nodiscard]] Eigen::VectorXd instead_of(const std::vector<LawColumn>& other, const Eigen::VectorXd& value,
                                           const std::vector<LawColumn>& law) const;
  /// Covariance of a law's values by what stretches of motion say against each other, which a bent attitude or a driver
  /// known in part makes more than noise. `left`: the fitted values less what replace() has taken out already.
  [[nodiscard]] Eigen::MatrixXd covariance_between_stretches(const std::vector<LawColumn>& law,
                                                             const Eigen::VectorXd& left) const;
  /// The law beside what wanders as parts flicker, hands sway and vehicles go: offsets of the gyroscope from leg to
  /// leg and of the magnetometer from stretch to stretch, accelerations from rest to rest. By as much as suits it
  /// best, against as much as suits the readings best without it.
  [[nodiscard]] BesideWander beside_wander(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const;
  /// How much better the law with the nuisances predicts blocks of 10 s than the nuisances alone, each from all the
  /// others: the logarithm of the ratio of what both give for them, with all that either does not know.
  [[nodiscard]] HeldOutGain held_out(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const;
  /// How much the body accelerates in what seems to be rest, m/s^2, as far as the readings say.
  [[nodiscard]] double acceleration_at_rest_mps2() const;
  /// Takes a law out of a sensor's readings in place of what was taken before (puts `before`
  /// back), and settles again around the attitude that follows.
  void replace(const std::vector<LawColumn>& before, const Eigen::VectorXd& before_value,
               const std::vector<LawColumn>& law, const Eigen::VectorXd& value);
  /// Takes a fitted law into the nuisances, so that the next one is sought beside it.
  void accept(const std::vector<LawColumn>& law);

  /// The nuisances as they stand, and a return to where they once stood, which the next settling starts from.
  [[nodiscard]] const Eigen::VectorXd& nuisances() const { return x_; }
  void start_from(const Eigen::VectorXd& nuisances) { x_ = nuisances; }
  void start_anew();  ///< from the simulation's numbers, and what rests, or else the motion, say of the offsets

  /// Offsets and matrices of the simulation that the nuisances contradict; none where they fit with a matrix only that
  /// no sensor has.
  [[nodiscard]] std::optional<std::vector<ConfigurationFault>> wrong_numbers() const;

  /// Residual of the sensor's rows (field or rate at rest) and what `law` predicts of it, for rms and figures.
  struct Series {
    std::vector<double> t_s;
    std::vector<Vec3> residual, explained;
  };
  [[nodiscard]] Series series(Sensor sensor, const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const;

  [[nodiscard]] const io::Recording& recording() const { return recording_; }
  [[nodiscard]] const std::vector<RestWindow>& rest() const { return rest_; }
  [[nodiscard]] const std::vector<Vec3>& rate_radps() const { return rate_; }   ///< corrected, every row
  [[nodiscard]] const std::vector<Vec3>& force_mps2() const { return force_; }  ///< corrected, every row
  [[nodiscard]] const std::vector<Vec3>& field_uT() const { return field_; }    ///< predicted in the body, every row
  [[nodiscard]] const std::vector<Mat3>& R_world_body() const { return R_; }
  /// White noise of the gyroscope's mean over half a second, as configured: what a good part's offset flickers by.
  [[nodiscard]] double cell_radps() const {
    return simulation_.gyroscope->noise_sd * std::sqrt(recording_.median_step_s() / kRestCell_s);
  }
  /// Root mean square of the whitened rest readings of the accelerometer: 1 where only noise is left.
  [[nodiscard]] double force_misfit() const;
  /// Of the readings and of what the nuisances had to move against what is expected of them.
  [[nodiscard]] double misfit_nats() const { return 0.5 * (y_.squaredNorm() + surprise(x_)); }
  /// Mean square of all whitened residuals: 1 where gyro, field and rests agree within their noise.
  [[nodiscard]] double dispersion() const {
    return y_.squaredNorm() / static_cast<double>(std::max<long>(y_.size(), 1));
  }

 private:
  class Wandering;
  struct Cell {
    std::size_t first, last;  ///< rows, inclusive
  };
  /// A reading that the attitude turns.
  struct Turned {
    std::size_t row;  ///< of the recording
    long at, apart;   ///< its rows in the model are at, at + apart, at + 2 apart
    Mat3 by;          ///< for a small turn, world frame
  };
  void take_out(const std::vector<LawColumn>& law, const Eigen::VectorXd& value);
  /// Where the first rest begins: from there on the attitude is known.
  [[nodiscard]] std::size_t first_row() const { return rest_.empty() ? 0 : rest_.front().first; }
  [[nodiscard]] Vec3 offset_at_rest() const;
  void start_in_motion();
  [[nodiscard]] Quat first_attitude() const;
  [[nodiscard]] double span_s() const { return recording_.t_s(recording_.size() - 1) - recording_.t_s(first_row()); }
  [[nodiscard]] double even_leg_s() const;
  void place_knots();
  void integrate();
  void predict();
  void find_turned();
  void find_noise();
  void find_field_noise();
  [[nodiscard]] std::vector<std::vector<Vec3>> field_at_rest(std::size_t most_rows) const;
  void expect_closure();
  void descend(const Eigen::VectorXd& step, double misfit_nats);
  [[nodiscard]] Eigen::MatrixXd columns(const std::vector<LawColumn>& law) const;  ///< not yet whitened
  [[nodiscard]] Eigen::MatrixXd whitened(const std::vector<LawColumn>& law) const { return whitener_ * columns(law); }
  [[nodiscard]] NuisanceColumns nuisance_columns() const;  ///< not yet whitened
  [[nodiscard]] Sparse local_columns() const;
  [[nodiscard]] Sparse departures() const;
  [[nodiscard]] std::size_t knot_after(std::size_t row) const;
  [[nodiscard]] long numbers() const { return kLegsAt + 3 * static_cast<long>(knots_.size()); }
  struct Estimate {
    Eigen::VectorXd value;
    Eigen::MatrixXd covariance;
  };
  /// The first numbers of the model, beside the wander that suits the readings best.
  [[nodiscard]] Estimate numbers_beside_wander(long count) const;
  [[nodiscard]] Eigen::MatrixXd beside_nuisances(const std::vector<LawColumn>& law,
                                                 const Eigen::VectorXd& applied) const;
  [[nodiscard]] Eigen::MatrixXd scores_of_stretches(const Eigen::MatrixXd& rows) const;
  [[nodiscard]] std::size_t row_of(long i) const;
  void add_nuisances(const Eigen::MatrixXd& whitened_columns);
  void factorise(const Sparse& information);
  [[nodiscard]] Eigen::VectorXd residual() const;
  [[nodiscard]] double surprise(const Eigen::VectorXd& x) const {
    return (departures_ * x).cwiseQuotient(prior_sd_.head(x.size())).squaredNorm();
  }
  void attitude_column(const std::vector<Vec3>& eps_world, Eigen::Ref<Eigen::VectorXd> out) const;
  void sensor_column(const LawColumn& column, Eigen::Ref<Eigen::VectorXd> out) const;
  [[nodiscard]] SparseRows whitener() const;
  [[nodiscard]] Vec3 cell_mean(const std::vector<Vec3>& v, const Cell& cell) const;

  const io::Recording& recording_;
  const sim::SimulationConfig& simulation_;
  std::vector<RestWindow> rest_;
  std::vector<Cell> cells_;
  std::vector<std::size_t> mag_rows_;
  std::vector<std::size_t> knots_;  ///< rows at which the attitude may be put right
  double leg_s_ = 0.0;              ///< the longest time between two of them in motion

  std::array<std::vector<Vec3>, 3> applied_;  ///< per Sensor, taken out by replace(); empty: nothing
  std::vector<Vec3> rate_, force_, mag_, field_;
  std::vector<Mat3> R_;
  std::vector<Turned> turned_;
  Vec3 field_world_;
  Quat first_attitude_;
  Eigen::VectorXd x_;         ///< nuisances as they stand
  Sparse departures_;         ///< of these from what is expected, by number
  Eigen::VectorXd prior_sd_;  ///< of the departures: how far the simulation may be off
  std::vector<std::vector<LawColumn>> accepted_;
  std::array<Eigen::VectorXd, 3> mag_ar_;
  Vec3 mag_sd_ = Vec3::Ones(), force_sd_ = Vec3::Ones(), rate_sd_ = Vec3::Ones();

  bool noise_kept_ = false;
  /// Mean square of the whitened residual, at least 1: what no nuisance explains must not bend them.
  double doubt_ = 1.0;

  SparseRows whitener_;
  NuisanceColumns N_;        ///< whitened
  Eigen::VectorXd y_;        ///< whitened residual
  Eigen::VectorXd settled_;  ///< the numbers that leave it: x_, what the last step adds to it, and the accepted laws'
  std::shared_ptr<const NuisanceSolver> gram_;
};

}  // namespace stillpoint::diag::detail
