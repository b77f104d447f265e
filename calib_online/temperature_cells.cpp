#include "calib_online/temperature_cells.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::calib {

void TemperatureCells::add(const Vec3& x, const Mat3& C, double temp_degC, double weight) noexcept {
  // Hat weights: a window between two cells belongs to both by its distance.
  const double position = std::clamp((temp_degC - params_.first_degC) / params_.spacing_K, 0.0, kCells - 1.0);
  const auto low = static_cast<std::size_t>(std::min(position, kCells - 2.0));
  const double share = position - static_cast<double>(low);
  Moments window;
  window.add_adjusted(x, C, weight);
  for (std::size_t k = 0; k < 2; ++k) {
    const double part = k == 0 ? 1.0 - share : share;
    if (part <= 0.0) continue;
    Moments portion = window;
    portion.forget(part);
    cells_[low + k].forget(1.0 - part * (1.0 - params_.keep));
    cells_[low + k].merge(portion);
  }
}

Moments TemperatureCells::near(double temp_degC) const noexcept {
  Moments sum;
  for (std::size_t k = 0; k < kCells; ++k) {
    const double distance =
        (params_.first_degC + params_.spacing_K * static_cast<double>(k) - temp_degC) / params_.kernel_K;
    Moments cell = cells_[k];
    cell.forget(std::exp(-0.5 * distance * distance));
    sum.merge(cell);
  }
  return sum;
}

Moments TemperatureCells::all() const noexcept {
  Moments sum;
  for (const Moments& cell : cells_) sum.merge(cell);
  return sum;
}

}  // namespace stillpoint::calib
