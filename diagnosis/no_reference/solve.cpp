/// The linear algebra of the self-consistency model: settling the nuisances, fitting a law beside them, holding data
/// out.
#include <cmath>

#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kBlock_s =
    10.0;  // held-out blocks: longer than the memory of the noise, shorter than a bout and its rest
constexpr std::size_t kMostFolds = 8;
constexpr double kFree = 1e-6;  // of what the readings say: the prior of a law's coefficients when it is held out
constexpr int kLeastSteps = 3, kMostSteps = 8;
constexpr double kLeastFall = 1e-4;    // of the misfit; less leads nowhere
constexpr double kSettled_nats = 0.1;  // a step worth less changes no verdict

/// What the readings say for the law that stands before them beside the nuisances, in nats: the logarithm of the
/// evidence with it less that without.
double gain_of_law(const LeftOver& left, double variance) {
  const long law = left.beside.cols() - 1;
  const Eigen::LDLT<Eigen::MatrixXd> solver(left.beside.topLeftCorner(law, law));
  const Eigen::VectorXd b = left.beside.col(law).head(law);
  return 0.5 * (b.dot(solver.solve(b)) / variance - solver.vectorD().cwiseAbs().array().log().sum());
}

}  // namespace

void SelfConsistency::settle() {
  prior_sd_.conservativeResize(x_.size());
  double before = HUGE_VAL;
  for (int pass = 0;; ++pass) {
    integrate();
    predict();
    find_turned();
    if (!noise_kept_) find_noise(), whitener_ = whitener();
    expect_closure();
    departures_ = departures();
    N_ = nuisance_columns().under(whitener_);
    y_ = whitener_ * residual();
    doubt_ = std::max(1.0, dispersion());
    const Sparse information = detail::information(departures_, prior_sd_, doubt_);
    factorise(information);
    const Eigen::VectorXd gradient = N_.transposed_times(y_) - information * x_;
    const Eigen::VectorXd step = gram_->solve(gradient);
    const double misfit = 0.5 * (y_.squaredNorm() + doubt_ * surprise(x_));
    const bool stuck = !(misfit < (1.0 - kLeastFall) * before);
    if (pass == kMostSteps || (pass >= kLeastSteps && (stuck || 0.5 * step.dot(gradient) < kSettled_nats))) {
      y_ -= N_.times(step);  // what this step would still change is taken in the linear model
      settled_ = x_ + step;
      break;
    }
    before = misfit;
    descend(step, misfit);
  }
  for (const auto& law : accepted_) add_nuisances(whitened(law));
}

void SelfConsistency::factorise(const Sparse& information) {
  gram_ = std::make_shared<const NuisanceSolver>(Sparse(N_.products() + information));
}

/// Whole steps where they help, halved where a wrong matrix has turned the attitude so far that they lead away.
void SelfConsistency::descend(const Eigen::VectorXd& step, double misfit_nats) {
  constexpr int kHalvings = 6;
  const Eigen::VectorXd from = x_;
  double share = 1.0;
  for (int k = 0; k < kHalvings; ++k, share *= 0.5) {
    x_ = from + share * step;
    integrate();
    predict();
    if (0.5 * ((whitener_ * residual()).squaredNorm() + doubt_ * surprise(x_)) < misfit_nats) return;
  }
}

LawFit SelfConsistency::fit(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const {
  const Eigen::MatrixXd C = whitened(law);
  const Eigen::MatrixXd NC = N_.transposed_times(C);
  Eigen::MatrixXd S = C.transpose() * C - NC.transpose() * gram_->solve(NC);
  // What the nuisances can imitate to nine digits is theirs.
  for (long i = 0; i < S.rows(); ++i) S(i, i) += 1e-9 * (C.col(i).squaredNorm() + 1e-300);
  Eigen::VectorXd b = C.transpose() * y_;
  if (applied.size() > 0) b += S * applied;
  const Eigen::LDLT<Eigen::MatrixXd> solver(S);
  LawFit fit;
  fit.value = solver.solve(b);
  const double explained = b.dot(fit.value);
  const Eigen::VectorXd left = applied.size() > 0 ? (fit.value - applied).eval() : fit.value;
  const double remains = y_.squaredNorm() - 2.0 * left.dot(C.transpose() * y_) + left.dot(S * left);
  const double dispersion = std::max(1.0, remains / static_cast<double>(y_.size()));
  fit.gain_nats = 0.5 * explained / dispersion;
  fit.covariance = dispersion * solver.solve(Eigen::MatrixXd::Identity(S.rows(), S.cols()));
  fit.sd = fit.covariance.diagonal().cwiseAbs().cwiseSqrt();
  return fit;
}

Eigen::VectorXd SelfConsistency::instead_of(const std::vector<LawColumn>& other, const Eigen::VectorXd& value,
                                            const std::vector<LawColumn>& law) const {
  const Eigen::MatrixXd C = whitened(law);
  const Eigen::MatrixXd left = C - N_.times(gram_->solve(N_.transposed_times(C)));
  const Eigen::VectorXd sought = left.transpose() * (whitened(other) * value);
  return (left.transpose() * C).ldlt().solve(sought);
}

Eigen::MatrixXd SelfConsistency::covariance_between_stretches(const std::vector<LawColumn>& law,
                                                              const Eigen::VectorXd& left) const {
  Eigen::MatrixXd C = whitened(law);
  C -= N_.times(gram_->solve(N_.transposed_times(C)));
  const Eigen::VectorXd after = y_ - C * left;
  const Eigen::MatrixXd scores = scores_of_stretches(C.array().colwise() * after.array());
  const Eigen::MatrixXd by_stretch = Eigen::LDLT<Eigen::MatrixXd>(C.transpose() * C).solve(scores.transpose());
  return by_stretch * by_stretch.transpose();
}

/// Sums of the rows over stretches of the recording, one a row, widened for their being few (Cameron, Gelbach and
/// Miller, Review of Economics and Statistics 90, 2008).
Eigen::MatrixXd SelfConsistency::scores_of_stretches(const Eigen::MatrixXd& rows) const {
  constexpr double kStretch_s = 5.0;
  const double length_s = recording_.t_s(recording_.size() - 1) - recording_.t_s(0);
  const auto blocks = static_cast<long>(length_s / kStretch_s) + 1;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(blocks, rows.cols());
  for (long i = 0; i < rows.rows(); ++i)
    out.row(static_cast<long>((recording_.t_s(row_of(i)) - recording_.t_s(0)) / kStretch_s)) += rows.row(i);
  const double n = static_cast<double>(blocks), student = 1.0 + 2.4 / std::max(n - 1.0, 1.0);  // of 95 %
  return out * (student * std::sqrt(n / std::max(n - 1.0, 1.0)));
}

/// The row of the recording behind a row of the model.
std::size_t SelfConsistency::row_of(long i) const {
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  return i < 3 * nm ? mag_rows_[static_cast<std::size_t>(i % nm)]
                    : cells_[static_cast<std::size_t>((i - 3 * nm) % nc)].first;
}

void SelfConsistency::take_out(const std::vector<LawColumn>& law, const Eigen::VectorXd& value) {
  for (std::size_t j = 0; j < law.size(); ++j) {
    auto& taken = applied_[law[j].sensor];
    if (taken.empty()) taken.assign(recording_.size(), Vec3::Zero());
    for (std::size_t i = 0; i < taken.size(); ++i) taken[i] += value[static_cast<long>(j)] * law[j].at(i);
  }
}

void SelfConsistency::replace(const std::vector<LawColumn>& before, const Eigen::VectorXd& before_value,
                              const std::vector<LawColumn>& law, const Eigen::VectorXd& value) {
  take_out(before, -before_value);
  take_out(law, value);
  settle();
}

/// The law, and last the readings as they are, with what was applied of it put back.
Eigen::MatrixXd SelfConsistency::beside_nuisances(const std::vector<LawColumn>& law,
                                                  const Eigen::VectorXd& applied) const {
  const Eigen::MatrixXd C = whitened(law);
  Eigen::MatrixXd columns(C.rows(), C.cols() + 1);
  columns << C, (applied.size() > 0 ? (y_ + C * applied).eval() : y_);
  return columns;
}

HeldOutGain SelfConsistency::held_out(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const {
  const Eigen::MatrixXd K = beside_nuisances(law, applied);
  const auto coefficients = static_cast<long>(law.size());
  const double variance = std::max(1.0, dispersion());
  const double span_s = recording_.t_s(recording_.size() - 1) - recording_.t_s(0);
  const auto folds = std::min<std::size_t>(kMostFolds, static_cast<std::size_t>(span_s / kBlock_s) + 1);
  std::vector<Triplets> rows(folds);
  for (long i = 0; i < y_.size(); ++i) {
    const auto block = static_cast<std::size_t>((recording_.t_s(row_of(i)) - recording_.t_s(0)) / kBlock_s);
    auto& own = rows[block % folds];
    own.emplace_back(static_cast<int>(own.size()), static_cast<int>(i), 1.0);
  }
  std::erase_if(rows, [](const auto& r) { return r.empty(); });
  HeldOutGain gain;
  if (rows.size() < 2) return gain;
  Normal all(N_, K);
  all.expect(information(departures_, prior_sd_, variance), settled_);
  all.beside.diagonal().head(coefficients) *= 1.0 + kFree;
  const double whole = gain_of_law(left_over(all), variance);
  for (const auto& r : rows) {
    const auto own = assembled<SparseRows>(std::ssize(r), y_.size(), r);
    Normal others = all;
    others.add(Normal(N_.under(own), own * K), -1.0);
    const double nats = whole - gain_of_law(left_over(others), variance);
    gain.nats += nats, gain.blocks_better += nats > 0, ++gain.blocks;
  }
  return gain;
}

void SelfConsistency::add_nuisances(const Eigen::MatrixXd& C) {
  const Eigen::MatrixXd NC = N_.transposed_times(C);
  const Eigen::MatrixXd S = C.transpose() * C - NC.transpose() * gram_->solve(NC);
  const Eigen::VectorXd value = S.ldlt().solve(C.transpose() * y_);
  const Eigen::VectorXd given_back = gram_->solve(NC * value);
  y_ -= C * value - N_.times(given_back);
  settled_ -= given_back;
  settled_.conservativeResize(settled_.size() + value.size());
  settled_.tail(value.size()) = value;
  N_.accepted.conservativeResize(C.rows(), N_.accepted.cols() + C.cols());
  N_.accepted.rightCols(C.cols()) = C;
  Eigen::VectorXd prior(N_.size());
  prior << prior_sd_, C.colwise().norm().transpose().cwiseInverse() * 1e4;  // next to free
  prior_sd_ = prior;
  factorise(information(departures_, prior_sd_, doubt_));
}

void SelfConsistency::accept(const std::vector<LawColumn>& law) {
  accepted_.push_back(law);
  add_nuisances(whitened(law));
}

SelfConsistency::Series SelfConsistency::series(Sensor sensor, const std::vector<LawColumn>& law,
                                                const Eigen::VectorXd& applied) const {
  Series out;
  const Eigen::MatrixXd raw = columns(law), white = whitener_ * raw;
  const NuisanceColumns nuisance = nuisance_columns();
  const Eigen::VectorXd value = law.empty() ? Eigen::VectorXd() : fit(law, applied).value;
  const Eigen::VectorXd before_value = applied.size() > 0 ? applied : Eigen::VectorXd::Zero(value.size()).eval();
  // Before: the residual with the nuisances alone at their best. Explained: the law, less what the nuisances give back.
  const auto given_back = [&](const Eigen::VectorXd& v) {
    const Eigen::VectorXd x = gram_->solve(N_.transposed_times(white * v));
    return (raw * v - nuisance.times(x.head(nuisance.size()))).eval();
  };
  const Eigen::VectorXd r = residual() + given_back(before_value), e = given_back(value);
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  const long n = sensor == kMag ? nm : nc, at = sensor == kMag ? 0 : 3 * nm + (sensor == kGyr ? 3 * nc : 0);
  for (long i = 0; i < n; ++i) {
    const auto row =
        sensor == kMag ? mag_rows_[static_cast<std::size_t>(i)] : cells_[static_cast<std::size_t>(i)].first;
    out.t_s.push_back(recording_.t_s(row));
    out.residual.emplace_back(r[at + i], r[at + n + i], r[at + 2 * n + i]);
    out.explained.emplace_back(e[at + i], e[at + n + i], e[at + 2 * n + i]);
  }
  return out;
}

double SelfConsistency::force_misfit() const {
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  return nc == 0 ? 0.0 : std::sqrt(y_.segment(3 * nm, 3 * nc).squaredNorm() / static_cast<double>(3 * nc));
}

}  // namespace stillpoint::diag::detail
