/// Whether the magnetic field is the one that the heading refers to, and how far a heading taken from it may be off.
/// (A11)-(A13) of docs/math/attitude.md.
#pragma once
#include <type_traits>

#include "core/fields.h"

namespace stillpoint::fusion {

struct FieldReferenceParams {
  double tolerance = 0.12;
  double learn_time_s = 20.0;
  double accept_time_s = 20.0;
  double smallest_horizontal_uT = 3.0;
  double largest_uT = 100.0;

  template <class P = FieldReferenceParams>
  static constexpr auto fields() {
    return std::tuple{field("tolerance", &P::tolerance, in_range(0.0, 10.0),
                            "deviation of the field, as a part of its norm, from which it counts as disturbed"),
                      field("learn_time_s", &P::learn_time_s, in_range(0.1, 1e6),
                            "time over which the reference field is averaged and follows"),
                      field("accept_time_s", &P::accept_time_s, in_range(0.1, 1e6),
                            "time of motion in another steady field after which that one becomes the reference"),
                      field("smallest_horizontal_uT", &P::smallest_horizontal_uT, in_range(0.0, 1e3),
                            "below this horizontal field (at the magnetic poles, in a shield) there is no heading"),
                      field("largest_uT", &P::largest_uT, in_range(1.0, 1e5),
                            "a larger field is not the Earth's (25 to 67 uT): iron, to be found first")};
  }
};

/// What one mean field in world axes says.
struct FieldVerdict {
  bool trusted = false;                ///< near the reference: its heading may be used
  bool accepted = false;               ///< another field has just become the reference
  double heading_variance_rad2 = 0.0;  ///< by the part of the disturbance that can be seen
};

/// Learns the horizontal and the vertical part of the field around the sensor. Plain state.
class FieldReference {
 public:
  /// (A11) A disturbance has no preferred direction: of its three components two are seen, as deviations of the
  /// horizontal and the vertical part; the third, which turns the heading, is as large as these in the mean.
  FieldVerdict observe(const FieldReferenceParams& params, double horizontal_uT, double vertical_uT, double time_s,
                       bool moving) noexcept;

  /// The calibration has changed: every field is this many times as large from now on.
  void rescale(double factor) noexcept;

  [[nodiscard]] bool known() const noexcept { return learnt_s_ > 0.0; }

 private:
  struct Field {
    double horizontal_uT = 0.0;
    double vertical_uT = 0.0;
    [[nodiscard]] double squared_distance(double horizontal, double vertical) const noexcept;
    void follow(double horizontal, double vertical, double weight) noexcept;
  };
  bool follow_candidate(const FieldReferenceParams& params, const Field& now, double limit, double time_s,
                        bool moving) noexcept;

  Field reference_;
  Field candidate_;
  double learnt_s_ = 0.0;     ///< evidence behind the reference, at most learn_time_s
  double candidate_s_ = 0.0;  ///< time of motion in the candidate field
};

static_assert(std::is_trivially_copyable_v<FieldReference>);

}  // namespace stillpoint::fusion
