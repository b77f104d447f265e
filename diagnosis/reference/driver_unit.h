/// Units of the coefficients of products of drivers, from the names that the products are stated by.
#pragma once
#include <string>

namespace stillpoint::diag {

/// Of k in `delta = k DRIVER` where delta has the unit `of`: "rad/s per m/s^2 K" for f_z*(T-T0).
[[nodiscard]] std::string coefficient_unit(const std::string& of, const std::string& driver);

}  // namespace stillpoint::diag
