/// Counts every malloc of the program it is linked into (not only operator new: Eigen's dynamic matrices use malloc).
#pragma once
#include <cstddef>

namespace stillpoint::bench {

[[nodiscard]] std::size_t allocations() noexcept;
/// Those of the calling thread alone: Fast DDS's own threads allocate when a peer announces itself.
[[nodiscard]] std::size_t allocations_of_this_thread() noexcept;

}  // namespace stillpoint::bench
