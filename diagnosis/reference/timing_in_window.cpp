#include "diagnosis/reference/timing_in_window.h"

#include <cmath>

namespace stillpoint::diag {
namespace {

/// A buffer that fills for a while. What fits beyond it is some other motion of the recording.
constexpr double kLongest_s = 0.2;

}  // namespace

TimingLaw in_window(TimingLaw law, const Window& window) {
  if (!window.local) return law;
  if (law.names.front() == "tau")
    law.possible = [possible = std::move(law.possible)](const Eigen::VectorXd& p) {
      return possible(p) && std::abs(p[0]) < kLongest_s;
    };
  law.delta = [delta = std::move(law.delta), window](const Eigen::VectorXd& p) {
    Series3 d = delta(p);
    d.topRows(window.begin).setZero();
    d.bottomRows(d.rows() - window.end).setZero();
    return d;
  };
  return law;
}

}  // namespace stillpoint::diag
