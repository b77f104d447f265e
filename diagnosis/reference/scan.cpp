#include "diagnosis/reference/scan.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr double kBlock_s = 0.5;
constexpr Eigen::Index kCoarse = 4;  // window edges are tried every 4 blocks, then refined
constexpr std::array<double, 9> kLengths_s{6, 8, 10, 12, 16, 20, 26, 32, 40};

/// Columns over their Cholesky factor: orthonormal where `gram` is their Gram matrix. Units are taken out first, and a
/// whisper of ridge stands against exact copies.
void make_orthonormal(Eigen::Ref<Eigen::MatrixXd> columns, const Eigen::MatrixXd& gram) {
  if (columns.cols() == 0) return;
  const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-280).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd S = scale.asDiagonal() * gram * scale.asDiagonal();
  S.diagonal().array() += 1e-9;
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  const Eigen::MatrixXd T = llt.matrixU().solve(Eigen::MatrixXd(Eigen::MatrixXd::Identity(S.rows(), S.cols())));
  columns = (columns * scale.asDiagonal() * T).eval();
}

}  // namespace

Columns in_window(Columns columns, const Window& window) {
  if (!window.local) return columns;
  for (Column& c : columns) {
    c.x.topRows(window.begin).setZero();
    c.x.bottomRows(c.x.rows() - window.end).setZero();
  }
  return columns;
}

Scan::Scan(const Target& target, const Columns& explained, const NoiseModel& noise) : target_(target), noise_(noise) {
  const Eigen::Index n = target.layout.n;
  block_ = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::lround(kBlock_s / target.rows.step_s)));
  blocks_ = (n + block_ - 1) / block_;
  own_ = target.nuisance.cols() + target.walk_terms();
  shared_ = static_cast<Eigen::Index>(explained.size());
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(shared_, shared_);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::MatrixXd own(n, own_), shared = Eigen::MatrixXd::Zero(n, shared_);
    for (Eigen::Index j = 0; j < target.nuisance.cols(); ++j)
      own.col(j) = noise.whiten(target.layout, target.nuisance.col(j), axis);
    for (Eigen::Index j = 0; j < target.walk_terms(); ++j)
      own.col(target.nuisance.cols() + j) = noise.whiten(target.layout, target.walk->col(j), axis);
    for (std::size_t j = 0; j < explained.size(); ++j)
      if (const auto shown = shown_in(explained[j], axis))
        shared.col(static_cast<Eigen::Index>(j)) = noise.whiten(target.layout, *shown, axis);
    make_orthonormal(own, own.transpose() * own);
    shared -= own * (own.transpose() * shared).eval();
    joint.noalias() += shared.transpose() * shared;
    Eigen::MatrixXd& base = base_[static_cast<std::size_t>(axis)];
    base.resize(n, own_ + shared_);
    base << own, shared;
    residual_[static_cast<std::size_t>(axis)] = noise.whiten(target.layout, target.residual.col(axis), axis);
  }
  Eigen::VectorXd projection = Eigen::VectorXd::Zero(shared_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    make_orthonormal(base_[axis].rightCols(shared_), joint);
    residual_[axis] -= base_[axis].leftCols(own_) * (base_[axis].leftCols(own_).transpose() * residual_[axis]).eval();
    projection += base_[axis].rightCols(shared_).transpose() * residual_[axis];
  }
  for (std::size_t axis = 0; axis < 3; ++axis) residual_[axis] -= base_[axis].rightCols(shared_) * projection;
}

Scan::Sums Scan::sums_of(const Columns& columns) const {
  const auto p = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index n = target_.layout.n;
  Sums out;
  out.self.assign(static_cast<std::size_t>(blocks_) + 1, Eigen::MatrixXd::Zero(p, p));
  out.base.assign(static_cast<std::size_t>(blocks_) + 1, Eigen::MatrixXd::Zero(p, 3 * own_ + shared_));
  out.residual.assign(static_cast<std::size_t>(blocks_) + 1, Eigen::VectorXd::Zero(p));
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::MatrixXd& base = base_[static_cast<std::size_t>(axis)];
    const Series& residual = residual_[static_cast<std::size_t>(axis)];
    std::vector<Eigen::Index> index;
    Eigen::MatrixXd X(n, p);
    for (Eigen::Index j = 0; j < p; ++j) {
      const auto shown = shown_in(columns[static_cast<std::size_t>(j)], axis);
      if (!shown) continue;
      X.col(static_cast<Eigen::Index>(index.size())) = noise_.whiten(target_.layout, *shown, axis);
      index.push_back(j);
    }
    const auto shown = static_cast<Eigen::Index>(index.size());
    Eigen::MatrixXd with_base(base.cols(), shown), self(shown, shown);
    Eigen::VectorXd r(shown);
    for (Eigen::Index b = 0; b < blocks_; ++b) {
      const Eigen::Index begin = b * block_, length = std::min(block_, n - begin);
      const auto rows = X.leftCols(shown).middleRows(begin, length);
      with_base.noalias() = base.middleRows(begin, length).transpose() * rows;
      self.noalias() = rows.transpose() * rows;
      r.noalias() = rows.transpose() * residual.segment(begin, length);
      const auto at = static_cast<std::size_t>(b) + 1;
      for (Eigen::Index i = 0; i < shown; ++i) {
        const Eigen::Index row = index[static_cast<std::size_t>(i)];
        out.residual[at][row] += r[i];
        out.base[at].row(row).segment(axis * own_, own_) += with_base.col(i).head(own_);
        out.base[at].row(row).tail(shared_) += with_base.col(i).tail(shared_);
        for (Eigen::Index j = 0; j < shown; ++j) out.self[at](row, index[static_cast<std::size_t>(j)]) += self(i, j);
      }
    }
  }
  for (std::size_t b = 1; b <= static_cast<std::size_t>(blocks_); ++b) {
    out.self[b] += out.self[b - 1];
    out.base[b] += out.base[b - 1];
    out.residual[b] += out.residual[b - 1];
  }
  return out;
}

double Scan::gain(const Sums& sums, Eigen::Index first, Eigen::Index last) const {
  const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(last);
  const Eigen::MatrixXd full = sums.self[b] - sums.self[a];
  const Eigen::MatrixXd base = sums.base[b] - sums.base[a];
  const Eigen::VectorXd r = sums.residual[b] - sums.residual[a];
  Eigen::MatrixXd A = full - base * base.transpose();
  // A direction that the base explains almost wholly (a constant, a linear map) has no power of its own, nor one whose
  // driver is zero in the window but for the rounding of the sums.
  const Eigen::MatrixXd& all = sums.self.back();
  for (Eigen::Index i = 0; i < A.rows(); ++i) A(i, i) += 1e-6 * full(i, i) + 1e-10 * all(i, i) + 1e-280;
  return 0.5 * r.dot(A.ldlt().solve(r));
}

void Scan::refine_edges(const Sums& sums, Eigen::Index& first, Eigen::Index& last, double& best) const {
  const auto shortest = static_cast<Eigen::Index>(kShortestWindow_s / kBlock_s);
  for (int round = 0; round < 2; ++round) {
    for (Eigen::Index* edge : {&first, &last}) {
      const Eigen::Index centre = *edge;
      if (centre == 0 || centre == blocks_) continue;
      for (Eigen::Index e = std::max<Eigen::Index>(1, centre - kCoarse); e <= std::min(blocks_ - 1, centre + kCoarse);
           ++e) {
        const Eigen::Index f = edge == &first ? e : first, l = edge == &last ? e : last;
        if (l - f < shortest) continue;
        const double g = gain(sums, f, l);
        if (g > best) best = g, *edge = e;
      }
    }
  }
}

std::vector<Candidate> Scan::look(const Law& law, std::size_t index) const {
  Candidate whole{index, 0.0, {}, -1.0, static_cast<Eigen::Index>(law.coefficients.size())};
  Candidate local = whole;
  for (const double shape : law.shapes) {
    const Sums sums = sums_of(law.columns(shape));
    if (law.extent != Extent::kStep) {
      const double g = gain(sums, 0, blocks_);
      if (g > whole.gain_nats) whole.gain_nats = g, whole.shape = shape;
    }
    if (law.extent == Extent::kWhole) continue;
    Eigen::Index best_first = 0, best_last = 0;
    double best = -1.0;
    const auto consider = [&](Eigen::Index first, Eigen::Index last) {
      const double g = gain(sums, first, last);
      if (g > best) best = g, best_first = first, best_last = last;
    };
    const auto shortest_open = static_cast<Eigen::Index>(kShortestWindow_s / kBlock_s);
    for (Eigen::Index first = 0; first < blocks_; first += kCoarse) {
      if (first > 0 && blocks_ - first >= shortest_open) consider(first, blocks_);
      if (law.extent == Extent::kStep) {
        for (Eigen::Index last = first + static_cast<Eigen::Index>(kShortestWindow_s / kBlock_s);
             first > 0 && last < blocks_; last += kCoarse)
          consider(first, last);
      } else {
        for (const double length : kLengths_s) {
          const Eigen::Index last = first + static_cast<Eigen::Index>(length / kBlock_s);
          if (last <= blocks_) consider(first, last);
        }
      }
    }
    if (best < 0) continue;
    refine_edges(sums, best_first, best_last, best);
    if (best > local.gain_nats) {
      local.gain_nats = best;
      local.shape = shape;
      local.window = {true, best_first * block_, std::min(best_last * block_, target_.layout.n)};
    }
  }
  std::vector<Candidate> out;
  if (whole.gain_nats >= 0) out.push_back(whole);
  if (local.gain_nats >= 0) out.push_back(local);
  return out;
}

}  // namespace stillpoint::diag
