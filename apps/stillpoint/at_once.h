/// Independent work of a batch, several at once.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace stillpoint::app {

/// `one(i)` for every i below `count`, in whatever order, `jobs` of them beside one another; returns when all are done.
template <class One>
void at_once(std::size_t count, std::size_t jobs, const One& one) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) one(i);
  };
  std::vector<std::jthread> workers;
  for (std::size_t i = 0; i < std::min(jobs, count); ++i) workers.emplace_back(work);
}

/// As many as there are processors.
inline std::size_t processors() { return std::max(1U, std::thread::hardware_concurrency()); }

}  // namespace stillpoint::app
