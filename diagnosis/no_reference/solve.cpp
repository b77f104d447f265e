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
/// Wanders that are tried, in deviations of a cell's mean.
constexpr std::array<double, 7> kWanders{0.02, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0};
constexpr int kLeastSteps = 3, kMostSteps = 8;
constexpr double kLeastFall = 1e-4;    // of the misfit; less leads nowhere
constexpr double kSettled_nats = 0.1;  // a step worth less changes no verdict

/// Of all columns with each other: the lower half, which is all that a Cholesky factorisation reads.
Eigen::MatrixXd products(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  out.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
  return out;
}

/// What the readings say for the last `law` columns beside those before them, in nats: the logarithm of the evidence
/// with them less that without. `gram`: products() of the columns, the prior's information added, and of the readings,
/// which stand last.
double gain_of_last(const Eigen::MatrixXd& gram, long law) {
  const long with = gram.cols() - 1;
  const auto evidence = [&](long n) {
    const Eigen::LDLT<Eigen::MatrixXd> solver(gram.topLeftCorner(n, n));
    const Eigen::VectorXd by_column = gram.row(with).head(n).transpose();
    return 0.5 * (by_column.dot(solver.solve(by_column)) - solver.vectorD().cwiseAbs().array().log().sum());
  };
  return evidence(with) - evidence(with - law);
}

}  // namespace

void SelfConsistency::settle() {
  prior_sd_.conservativeResize(x_.size());
  Eigen::VectorXd information;
  double before = HUGE_VAL;
  for (int pass = 0;; ++pass) {
    integrate();
    predict();
    if (!noise_kept_) find_noise();
    expect_closure();
    N_ = nuisance_columns();
    whiten(N_);
    Eigen::MatrixXd r = residual();
    whiten(r);
    y_ = r;
    doubt_ = std::max(1.0, dispersion());
    information = this->information();
    Eigen::MatrixXd gram = products(N_);
    gram.diagonal() += information;
    gram_.compute(gram);
    const Eigen::VectorXd gradient = N_.transpose() * y_ - information.cwiseProduct(x_);
    const Eigen::VectorXd step = gram_.solve(gradient);
    const double misfit = 0.5 * (y_.squaredNorm() + x_.cwiseProduct(information).dot(x_));
    const bool stuck = !(misfit < (1.0 - kLeastFall) * before);
    if (pass == kMostSteps || (pass >= kLeastSteps && (stuck || 0.5 * step.dot(gradient) < kSettled_nats))) {
      y_ -= N_ * step;  // what this step would still change is taken in the linear model
      break;
    }
    before = misfit;
    descend(step, misfit);
  }
  for (const auto& law : accepted_) add_nuisances(whitened(law));
}

/// Whole steps where they help, halved where a wrong matrix has turned the attitude so far that they lead away.
void SelfConsistency::descend(const Eigen::VectorXd& step, double misfit_nats) {
  constexpr int kHalvings = 6;
  const Eigen::VectorXd from = x_, information = this->information();
  double share = 1.0;
  for (int k = 0; k < kHalvings; ++k, share *= 0.5) {
    x_ = from + share * step;
    integrate();
    predict();
    Eigen::MatrixXd r = residual();
    whiten(r);
    if (0.5 * (r.squaredNorm() + x_.cwiseProduct(information).dot(x_)) < misfit_nats) return;
  }
}

LawFit SelfConsistency::fit(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const {
  const Eigen::MatrixXd C = whitened(law);
  const Eigen::MatrixXd NC = N_.transpose() * C;
  const Eigen::MatrixXd P = gram_.solve(NC);
  Eigen::MatrixXd S = C.transpose() * C - NC.transpose() * P;
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

Eigen::MatrixXd SelfConsistency::covariance_between_stretches(const std::vector<LawColumn>& law,
                                                              const Eigen::VectorXd& left) const {
  Eigen::MatrixXd C = whitened(law);
  C -= N_ * gram_.solve(N_.transpose() * C);
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
    for (std::size_t i = 0; i < taken.size(); ++i) taken[i] += value[static_cast<long>(j)] * law[j].unit[i];
  }
}

void SelfConsistency::replace(const std::vector<LawColumn>& before, const Eigen::VectorXd& before_value,
                              const std::vector<LawColumn>& law, const Eigen::VectorXd& value) {
  take_out(before, -before_value);
  take_out(law, value);
  settle();
}

/// Nuisances, `others`, the law and last the readings as they are with what was applied of the law put back, all in
/// units of the deviation that remains.
Eigen::MatrixXd SelfConsistency::beside_nuisances(const std::vector<LawColumn>& others,
                                                  const std::vector<LawColumn>& law,
                                                  const Eigen::VectorXd& applied) const {
  const Eigen::MatrixXd O = whitened(others), C = whitened(law);
  Eigen::MatrixXd columns(N_.rows(), N_.cols() + O.cols() + C.cols() + 1);
  columns << N_, O, C, (applied.size() > 0 ? (y_ + C * applied).eval() : y_);
  return columns / std::sqrt(std::max(1.0, dispersion()));
}

std::vector<LawColumn> SelfConsistency::offsets_of_rests() const {
  std::vector<LawColumn> out;
  for (const auto& w : rest_)
    for (int k = 0; k < 3; ++k) {
      out.push_back({kGyr, std::vector<Vec3>(recording_.size(), Vec3::Zero())});
      for (std::size_t i = w.first; i <= w.last; ++i) out.back().unit[i] = Vec3::Unit(k);
    }
  return out;
}

BesideWander SelfConsistency::beside_wander(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const {
  const std::vector<LawColumn> offsets = offsets_of_rests();
  const Eigen::MatrixXd lower = products(beside_nuisances(offsets, law, applied));
  const Eigen::MatrixXd gram = lower.selfadjointView<Eigen::Lower>();
  const auto wandering = static_cast<long>(offsets.size()), coefficients = static_cast<long>(law.size());
  const long nuisances = N_.cols() + wandering, all = nuisances + coefficients;
  const Eigen::VectorXd b = gram.col(all).head(all), b_alone = b.head(nuisances);
  Eigen::VectorXd prior_sd(nuisances);
  prior_sd.head(N_.cols()) = prior_sd_;
  double best_without = -HUGE_VAL, best_with = -HUGE_VAL;
  BesideWander out;
  for (const double times : kWanders) {
    prior_sd.tail(wandering).setConstant(times * cell_radps());
    Eigen::MatrixXd A = gram.topLeftCorner(all, all);
    A.diagonal().head(nuisances) += prior_sd.cwiseAbs2().cwiseInverse();
    A.diagonal().tail(coefficients) *= 1.0 + 1e-9;
    const Eigen::LDLT<Eigen::MatrixXd> alone(A.topLeftCorner(nuisances, nuisances)), beside(A);
    const double volume = -0.5 * alone.vectorD().cwiseAbs().array().log().sum() - prior_sd.array().log().sum();
    best_without = std::max(best_without, volume + 0.5 * b_alone.dot(alone.solve(b_alone)));
    const double with = volume + 0.5 * b.dot(beside.solve(b));
    if (with <= best_with) continue;
    best_with = with;
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(all, all).rightCols(coefficients);
    out.sd = beside.solve(unit).bottomRows(coefficients).diagonal().cwiseAbs().cwiseSqrt();
  }
  out.gain_nats = best_with - best_without;
  return out;
}

HeldOutGain SelfConsistency::held_out(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const {
  const Eigen::MatrixXd columns = beside_nuisances({}, law, applied);
  const auto coefficients = static_cast<long>(law.size());
  Eigen::VectorXd information(columns.cols());
  information << prior_sd_.cwiseAbs2().cwiseInverse(),
      kFree * columns.middleCols(N_.cols(), coefficients).colwise().squaredNorm().transpose(), 0.0;
  const double span_s = recording_.t_s(recording_.size() - 1) - recording_.t_s(0);
  const auto blocks = std::min<std::size_t>(kMostFolds, static_cast<std::size_t>(span_s / kBlock_s) + 1);
  std::vector<std::vector<long>> rows(blocks);
  for (long i = 0; i < y_.size(); ++i)
    rows[static_cast<std::size_t>((recording_.t_s(row_of(i)) - recording_.t_s(0)) / kBlock_s) % blocks].push_back(i);
  std::erase_if(rows, [](const std::vector<long>& r) { return r.empty(); });
  HeldOutGain gain;
  if (rows.size() < 2) return gain;
  std::vector<Eigen::MatrixXd> of_block;
  Eigen::MatrixXd all = information.asDiagonal();
  for (const auto& r : rows) all += of_block.emplace_back(products(columns(r, Eigen::all)));
  const double whole = gain_of_last(all, coefficients);
  for (const Eigen::MatrixXd& block : of_block) {
    const double nats = whole - gain_of_last(all - block, coefficients);
    gain.nats += nats, gain.blocks_better += nats > 0, ++gain.blocks;
  }
  return gain;
}

void SelfConsistency::add_nuisances(const Eigen::MatrixXd& C) {
  const Eigen::MatrixXd NC = N_.transpose() * C;
  const Eigen::MatrixXd S = C.transpose() * C - NC.transpose() * gram_.solve(NC);
  const Eigen::VectorXd value = S.ldlt().solve(C.transpose() * y_);
  y_ -= C * value - N_ * gram_.solve(NC * value);
  Eigen::MatrixXd wider(N_.rows(), N_.cols() + C.cols());
  wider << N_, C;
  N_ = std::move(wider);
  Eigen::VectorXd prior(N_.cols());
  prior << prior_sd_, C.colwise().norm().transpose().cwiseInverse() * 1e4;  // next to free
  prior_sd_ = prior;
  Eigen::MatrixXd gram = products(N_);
  gram.diagonal() += information();
  gram_.compute(gram);
}

void SelfConsistency::accept(const std::vector<LawColumn>& law) {
  accepted_.push_back(law);
  add_nuisances(whitened(law));
}

SelfConsistency::Series SelfConsistency::series(Sensor sensor, const std::vector<LawColumn>& law,
                                                const Eigen::VectorXd& applied) const {
  Series out;
  const Eigen::MatrixXd white = whitened(law), raw = columns(law), nuisance = nuisance_columns();
  const Eigen::VectorXd value = law.empty() ? Eigen::VectorXd() : fit(law, applied).value;
  const Eigen::VectorXd before_value = applied.size() > 0 ? applied : Eigen::VectorXd::Zero(value.size()).eval();
  // Before: the residual with the nuisances alone at their best. Explained: the law, less what the nuisances give back.
  const auto given_back = [&](const Eigen::VectorXd& v) {
    const Eigen::VectorXd x = gram_.solve(N_.transpose() * (white * v));
    return (raw * v - nuisance * x.head(nuisance.cols())).eval();
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
