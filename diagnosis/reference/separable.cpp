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

}  // namespace

bool is_separable(const Signals& s, Sensor sensor, const Columns& columns) {
  if (s.exact_reference || !s.present[sensor]) return true;
  const Eigen::Index step = std::max<Eigen::Index>(1, s.n / kRows);
  const Eigen::MatrixXd vector = every(s.vector[sensor], step);
  Eigen::MatrixXd spanned(vector.rows(), 4);
  spanned << Eigen::VectorXd::Ones(vector.rows()), vector;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> nuisance(spanned);
  return std::any_of(columns.begin(), columns.end(), [&](const Column& column) {
    const Eigen::MatrixXd x = every(column.x, step);
    return (x - spanned * nuisance.solve(x)).norm() > kLeastOwnShare * x.norm();
  });
}

void drop_inseparable(const Signals& s, Sensor sensor, std::vector<Law>& laws) {
  std::erase_if(laws, [&](const Law& law) {
    if (law.kind == Kind::kTiming || law.extent == Extent::kStep) return false;
    return !is_separable(s, sensor, law.columns(law.shapes.front()));
  });
}

}  // namespace stillpoint::diag
