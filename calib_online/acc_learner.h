/// The accelerometer: ellipsoid and temperature from rest windows, as what is published and a rival that attitudes may
/// put in its place (docs/math/temperature.md). After Gietzelt and Zhang; the Kalman form is ours.
#pragma once
#include <string>

#include "calib_online/consistency.h"
#include "calib_online/gyr_learner.h"
#include "calib_online/map_fit.h"
#include "calib_online/rivalry.h"
#include "calib_online/temperature_cells.h"
#include "calib_online/temperature_filter.h"
#include "calib_online/unrest.h"
#include "calib_online/window.h"
#include "core/calibration.h"

namespace stillpoint::calib {

enum class TemperatureModel : std::uint8_t { kNone, kCells, kPolynomial };

struct AccLearnerParams {
  AccFilterParams filter;
  TemperatureModel model = TemperatureModel::kPolynomial;
  TemperatureCellsParams cells;
  double gravity_mps2 = kStandardGravity_mps2;
};

class AccLearner {
 public:
  struct State {
    AccFilter::State published, rival;
    TemperatureCells::State cells{};  ///< in use unless the temperature model is the polynomial
    Rivalry::State rivalry;
    Unrest unrest;
    Consistency noise;  ///< of windows beside what is assumed of them
    Attitudes learnt_in;
    Array3 voted_up{};  ///< the attitude that spoke last
    std::uint32_t windows = 0, refused = 0, same_direction = 0;
    std::uint32_t replaced = 0;     ///< until what was published before is given up
    std::uint32_t in_a_row = 0;     ///< refused
    double pending = 0.0;           ///< what the present attitude would say
    std::uint32_t run_windows = 0;  ///< before this one: a run in one direction and within half a cell
    double run_temp_degC = 0.0;     ///< where it began
    Array3 last_direction{};
    /// Squared errors of the norm, fading: of the factory calibration and of ours before each update.
    double factory_error = 0.0, learnt_error = 0.0, error_weight = 0.0;
  };

  AccLearner(const AccLearnerParams& params, const TriadCalibration& factory);

  void predict(double dt_s) noexcept;
  /// True: what is published may have changed.
  bool absorb(const Window& w) noexcept;
  void publish(double temp_degC, const SeenTemperatures& seen, TriadCalibration& out) noexcept;

  [[nodiscard]] std::uint32_t windows() const noexcept { return s_.windows; }
  /// What pushes sideways may be in the present window's direction, rad^2.
  [[nodiscard]] double pushed_var() const noexcept { return s_.unrest.sideways_now_sq; }
  [[nodiscard]] State state() const noexcept;
  void restore(const State& s) noexcept;

 private:
  /// The nine entries and their covariance at one temperature, by whichever model is chosen.
  using Estimate = TemperatureCells::Estimate;
  [[nodiscard]] double tau(double temp_degC) const noexcept;
  [[nodiscard]] bool polynomial() const noexcept { return params_.model == TemperatureModel::kPolynomial; }
  [[nodiscard]] double slope_variance() const noexcept;
  [[nodiscard]] double window_variance() const noexcept;
  [[nodiscard]] Estimate estimate(double temp_degC) const noexcept;
  [[nodiscard]] Estimate doubted(double temp_degC) const noexcept;
  [[nodiscard]] Vec9 entries(double temp_degC) const noexcept;  ///< the same without its covariance
  [[nodiscard]] AccFilter::Innovation innovation(const Vec3& x, double temp_degC) const noexcept;
  [[nodiscard]] double variance_of(const Window& w, const Vec3& x) noexcept;
  /// `doubt`: how many times larger an outlier's variance is (Huber).
  void learn(const Vec3& x, const Window& w, double variance, double doubt) noexcept;
  void hear(const Vec3& x, double temp_degC, double variance, bool refused) noexcept;
  void open_rival(const Vec3& up_body, double surprise) noexcept;
  void exchange() noexcept;
  void follow_drift(const AccFilter::Innovation& e, double variance) noexcept;

  AccLearnerParams params_;
  TriadCalibration factory_;
  AccFilter published_, rival_;
  TemperatureCells cells_;
  Rivalry rivalry_;
  double unexplained_ = 0.0;  ///< of an attitude's squared error, beyond what was stated; fading, 0 after a restart
  State s_;                   ///< its filters' states are filled in by state()
};

}  // namespace stillpoint::calib
