/// Values between those that were measured.
#pragma once
#include <utility>
#include <vector>

#include "core/median.h"
#include "io/recording.h"

namespace stillpoint::diag::detail {

/// One column where it was measured: frames of a camera, or readings of a sensor with a clock of its own. Between them
/// Lagrange's polynomial through up to eight on either side.
template <class Value>
class Frames {
  static constexpr double kLongest = 2.5;  // step that is bridged, over the usual one
  static constexpr std::size_t kReach = 8, kLeastReach = 3;

 public:
  Frames(const io::Recording& r, const std::vector<Value>& column) {
    for (std::size_t i = 0; i < column.size(); ++i)
      if (column[i].allFinite()) t_s_.push_back(r.t_s(i)), value_.push_back(column[i]);
    join();
  }
  /// At these times, as Recording::t_s.
  Frames(std::vector<double> t_s, std::vector<Value> value) : t_s_(std::move(t_s)), value_(std::move(value)) { join(); }

  [[nodiscard]] double rate_hz() const { return usual_s_ > 0 ? 1.0 / usual_s_ : 0.0; }

  /// Fills what is missing where frames stand on both sides without a break; true when it did somewhere.
  bool fill(const io::Recording& r, std::vector<Value>& column) const {
    bool any = false;
    std::size_t next = 0;  // frame
    for (std::size_t i = 0; i < column.size() && usual_s_ > 0; ++i) {
      while (next < t_s_.size() && t_s_[next] <= r.t_s(i)) ++next;
      if (column[i].allFinite()) continue;
      const std::size_t reach = reach_around(next);
      if (reach < kLeastReach) continue;
      column[i] = between(r.t_s(i), next - reach, next + reach);
      any = true;
    }
    return any;
  }

 private:
  void join() {
    for (std::size_t k = 1; Value::SizeAtCompileTime == 4 && k < value_.size(); ++k)
      if (value_[k].dot(value_[k - 1]) < 0) value_[k] *= -1.0;  // q and -q are one rotation
    if (t_s_.size() < 2 * kReach) return;
    std::vector<double> steps;
    for (std::size_t k = 1; k < t_s_.size(); ++k) steps.push_back(t_s_[k] - t_s_[k - 1]);
    usual_s_ = median(std::move(steps));
  }
  [[nodiscard]] bool joined(std::size_t k) const { return t_s_[k] - t_s_[k - 1] <= kLongest * usual_s_; }
  /// How many frames without a break stand on either side of the step to frame k.
  [[nodiscard]] std::size_t reach_around(std::size_t k) const {
    if (k == 0 || k >= t_s_.size() || !joined(k)) return 0;
    std::size_t reach = 1;
    while (reach < kReach && k > reach && k + reach < t_s_.size() && joined(k - reach) && joined(k + reach)) ++reach;
    return reach;
  }
  [[nodiscard]] Value between(double t_s, std::size_t first, std::size_t last) const {
    Value sum = Value::Zero();
    for (std::size_t j = first; j < last; ++j) {
      double weight = 1.0;
      for (std::size_t m = first; m < last; ++m)
        if (m != j) weight *= (t_s - t_s_[m]) / (t_s_[j] - t_s_[m]);
      sum += weight * value_[j];
    }
    return Value::SizeAtCompileTime == 4 ? Value(sum.normalized()) : sum;
  }

  std::vector<double> t_s_;
  std::vector<Value> value_;
  double usual_s_ = 0.0;
};

}  // namespace stillpoint::diag::detail
