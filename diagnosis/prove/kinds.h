/// The kinds of sealed cases: how often each comes, which effects it draws from, and how strong they are.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "diagnosis/prove/draw.h"

namespace stillpoint::diag {

inline constexpr std::size_t kSlots = 40;  ///< after so many cases the kinds repeat

/// The kind of the case with this index.
[[nodiscard]] std::string kind_of(std::size_t index);

/// IDs of the effects of a case of this kind, drawn.
[[nodiscard]] std::vector<std::string> effects_of(Draw& draw, const std::string& kind);

/// Whether the coefficients of this effect are scaled to a drawn d'; the others keep the usual size of their
/// parameters.
[[nodiscard]] bool is_scaled(const std::string& id);

/// Least and largest d' of the effects of this kind.
using Range = std::array<double, 2>;
[[nodiscard]] Range range_of(const std::string& kind);

}  // namespace stillpoint::diag
