/// The expressions that are looked at: scalar and vector factors, functions of them, memory, events and couplings.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "diagnosis/discovery/grid.h"
#include "diagnosis/reference/signals.h"
#include "laws/evaluate.h"

namespace stillpoint::diag {

/// One expression, or two that belong together (sine and cosine), with at most one number left open: "{}" in the text.
struct Idea {
  std::vector<std::string> texts;
  std::string shape_name, shape_unit;  ///< of the open number; empty: there is none
  std::vector<double> shapes{0.0};     ///< where it is looked for, ascending
  bool matrix = false;                 ///< of a vector: through a full matrix, else axis by axis
  std::vector<double> points{};        ///< of a table: where its points lie; empty: it is a formula
  std::size_t steps = 0;               ///< taken from the first level on

  [[nodiscard]] std::string text(std::size_t part, double shape) const;
};

/// Everything of the first level. Thresholds and widths lie where the driver is.
[[nodiscard]] std::vector<Idea> first_ideas(const Sensor sensor, const laws::Columns& drivers);

/// Products of three of which one is a vector through a matrix, and products of two of which one has a memory: what
/// shows nothing of itself in any single text of the first level, as its factors swing about zero.
[[nodiscard]] std::vector<Idea> wider_ideas(const laws::Columns& drivers);

/// A line at each of these frequencies whose amplitude follows a driver, as the ripple of a current does, or that
/// stands in the world, as a magnet does that spins there.
[[nodiscard]] std::vector<Idea> line_ideas(const laws::Columns& drivers, std::span<const double> lines_hz);

/// A step of the offset or of the matrix at each of these moments, and what settles after it.
[[nodiscard]] std::vector<Idea> event_ideas(Sensor sensor, std::span<const double> moments_s);

/// A free function of each number that is recorded and of each axis of the vectors.
[[nodiscard]] std::vector<Idea> table_ideas(const laws::Columns& drivers);

/// The texts of numbers that others may be multiplied by.
[[nodiscard]] std::vector<std::string> scalar_factors(const laws::Columns& drivers);

/// Those and the axes of the vectors.
[[nodiscard]] std::vector<std::string> scalar_leaves(const laws::Columns& drivers);

/// The lag of one of these.
[[nodiscard]] std::string lag_of(const std::string& scalar, const std::string& tau = "{}");

[[nodiscard]] laws::Signature signature_of(const laws::Columns& drivers);

}  // namespace stillpoint::diag
