/// The magnetometer's soft iron, mounting and hard iron from turns of the field (docs/math/field.md).
#pragma once
#include <optional>
#include <span>

#include "calib_online/field_filter.h"
#include "calib_online/field_turns.h"
#include "core/calibration.h"

namespace stillpoint::calib {

class MagLearner {
 public:
  struct State {
    FieldFilter::State field{};
    std::int64_t t_ns = 0, published_ns = 0;
  };

  MagLearner(const FieldFilterParams& params, const TriadCalibration& factory) : factory_(factory), field_(params) {}

  /// True: it is time to publish.
  bool absorb(const FieldTurn& t, double gyr_matrix_sd, double gyr_bias_sd_radps) noexcept;
  void publish(TriadCalibration& out) const noexcept;
  /// The same, known or not; nothing where it is no calibration.
  [[nodiscard]] std::optional<TriadCalibration> so_far() const noexcept;

  /// Mean square, uT^2 per axis, of what is learnt leaves of these turns for the place; nothing where they are too few.
  [[nodiscard]] std::optional<double> misfit_uT2(std::span<const FieldTurn> turns, double gyr_matrix_sd,
                                                 double gyr_bias_sd_radps) const noexcept;
  void expect_misfit(double uT2) noexcept { field_.expect_misfit(uT2); }
  /// Not as if the same errors came again (F4): the closest fit, much too sure.
  void count_each_turn() noexcept { field_.count_each_pair(); }

  [[nodiscard]] std::uint32_t turns() const noexcept { return field_.state().pairs; }
  [[nodiscard]] State state() const noexcept { return {field_.state(), t_ns_, published_ns_}; }
  void restore(const State& s) noexcept;

 private:
  [[nodiscard]] FieldFilter::Pair pair_of(const FieldTurn& t, double gyr_matrix_sd,
                                          double gyr_bias_sd_radps) const noexcept;

  TriadCalibration factory_;
  FieldFilter field_;
  std::int64_t t_ns_ = 0, published_ns_ = 0;
};

}  // namespace stillpoint::calib
