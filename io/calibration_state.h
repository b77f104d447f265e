/// What the calibration has learnt as text, one number or list a line, with its unit (docs/formats.md), so that it can
/// be read, compared and checked field by field.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "calib_online/online_calibrator.h"
#include "core/result.h"

namespace stillpoint::io {

[[nodiscard]] std::string calibration_text(const calib::OnlineCalibrator& calibrator);

/// Takes what fits. The answer: what was converted or left out, and why, in words. Fails with 65, and nothing is
/// changed, where the text is none of this version.
[[nodiscard]] Result<std::vector<std::string>> restore_calibration(std::string_view text,
                                                                   calib::OnlineCalibrator& calibrator);

}  // namespace stillpoint::io
