/// What wanders beside a law: the offset of the gyroscope from leg to leg, that of the magnetometer from stretch to
/// stretch, and the acceleration of a body that seems to rest: a vehicle at speed, a ship, a drone that hovers.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kStretch_s = 5.0;
constexpr double kMostStretches = 60.0;  // a walk of more numbers says no more
constexpr double kFixed = 1e-9;          // the first of a walk is the offset itself

/// What is tried: steps of the two walks, in deviations of a cell's mean and of a reading of the field, and
/// accelerations in m/s^2.
const std::array<std::vector<double>, 3> kTried{{{0.02, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0},
                                                 {0.001, 0.02, 0.04, 0.08, 0.16, 0.32},
                                                 {1e-6, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0}}};
using Choice = std::array<std::size_t, 3>;

/// One after the other until nothing is better; `worth` in nats.
template <class Worth>
Choice most_likely(const Worth& worth) {
  Choice best{0, 0, 0};
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t what = 0; what < kTried.size(); ++what)
      for (std::size_t at = 0; at < kTried[what].size(); ++at) {
        Choice other = best;
        other[what] = at;
        if (worth(other) > worth(best)) best = other, changed = true;
      }
  }
  return best;
}

Sparse side_by_side(const Sparse& a, const Sparse& b) {
  Sparse out(a.rows(), a.cols() + b.cols());
  out.leftCols(a.cols()) = a;
  out.rightCols(b.cols()) = b;
  return out;
}

}  // namespace

/// The nuisances with what wanders behind the attitudes of the legs, and a law beside them. An offset of the gyroscope
/// turns the attitude of all that comes after its leg: the attitudes of the legs hold that already, and it is in what
/// they depart by from the leg before.
class SelfConsistency::Wandering {
 public:
  Wandering(const SelfConsistency& model, const std::vector<LawColumn>& law, const Eigen::VectorXd& applied)
      : m_(model), law_(std::ssize(law)), variance_(std::max(1.0, model.dispersion())) {
    for (std::size_t k = 0; k < m_.knots_.size(); ++k)
      legs_.push_back({std::max(m_.knots_[k], m_.first_row()),
                       (k + 1 < m_.knots_.size() ? m_.knots_[k + 1] : m_.recording_.size()) - 1});
    for (const RestWindow& leg : legs_) turns_.push_back(turns_in(leg));
    stretches_ = m_.mag_rows_.empty() ? 0 : stretch_of(m_.mag_rows_.back()) + 1;
    departures_ = departures();
    NuisanceColumns columns = m_.N_;
    columns.local = side_by_side(m_.N_.local, m_.whitener_ * this->columns());
    readings_ = Normal(columns, m_.beside_nuisances(law, applied));
  }

  struct Weighed {
    double without = 0.0, with = 0.0;  ///< nats, of the readings without and with the law
    Eigen::VectorXd sd;                ///< of the law's values
  };
  const Weighed& weigh(const Choice& choice) {
    const auto [found, is_new] = weighed_.try_emplace(choice);
    if (is_new) found->second = weighed(choice);
    return found->second;
  }
  Choice likeliest_without() {
    return most_likely([this](const Choice& c) { return weigh(c).without; });
  }
  Choice likeliest_with() {
    return most_likely([this](const Choice& c) { return weigh(c).with; });
  }

  /// The first numbers of the model, and their covariance.
  [[nodiscard]] Estimate numbers(const Choice& choice, long count) const {
    const Normal normal = expecting(choice);
    const NuisanceSolver solver(normal.nuisances);
    const Eigen::VectorXd all = settled() + solver.solve(normal.across.col(law_));
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(solver.rows(), count);
    unit.topRows(count).setIdentity();
    return {all.head(count), variance_ * solver.solve(unit).topRows(count)};
  }

 private:
  /// How an offset has turned the attitude at every row of the leg, world frame, and last at its end.
  [[nodiscard]] std::vector<Mat3> turns_in(const RestWindow& leg) const {
    const auto& r = m_.recording_;
    std::vector<Mat3> turns;
    Mat3 sum = Mat3::Zero();
    for (std::size_t i = leg.first; i <= leg.last; ++i) {
      if (i > 0) sum -= 0.5 * (r.t_s(i) - r.t_s(i - 1)) * m_.R_[i];
      turns.push_back(sum);
      if (i + 1 < r.size()) sum -= 0.5 * (r.t_s(i + 1) - r.t_s(i)) * m_.R_[i];
    }
    turns.push_back(sum);
    return turns;
  }

  [[nodiscard]] long stretch_of(std::size_t row) const {
    return static_cast<long>((m_.recording_.t_s(row) - m_.recording_.t_s(m_.first_row())) /
                             std::max(kStretch_s, m_.span_s() / kMostStretches));
  }

  /// Not yet whitened.
  [[nodiscard]] Sparse columns() const {
    Triplets entries;
    const auto nm = static_cast<long>(m_.mag_rows_.size()), nc = static_cast<long>(m_.cells_.size());
    long column = 0;
    const auto cells_of = [&](const RestWindow& window, long from) {
      for (long c = 0; c < nc; ++c) {
        const std::size_t row = m_.cells_[static_cast<std::size_t>(c)].first;
        if (row >= window.first && row <= window.last) put_turn(entries, from + c, nc, column, Mat3::Identity());
      }
    };
    for (const Turned& reading : m_.turned_) {
      const std::size_t leg = m_.knot_after(reading.row) - 1;
      put_turn(entries, reading.at, reading.apart, 3 * static_cast<long>(leg),
               reading.by * turns_[leg][reading.row - legs_[leg].first]);
    }
    for (const RestWindow& leg : legs_) cells_of(leg, 3 * nm + 3 * nc), column += 3;
    for (long i = 0; i < nm; ++i)
      put_turn(entries, i, nm, column + 3 * stretch_of(m_.mag_rows_[static_cast<std::size_t>(i)]), Mat3::Identity());
    column += 3 * stretches_;
    for (const RestWindow& rest : m_.rest_) cells_of(rest, 3 * nm), column += 3;
    return assembled<Sparse>(3 * nm + 6 * nc, column, entries);
  }

  /// Legs and stretches each from the one before.
  [[nodiscard]] Sparse departures() const {
    Triplets entries;
    for (int j = 0; j < m_.departures_.outerSize(); ++j)
      for (Sparse::InnerIterator at(m_.departures_, j); at; ++at)
        entries.emplace_back(static_cast<int>(at.row()), static_cast<int>(at.col()), at.value());
    long column = m_.numbers();
    for (long leg = 0; leg + 1 < std::ssize(legs_); ++leg)
      put_turn(entries, kLegsAt + 3 * (leg + 1), 1, column + 3 * leg, -turns_[static_cast<std::size_t>(leg)].back());
    const auto put_own = [&](long count, bool walk) {
      for (long k = 0; k < count; ++k, column += 3) {
        put_turn(entries, column, 1, column, Mat3::Identity());
        if (walk && k > 0) put_turn(entries, column, 1, column - 3, -Mat3::Identity());
      }
    };
    put_own(std::ssize(legs_), true);
    put_own(stretches_, true);
    put_own(std::ssize(m_.rest_), false);
    return assembled<Sparse>(column, column, entries);
  }

  /// How far the departures may go.
  [[nodiscard]] Eigen::VectorXd expected(const Choice& choice) const {
    const long known = m_.numbers(), accepted = m_.prior_sd_.size() - known, wander = departures_.cols() - known;
    Eigen::VectorXd sd(known + wander + accepted);
    sd.head(known) = m_.prior_sd_.head(known);
    sd.tail(accepted) = m_.prior_sd_.tail(accepted);
    long at = known;
    const auto walk = [&](long steps, double step) {
      sd.segment(at, 3 * steps).setConstant(step);
      sd.segment(at, std::min(3L, 3 * steps)).setConstant(kFixed);
      at += 3 * steps;
    };
    walk(std::ssize(legs_), kTried[0][choice[0]] * m_.cell_radps());
    walk(stretches_,
         m_.simulation_.magnetometer ? kTried[1][choice[1]] * m_.simulation_.magnetometer->noise_sd : kFixed);
    sd.segment(at, 3 * std::ssize(m_.rest_)).setConstant(kTried[2][choice[2]]);
    return sd;
  }

  /// Without wander, as the model has settled.
  [[nodiscard]] Eigen::VectorXd settled() const {
    const long known = m_.numbers(), accepted = m_.settled_.size() - known;
    Eigen::VectorXd all = Eigen::VectorXd::Zero(departures_.cols() + accepted);
    all.head(known) = m_.settled_.head(known);
    all.tail(accepted) = m_.settled_.tail(accepted);
    return all;
  }

  [[nodiscard]] Normal expecting(const Choice& choice) const {
    Normal normal = readings_;
    normal.expect(information(departures_, expected(choice), variance_), settled());
    return normal;
  }

  [[nodiscard]] Weighed weighed(const Choice& choice) const {
    const LeftOver left = left_over(expecting(choice));
    Weighed w;
    w.without =
        -0.5 * (left.beside(law_, law_) / variance_ + left.log_determinant) - expected(choice).array().log().sum();
    w.with = w.without;
    if (law_ == 0) return w;
    Eigen::MatrixXd S = left.beside.topLeftCorner(law_, law_);
    S.diagonal() += 1e-9 * readings_.beside.diagonal().head(law_);
    const Eigen::LDLT<Eigen::MatrixXd> solver(S);
    const Eigen::VectorXd b = left.beside.col(law_).head(law_);
    w.with += 0.5 * b.dot(solver.solve(b)) / variance_;
    w.sd = (variance_ * solver.solve(Eigen::MatrixXd::Identity(law_, law_))).diagonal().cwiseAbs().cwiseSqrt();
    return w;
  }

  const SelfConsistency& m_;
  long law_, stretches_ = 0;
  double variance_;
  std::vector<RestWindow> legs_;          ///< from knot to knot
  std::vector<std::vector<Mat3>> turns_;  ///< in each
  Sparse departures_;
  Normal readings_;
  std::map<Choice, Weighed> weighed_;
};

BesideWander SelfConsistency::beside_wander(const std::vector<LawColumn>& law, const Eigen::VectorXd& applied) const {
  Wandering wandering(*this, law, applied);
  const auto& with = wandering.weigh(wandering.likeliest_with());
  return {with.with - wandering.weigh(wandering.likeliest_without()).without, with.sd};
}

double SelfConsistency::acceleration_at_rest_mps2() const {
  return kTried[2][Wandering(*this, {}, {}).likeliest_without()[2]];
}

SelfConsistency::Estimate SelfConsistency::numbers_beside_wander(long count) const {
  Wandering wandering(*this, {}, {});
  return wandering.numbers(wandering.likeliest_without(), count);
}

}  // namespace stillpoint::diag::detail
