/// What the clock of the rows and the reference do to every sensor at once. It is looked for, and taken out of the
/// signals, before the sensors are searched one by one: each of them would see a part of it and give that another name.
#pragma once
#include "diagnosis/diagnose.h"
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// One rotation between the body of the reference and the sensors (ref_frame): wrong matrices of the sensors do not
/// agree by chance. Rotates all that the reference predicts into the sensors' frame.
void find_frame(Signals& s, const sim::SimulationConfig& given, Answer& answer);

/// Rows taken at random times (sys_jitter): white, along the derivative of each sensor, its variance proportional to
/// the squared derivative, which is told from noise across it. The time of each row is then estimated from all
/// channels.
void find_jitter(Signals& s, const sim::SimulationConfig& given, Answer& answer);

/// The reference's own error at rest, where the motion is known (ref_error). Held to what the simulation says of its
/// reference; where it says nothing the error is a notice, no finding.
void find_reference_error(const Signals& s, const io::Recording& recording, const sim::SimulationConfig& given,
                          Answer& answer);

/// Takes out what the simulation says that its reference is late by.
void set_reference_on_time(Signals& s, const sim::ReferenceConfig& reference);

/// Sensors that are late beside a measured reference by less than its time stamps are good for: that is written down as
/// the latency of the reference, as no other recording of the sensors would show it. Of less than a tenth of that no
/// finding is left, only a notice.
void leave_to_the_reference(const Signals& s, Answer& answer);

/// Takes out a slow turn of milliradians between a noisy reference and the sensors that two of them agree about, and
/// says so in a notice: gravity, the field and the rate would each be given a law of its own for it.
void take_out_wandering(Signals& s, Answer& answer);

/// Turns everything predicted by the reference, row by row: true vectors in the sensors' frame are exp(-phi) times the
/// body's.
void turn_into_sensor_frame(Signals& s, const Series3& phi_rad);
void turn_into_sensor_frame(Signals& s, const Vec3& phi_rad);

}  // namespace stillpoint::diag
