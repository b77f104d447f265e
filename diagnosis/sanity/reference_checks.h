/// The single questions that check_reference() asks, each on a Comparison.
#pragma once
#include "diagnosis/sanity/comparison.h"
#include "diagnosis/sanity/sanity.h"

namespace stillpoint::diag::detail {

/// In words the convention under which the sensors agree with the reference; null when it is none of the usual ones.
[[nodiscard]] const char* name_convention(const Comparison& c, const Sanity& known, bool with_position);

/// All sensors agree with the reference about the same other axes: its body is turned against the sensor's.
bool body_is_turned(const Comparison& c, Sanity& out);
/// Single sensors that agree with the reference only about other axes.
void check_axes(const Comparison& c, Sanity& out);

/// The position's axes, unit and clock against what the accelerometer felt; pre: the orientation is right.
void check_position(const io::Recording& recording, const sim::SimulationConfig& simulation, Sanity& out);

/// Time shift that brings the rate of the reference and of the gyro together, where it is too large for a delay.
void check_lateness(const Comparison& c, const io::Recording& recording, Sanity& out);

}  // namespace stillpoint::diag::detail
