/// Value lattices: the step on which the numbers of a column lie, and whether that step is a sensor's or only the
/// number of decimals with which the file was written.
#pragma once
#include <span>
#include <vector>

namespace stillpoint::diag {

/// y = origin + step * integer, up to the rounding of the file.
struct Lattice {
  double step = 0.0;     ///< 0: the values lie on no lattice coarser than the file's decimals
  double step_sd = 0.0;  ///< standard error of the step
  double origin = 0.0;
  bool decimal = false;  ///< the step is a power of ten in SI, g, degrees: as likely the writer's as the sensor's
};

/// Step of the decimals with which the values were written (in SI, g or degrees); relative 1e-12 where there is none.
[[nodiscard]] double printing_step(std::span<const double> values);

/// Approximate greatest common divisor of the differences of the values, given the file's own step.
[[nodiscard]] Lattice find_lattice(std::span<const double> values, double printed_step);

}  // namespace stillpoint::diag
