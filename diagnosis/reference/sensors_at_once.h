/// What one sensor's search does without knowing of the others.
#pragma once
#include <future>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// `of(k)` for each sensor: beside one another, or one after another where the system gives no thread, or the rows are
/// so many that three searches at once would hold 360 MB: ten minutes at 200 Hz, thinned to 50, are to do with 250.
template <class Of>
void sensors_at_once(const Signals& s, const Of& of) {
  constexpr Eigen::Index kTooManyRows = 30000;
  const auto how = s.n >= kTooManyRows ? std::launch::deferred : std::launch::async | std::launch::deferred;
  std::array<std::future<void>, kSensors> running;
  for (const Sensor k : {kAcc, kGyr, kMag}) running[k] = std::async(how, [&of, k] { of(k); });
  for (auto& one : running) one.get();
}

}  // namespace stillpoint::diag
