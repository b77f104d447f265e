/// The expressions that are looked at: scalar and vector factors, functions of them, memory, events and couplings.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/reference/signals.h"
#include "laws/evaluate.h"

namespace stillpoint::diag {

/// One expression, or two that belong together (sine and cosine), with at most one number left open: "{}" in the text.
struct Idea {
  std::vector<std::string> texts;
  std::string shape_name, shape_unit;  ///< of the open number; empty: there is none
  std::vector<double> shapes{0.0};     ///< where it is looked for, ascending
  bool matrix = false;                 ///< of a vector: through a full matrix, else axis by axis

  [[nodiscard]] std::string text(std::size_t part, double shape) const;
};

/// Everything of the first level. Thresholds and widths lie where the driver is.
[[nodiscard]] std::vector<Idea> first_ideas(const Sensor sensor, const laws::Columns& drivers);

/// The texts of numbers that others may be multiplied by.
[[nodiscard]] std::vector<std::string> scalar_factors(const laws::Columns& drivers);

/// What could be meant where `best` (with its number) was: times a further factor, or, of an event, what settles after
/// it.
[[nodiscard]] std::vector<Idea> second_ideas(const Idea& best, double shape, const laws::Columns& drivers);

/// Of what settles after an event: the same with its time constant fixed and the moment open; nullopt for others.
[[nodiscard]] std::optional<Idea> moment_of(const Idea& best, double shape);

}  // namespace stillpoint::diag
