/// When a line of one frequency is there, and whether the sensor has it or the reference brings it in.
#pragma once
#include "diagnosis/reference/scan.h"
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// The stretch in which the line stands; not local where it stands everywhere.
[[nodiscard]] Window stretch_of_line(const Series3& left, const Layout& layout, const Series& t_s, double frequency_Hz,
                                     double step_s);

/// Whether the reading alone shows the line that the residual shows, of the same size and phase: a camera's own lines
/// and the beat of its frames with the rows do not. False also where motion at this frequency hides the answer.
[[nodiscard]] bool stands_in_reading(const Signals& s, Sensor sensor, const Series3& left, const Window& window,
                                     double frequency_Hz);

/// Whether the readings of another sensor swing at this frequency, too: then the body does, or something shakes all of
/// them.
[[nodiscard]] bool others_swing_too(const Signals& s, Sensor sensor, const Window& window, double frequency_Hz);

/// Whether the line of the reading swells and fades while it stands, as a body's vibration does with the speed of its
/// engine. What a sensor's electronics do is always the same, or gone.
[[nodiscard]] bool swells(const Signals& s, Sensor sensor, const Window& window, double frequency_Hz);

/// Whether the readings beside the line, faster than limbs and vehicles move, hold far more than the sensor's noise: a
/// machine shakes the body there, at all frequencies and at that of the line.
[[nodiscard]] bool shakes_beside(const Signals& s, Sensor sensor, const Window& window, double frequency_Hz);

}  // namespace stillpoint::diag
