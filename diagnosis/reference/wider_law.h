/// A law that has the stated one as a part - linear in temperature, linear and square - is no rival that cannot be
/// excluded: its further terms are numbers, and the recording bounds them.
#pragma once
#include <cstddef>
#include <optional>

#include "diagnosis/reference/selection.h"
#include "diagnosis/result.h"

namespace stillpoint::diag {

/// The law of the catalogue with all terms of finding `index` and more, fitted in its place; none: there is no such
/// law.
[[nodiscard]] std::optional<WiderLaw> wider_law(const SensorSearch& search, std::size_t index);

}  // namespace stillpoint::diag
