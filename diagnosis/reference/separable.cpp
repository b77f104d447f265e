#include "diagnosis/reference/separable.h"

#include <Eigen/QR>
#include <algorithm>

namespace stillpoint::diag {
namespace {

constexpr double kLeastOwnShare = 0.03;  // of a column's norm, outside what bias and matrix span
constexpr Eigen::Index kRows = 2000;     // enough to know a share

Eigen::MatrixXd every(const Eigen::MatrixXd& x, Eigen::Index step) {
  Eigen::MatrixXd out((x.rows() + step - 1) / step, x.cols());
  for (Eigen::Index i = 0; i < out.rows(); ++i) out.row(i) = x.row(i * step);
  return out;
}

/// What a wrong bias and matrix can make of the measured vector.
class BiasAndMatrix {
 public:
  BiasAndMatrix(const Signals& s, Sensor sensor)
      : step_(std::max<Eigen::Index>(1, s.n / kRows)), spanned_(with_constant(every(s.vector[sensor], step_))) {}
  [[nodiscard]] bool span(const Columns& columns) const {
    return std::none_of(columns.begin(), columns.end(), [this](const Column& column) {
      const Eigen::MatrixXd x = every(column.x, step_);
      return (x - spanned_ * solver_.solve(x)).norm() > kLeastOwnShare * x.norm();
    });
  }

 private:
  static Eigen::MatrixXd with_constant(const Eigen::MatrixXd& vector) {
    Eigen::MatrixXd out(vector.rows(), 4);
    out << Eigen::VectorXd::Ones(vector.rows()), vector;
    return out;
  }
  Eigen::Index step_;
  Eigen::MatrixXd spanned_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver_{spanned_};
};

bool separates_everything(const Signals& s, Sensor sensor) { return s.exact_reference || !s.present[sensor]; }

}  // namespace

bool is_separable(const Signals& s, Sensor sensor, const Columns& columns) {
  return separates_everything(s, sensor) || !BiasAndMatrix(s, sensor).span(columns);
}

void drop_inseparable(const Signals& s, Sensor sensor, std::vector<Law>& laws) {
  if (separates_everything(s, sensor)) return;
  const BiasAndMatrix nuisance(s, sensor);
  std::erase_if(laws, [&](const Law& law) {
    if (law.kind == Kind::kTiming || law.extent == Extent::kStep) return false;
    return nuisance.span(law.columns(law.shapes.front()));
  });
}

}  // namespace stillpoint::diag
