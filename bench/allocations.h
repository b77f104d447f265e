/// Counts every malloc of the program it is linked into (not only operator new: Eigen's dynamic matrices use malloc).
#pragma once
#include <cstddef>

namespace stillpoint::bench {

[[nodiscard]] std::size_t allocations() noexcept;

}  // namespace stillpoint::bench
