/// Sharp lines in a residual: mains or motor interference folded into the band, and flips of polarity from sample to
/// sample. Their frequency is not on any grid of the scan, and an autoregression takes them for noise: they are looked
/// for in the periodogram of the residual itself.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "diagnosis/reference/laws.h"
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

/// acc_alias, gyr_alias or gyr_coning, mag_line; mag_flip where the line lies at half the sampling rate;
/// kBodyVibration where the reference may not see it and it swells and fades, as no sensor's own line does, another
/// sensor swings, too, or a machine shakes the body beside it. The gain is left to the caller.
[[nodiscard]] std::optional<Found> line_in(const Signals& s, const SensorSearch& search);

/// The same from a frequency on; where motion hides whose the sharpest is, the sharpest beyond a higher one.
[[nodiscard]] std::optional<Found> line_beyond(const Signals& s, const SensorSearch& search, double lowest_Hz);

/// A line that was found, at the frequency that explains most beside all else that was found since.
void sharpen_line(const SensorSearch& without_it, Found& line);

/// What is said of a kBodyVibration.
[[nodiscard]] std::string vibration_notice(Sensor sensor, const Found& line);

[[nodiscard]] inline bool is_line(std::string_view id) {
  return id.ends_with("_alias") || id.ends_with("_coning") || id == "mag_line" || id == kBodyVibration;
}

/// The sharpest line of these rows, if there is one: in the whole, or in a half or a quarter that it fills better.
[[nodiscard]] std::optional<double> sharpest_line_Hz(const Series3& left, const Series& t_s, double step_s);

/// Frequency of a line that is sharp in the axes of the world, where the motion does not smear it; needs attitudes.
[[nodiscard]] std::optional<double> line_in_world(const Signals& s, const SensorSearch& search);

}  // namespace stillpoint::diag
