/// Faults of the digital path as findings. The catalogue has no entries for them, as no simulation of physics makes
/// them: they are said as unknown to it, by what they are.
#include "diagnosis/forensics/examination.h"
#include "diagnosis/forensics/faults.h"

namespace stillpoint::diag::detail {

void Examination::examine_random_repeats(Sensor s) {
  const std::vector<std::size_t> rows = find_random_repeats(axes_[s], duplicate_);
  if (rows.empty()) return;
  for (const std::size_t r : rows) mute(s, r);
  Finding f = make(fmt::format("unknown:repeats({})", kSensorName[s]), {channel(s, 0), channel(s, 1), channel(s, 2)},
                   rows.front(), rows.back());
  const auto n = static_cast<double>(recording_.size()), k = static_cast<double>(rows.size());
  const double half = 1.96 * std::sqrt(k * (1.0 - k / n)) / n;
  f.parameters = {{"rate", k / n, {k / n - half, k / n + half}, "1"}};
  f.equation = "y_k = y_(k-1) at random rows, in this sensor alone";
  f.driver = "the bus: readings of this sensor that were not renewed";
  f.regime = fmt::format("{} of {} rows repeat the reading before in all three axes", rows.size(), recording_.size());
  f.decided_by = "already decided: the values are equal; a data-ready flag in the recording would mark each";
  state(std::move(f), rows.size());
}

void Examination::examine_bit_flips(Sensor s) {
  std::vector<std::string> channels;
  std::vector<std::size_t> rows;
  BitFlips all;
  for (int i = 0; i < 3; ++i) {
    const auto flips = find_bit_flips(axes_[s][static_cast<std::size_t>(i)]);
    if (!flips) continue;
    channels.push_back(channel(s, i));
    rows.insert(rows.end(), flips->rows.begin(), flips->rows.end());
    all.lowest_bit = std::min(all.lowest_bit, flips->lowest_bit);
    all.highest_bit = std::max(all.highest_bit, flips->highest_bit);
  }
  if (rows.empty()) return;
  for (const std::size_t r : rows) mute(s, r);
  const auto [first, last] = std::minmax_element(rows.begin(), rows.end());
  Finding f = make(fmt::format("unknown:bit_flips({})", kSensorName[s]), std::move(channels), *first, *last);
  const double k = static_cast<double>(rows.size()), n = static_cast<double>(recording_.size());
  f.parameters = {{"rate", k / n, {(k - 1.96 * std::sqrt(k)) / n, (k + 1.96 * std::sqrt(k)) / n}, "1"}};
  f.equation = "single readings off by 2^b steps";
  f.driver = "the digital path: bits that flip";
  f.regime = fmt::format("{} readings are off their neighbours by 2^{} to 2^{} steps", rows.size(), all.lowest_bit,
                         all.highest_bit);
  f.decided_by = "already decided: only bits make powers of two; a checksum on the bus would mark each";
  state(std::move(f), rows.size());
}

void Examination::examine_codes(Sensor s) {
  std::vector<std::string> channels;
  std::string what;
  for (int i = 0; i < 3; ++i) {
    const auto missing = find_missing_codes(axes_[s][static_cast<std::size_t>(i)]);
    if (!missing) continue;
    channels.push_back(channel(s, i));
    what = fmt::format("codes {} modulo {} never occur, {:.0f} readings were due", fmt::join(missing->absent, ", "),
                       missing->modulus, missing->expected);
  }
  if (channels.empty()) return;
  Finding f =
      make(fmt::format("unknown:missing_codes({})", kSensorName[s]), std::move(channels), 0, recording_.size() - 1);
  f.equation = "codes of the converter that it never gives: a stuck bit, or missing codes";
  f.driver = "the converter";
  f.regime = std::move(what);
  f.decided_by = "already decided: the readings pass these codes and never take them";
  state(std::move(f), 0);
}

}  // namespace stillpoint::diag::detail
