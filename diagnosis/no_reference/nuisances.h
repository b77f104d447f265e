/// The columns of the self-consistency model's nuisances, most of which reach a few rows only, and what they leave of
/// the columns beside them.
#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

namespace stillpoint::diag::detail {

using Sparse = Eigen::SparseMatrix<double>;
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;  ///< to select readings or to filter them

using Triplets = std::vector<Eigen::Triplet<double>>;  ///< what stands twice is added

template <class Matrix>
[[nodiscard]] Matrix assembled(long rows, long columns, const Triplets& entries) {
  Matrix out(rows, columns);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// Adds a 3x3 block whose rows are `apart`.
void put_turn(Triplets& to, long row, long apart, long column, const Eigen::Matrix3d& block);

/// Of the prior, on the numbers themselves, of which the first depart from each other; what was accepted since is
/// independent of all others.
[[nodiscard]] Sparse information(const Sparse& departures, const Eigen::VectorXd& prior_sd, double times);

/// Rows: readings. In the order of the numbers: the calibration, what is local, what was accepted since.
struct NuisanceColumns {
  Eigen::MatrixXd calibration;  ///< reaches every row
  Sparse local;                 ///< the attitude of a leg, an offset that wanders
  Eigen::MatrixXd accepted;     ///< laws

  [[nodiscard]] long size() const { return calibration.cols() + local.cols() + accepted.cols(); }
  [[nodiscard]] Eigen::MatrixXd times(const Eigen::MatrixXd& numbers) const;
  [[nodiscard]] Eigen::MatrixXd transposed_times(const Eigen::MatrixXd& rows) const;
  [[nodiscard]] Sparse products() const;  ///< N^T N, lower half
  [[nodiscard]] NuisanceColumns under(const SparseRows& rows) const;
};

using NuisanceSolver = Eigen::SimplicialLDLT<Sparse>;

/// Normal equations of the nuisances N and of the columns K beside them.
struct Normal {
  Sparse nuisances;                ///< N^T N, lower half
  Eigen::MatrixXd across, beside;  ///< N^T K, K^T K

  Normal() = default;
  Normal(const NuisanceColumns& n, const Eigen::MatrixXd& k);
  void add(const Normal& other, double times);
  /// What is known of the numbers beforehand; the last of the columns beside them is what is left at `numbers`.
  void expect(const Sparse& information, const Eigen::VectorXd& numbers);
};

/// K^T K when the nuisances have taken all they can (Schur complement), and how much there was of them.
struct LeftOver {
  Eigen::MatrixXd beside;
  double log_determinant = 0.0;
};
[[nodiscard]] LeftOver left_over(const Normal& normal);

}  // namespace stillpoint::diag::detail
