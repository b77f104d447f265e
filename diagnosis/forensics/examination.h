/// The examination behind examine_raw_values(): what it looks at, and the findings it gathers. Repeats and lattices are
/// in forensics.cpp, rails and dead zones in examination_range.cpp.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/finding_effect.h"
#include "diagnosis/forensics/detail.h"
#include "diagnosis/forensics/forensics.h"

namespace stillpoint::diag::detail {

class Examination {
 public:
  Examination(const io::Recording& recording, const sim::SimulationConfig& simulation)
      : recording_(recording), simulation_(simulation) {
    for (const Sensor s : {kAcc, kGyr, kMag}) load(s);
  }

  [[nodiscard]] Forensics run();

 private:
  void load(Sensor s);

  [[nodiscard]] std::string channel(Sensor s, int axis) const {
    return fmt::format("{}_{}", kSensorName[s], "xyz"[axis]);
  }
  [[nodiscard]] double t(std::size_t row) const { return recording_.t_s(row); }

  Finding make(const std::string& id, std::vector<std::string> channels, std::size_t first, std::size_t last) const {
    Finding f;
    f.effect = id;
    f.channels = std::move(channels);
    f.interval_s = {t(first), t(last)};
    return f;
  }
  /// A lattice that is there in one part of the recording only; all other faults show where the motion shows them.
  [[nodiscard]] bool lasts_a_while_only(const Finding& f) const {
    const double span_s = t(recording_.size() - 1) - t(0);
    return f.effect.ends_with("_quant") && f.interval_s[1] - f.interval_s[0] < 0.95 * span_s;
  }
  void state(Finding f, std::size_t spoiled_rows) {
    if (contains(simulation_.effects, f.effect)) return;
    if (auto e = effect_of(f)) {
      if (lasts_a_while_only(f)) e->window_s = {f.interval_s[0] - t(0), f.interval_s[1] - t(0)};
      out_.effects.push_back(std::move(*e));
    }
    order_.emplace_back(spoiled_rows, std::move(f));
  }
  void mute(Sensor s, std::size_t row) {
    auto& m = out_.sensor[s].muted;
    if (m.empty()) m.assign(recording_.size(), 0);
    m[row] = 1;
  }
  void examine_duplicates();
  void examine_hold(Sensor s);
  void examine_rails(Sensor s);
  void examine_peaks(Sensor s);
  void examine_dead_zone();
  void examine_lattice(Sensor s);
  void examine_random_repeats(Sensor s);
  void examine_bit_flips(Sensor s);
  void examine_codes(Sensor s);

  const io::Recording& recording_;
  const sim::SimulationConfig& simulation_;
  std::array<std::vector<Axis>, 3> axes_;
  std::vector<std::uint8_t> duplicate_;
  std::vector<std::pair<std::size_t, Finding>> order_;
  Forensics out_;
};

}  // namespace stillpoint::diag::detail
