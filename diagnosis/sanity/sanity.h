/// Input that cannot be right, before anything is fitted to it: units, frames, handedness, missing or stuck columns,
/// too little data. A diagnosis of such input would blame physics for a typing error.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "diagnosis/forensics/forensics.h"

namespace stillpoint::diag {

struct Sanity {
  std::vector<std::string> notices;  ///< what looks wrong, with the likely mistake named and what to do
  std::array<bool, 3> unusable{};    ///< per Sensor: its readings must not be interpreted
  bool reference_unusable = false;   ///< the reference must not be interpreted
  bool nothing_usable = false;       ///< verdict: insufficient data
};

/// Needs no fit; cost is a few passes over the rows.
[[nodiscard]] Sanity check_input(const io::Recording& recording, const sim::SimulationConfig& simulation);

namespace detail {
/// The part that compares sensors with the reference; called by check_input when there is a reference orientation.
void check_reference(const io::Recording& recording, const sim::SimulationConfig& simulation, Sanity& out);
}  // namespace detail

}  // namespace stillpoint::diag
