/// Input that cannot be right, before anything is fitted to it: units, frames, handedness, clocks, missing or stuck
/// columns, too little data. A diagnosis of such input would blame physics for a typing error.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "diagnosis/forensics/forensics.h"

namespace stillpoint::diag {

struct Sanity {
  std::vector<std::string> notices;   ///< what looks wrong, with the likely mistake named and what to do
  std::vector<std::string> mistakes;  ///< those of the notices that set a sensor or the reference aside
  std::array<bool, 3> unusable{};     ///< per Sensor: its readings must not be interpreted
  bool reference_unusable = false;    ///< the reference must not be interpreted
  bool position_unusable = false;     ///< of the reference only the orientation may be interpreted
  bool nothing_usable = false;        ///< verdict: insufficient data

  void mistake(std::string what) {
    notices.push_back(what);
    mistakes.push_back(std::move(what));
  }
  void set_aside(Sensor s, std::string what) {
    unusable[s] = true;
    mistake(std::move(what));
  }
};

/// Needs no fit; cost is a few passes over the rows.
[[nodiscard]] Sanity check_input(const io::Recording& recording, const sim::SimulationConfig& simulation);

namespace detail {
/// The parts of check_input, each in a file of its own.
void check_columns(const io::Recording& recording, const sim::SimulationConfig& simulation, Sanity& out);
void check_clock(const io::Recording& recording, const sim::SimulationConfig& simulation, Sanity& out);
void check_units(const io::Recording& recording, const sim::SimulationConfig& simulation, Sanity& out);
/// Compares sensors with the reference orientation; only where there is one.
void check_reference(const io::Recording& recording, const sim::SimulationConfig& simulation, Sanity& out);
}  // namespace detail

}  // namespace stillpoint::diag
