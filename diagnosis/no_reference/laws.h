/// The laws of docs/effects.md that gyroscope, magnetometer and rest windows can witness without a reference.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {

/// A law with its columns; a nonlinear parameter (time constant, step time) is searched on a grid.
struct WitnessedLaw {
  std::string id, equation, driver;
  Sensor sensor = kGyr;
  std::vector<std::string> names;  ///< of the coefficients, in the order of the columns
  std::string unit;                ///< of the coefficients; of those named k2 it is squared per kelvin: "/K^2" for "/K"
  std::string grid_name, grid_unit;  ///< empty: linear
  std::vector<double> grid;
  std::function<std::vector<LawColumn>(double)> columns;

  [[nodiscard]] std::size_t numbers() const { return names.size() + (grid_name.empty() ? 0 : 1); }
};

/// Those whose drivers the recording holds. The functions refer to `model`, which must outlive them.
[[nodiscard]] std::vector<WitnessedLaw> witnessed_laws(const SelfConsistency& model,
                                                       const sim::SimulationConfig& simulation);

/// An offset of its own in every rest (in neighbours together where there are very many): what no slow law can exceed.
/// Names a drift where nothing else reaches it.
[[nodiscard]] std::vector<LawColumn> free_offsets(const SelfConsistency& model, Sensor sensor);

}  // namespace stillpoint::diag::detail
