#include "diagnosis/reference/timing_in_window.h"

namespace stillpoint::diag {

TimingLaw in_window(TimingLaw law, const Window& window) {
  if (!window.local) return law;
  law.delta = [delta = std::move(law.delta), window](const Eigen::VectorXd& p) {
    Series3 d = delta(p);
    d.topRows(window.begin).setZero();
    d.bottomRows(d.rows() - window.end).setZero();
    return d;
  };
  return law;
}

}  // namespace stillpoint::diag
