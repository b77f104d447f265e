/// What of the nuisances reaches a few rows only: the attitude from knot to knot, and offsets of the gyroscope in the
/// rests. An offset turns the attitude of all that comes after its rest: the attitudes of the legs hold that already,
/// and it is in what they depart by from the leg before.
#include <algorithm>

#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

void put(Triplets& to, long row, long apart, long column, const Mat3& block) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      to.emplace_back(static_cast<int>(row + i * apart), static_cast<int>(column + j), block(i, j));
}

}  // namespace

std::size_t SelfConsistency::knot_after(std::size_t row) const {
  return static_cast<std::size_t>(std::upper_bound(knots_.begin(), knots_.end(), row) - knots_.begin());
}

/// How an offset has turned the attitude at every row of the rest, world frame, and last at its end.
std::vector<Mat3> SelfConsistency::turns_in(const RestWindow& rest) const {
  std::vector<Mat3> turns;
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = rest.first; i <= rest.last; ++i) {
    if (i > 0) sum -= 0.5 * (recording_.t_s(i) - recording_.t_s(i - 1)) * R_[i];
    turns.push_back(sum);
    if (i + 1 < R_.size()) sum -= 0.5 * (recording_.t_s(i + 1) - recording_.t_s(i)) * R_[i];
  }
  turns.push_back(sum);
  return turns;
}

Sparse SelfConsistency::local_columns() const {
  Triplets entries;
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  for (const Turned& reading : turned_)
    put(entries, reading.at, reading.apart, 3 * static_cast<long>(knot_after(reading.row) - 1), reading.by);
  long column = wander_at() - kLegsAt;
  for (const RestWindow& rest : rest_) {
    const std::vector<Mat3> turns = turns_in(rest);
    const std::size_t next = knot_after(rest.last), end = next < knots_.size() ? knots_[next] : recording_.size();
    for (const Turned& reading : turned_)
      if (reading.row >= rest.first && reading.row < end)
        put(entries, reading.at, reading.apart, column,
            reading.by * turns[std::min(reading.row - rest.first, turns.size() - 1)]);
    for (long c = 0; c < nc; ++c) {
      const Cell& cell = cells_[static_cast<std::size_t>(c)];
      if (cell.first >= rest.first && cell.last <= rest.last)
        put(entries, 3 * nm + 3 * nc + c, nc, column, Mat3::Identity());
    }
    column += 3;
  }
  return assembled<Sparse>(3 * nm + 6 * nc, column, entries);
}

Sparse SelfConsistency::departures() const {
  Triplets entries;
  for (long i = 0; i < x_.size(); ++i) entries.emplace_back(static_cast<int>(i), static_cast<int>(i), 1.0);
  for (long leg = kLegsAt + 3; leg < wander_at(); leg += 3) put(entries, leg, 1, leg - 3, -Mat3::Identity());
  long column = wander_at();
  for (const RestWindow& rest : rest_) {
    const std::size_t next = knot_after(rest.last);
    if (next < knots_.size()) put(entries, kLegsAt + 3 * static_cast<long>(next), 1, column, -turns_in(rest).back());
    column += 3;
  }
  return assembled<Sparse>(x_.size(), x_.size(), entries);
}

/// Of the prior, on the numbers themselves; what was accepted since is independent of all others.
Sparse SelfConsistency::information(const Eigen::VectorXd& prior_sd, double times) const {
  const Eigen::VectorXd weight = times * prior_sd.cwiseAbs2().cwiseInverse();
  Sparse out = Sparse(departures_.transpose()) * weight.head(x_.size()).asDiagonal() * departures_;
  out.conservativeResize(prior_sd.size(), prior_sd.size());
  for (long i = x_.size(); i < prior_sd.size(); ++i) out.coeffRef(i, i) = weight[i];
  return out;
}

}  // namespace stillpoint::diag::detail
