/// A law sample by sample: for the simulator, which asks for it row after row. Drivers are functions of time, so that
/// rates and delays need no history; lag, play and integral keep their state.
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types.h"
#include "laws/expression.h"

namespace stillpoint::laws {

/// The value of a driver at a time; a number stands in all three components.
using DriverAt = std::function<Vec3(std::string_view driver, double t_s)>;

class Stream {
 public:
  /// Pre: checked. The law's time starts at `start_s`: a delay does not look further back.
  explicit Stream(Node tree, double start_s = 0.0);
  /// Times never go back. A number stands in all three components.
  [[nodiscard]] Vec3 next(const DriverAt& drivers, double t_s);
  [[nodiscard]] const Node& tree() const noexcept { return tree_; }

 private:
  struct State {
    bool started = false;
    double t_s = 0.0;
    Vec3 last = Vec3::Zero(), value = Vec3::Zero();
  };
  [[nodiscard]] Vec3 value(const Node& n, const DriverAt& drivers, double t_s);
  [[nodiscard]] Vec3 remembered(const Node& n, const DriverAt& drivers, double t_s);

  Node tree_;
  double start_s_;
  std::vector<State> states_;  ///< in the order in which the tree is walked
  std::size_t at_ = 0;         ///< of the state that is due in this walk
};

}  // namespace stillpoint::laws
