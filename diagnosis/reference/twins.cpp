#include "diagnosis/reference/twins.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {
namespace {

constexpr std::uint64_t kSeed = 5;

/// Noise of the finished model: its random walk, then white draws through its filter.
class Drawn {
 public:
  Drawn(const SensorSearch& search, const Finished& finished, std::uint64_t seed)
      : search_(search), q_(finished.fit.walk_q), noise_(search.target.layout, finished.fit.leftover), engine_(seed) {}

  Series3 residual() {
    const Layout& layout = search_.target.layout;
    Series3 out(layout.n, 3);
    for (int axis = 0; axis < 3; ++axis) {
      Series white(layout.n);
      for (double& x : white) x = normal_(engine_);
      out.col(axis) = noise_.coloured(layout, white, axis);
      Eigen::VectorXd c = walk_deviations(search_.beside_walk(), q_[static_cast<std::size_t>(axis)]);
      for (double& x : c) x *= normal_(engine_);
      out.col(axis) += *search_.walk * c;
    }
    return out;
  }

 private:
  const SensorSearch& search_;
  std::array<double, 3> q_;
  NoiseModel noise_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

}  // namespace

std::vector<double> null_twins(const Signals& s, const SensorSearch& search, std::size_t count, std::uint64_t seed) {
  Drawn drawn(search, finish(search), seed);
  std::vector<double> scores;
  for (std::size_t i = 0; i < count; ++i) {
    SensorSearch twin = search;
    twin.found.clear();
    twin.first_gain = 0.0;
    twin.target.residual = drawn.residual();
    const auto best = next_effect(s, twin);
    scores.push_back(best ? best->net_nats : 0.0);
  }
  return scores;
}

std::vector<std::string> gate_by_twins(const Signals& s, EngineResult& result, std::size_t count) {
  std::vector<std::string> said;
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!result.sensor[k] || result.sensor[k]->found.empty()) continue;
    SensorSearch& search = *result.sensor[k];
    const std::vector<double> scores = null_twins(s, search, count, kSeed);
    const double highest = *std::max_element(scores.begin(), scores.end());
    const auto stated = std::count_if(scores.begin(), scores.end(), [](double x) { return x > 0; });
    said.push_back(fmt::format(
        "null twins of {}: {} of {} resimulations without what was found state a name, at {:.1f} nats at most",
        kSensorName[k], stated, count, highest));
    for (std::size_t i = search.found.size(); i-- > 0;) {
      if (search.found[i].net_nats > highest) continue;
      said.push_back(fmt::format("{} is not stated: its {:.1f} nats are what a twin without it reaches",
                                 search.found[i].id, search.found[i].net_nats));
      take_out(search, i);
    }
  }
  return said;
}

}  // namespace stillpoint::diag
