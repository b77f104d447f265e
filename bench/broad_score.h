/// BROAD's own score (Laidig, Caruso, Cereatti, Seel, "BROAD - A Benchmark for Robust Inertial Orientation Estimation",
/// Data 2021) and the trials that the folder ../shared/recordings/broad holds.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "core/units.h"
#include "io/recording.h"

namespace stillpoint::bench {

struct Trial {
  std::string name;
  io::Recording recording;
};

/// RMSE in degrees over the rows whose reference is there and moves.
struct Score {
  double total = 0.0, heading = 0.0, inclination = 0.0;
};

/// Gathers q_e = q_est conj(q_ref) in the ENU world: total 2 acos|w|, heading 2 atan|z/w|, inclination 2 acos sqrt(w^2
/// + z^2).
class Scorer {
 public:
  void add(const Quat& estimate, const Eigen::Vector4d& reference_wxyz, double moving) {
    if (!(moving == 1.0) || !reference_wxyz.allFinite()) return;
    const Quat reference =
        Quat(reference_wxyz(0), reference_wxyz(1), reference_wxyz(2), reference_wxyz(3)).normalized();
    const Quat e = estimate * reference.conjugate();
    const double total = 2.0 * std::acos(std::min(1.0, std::abs(e.w())));
    const double heading = 2.0 * std::atan2(std::abs(e.z()), std::abs(e.w()));
    const double inclination = 2.0 * std::acos(std::min(1.0, std::hypot(e.w(), e.z())));
    total2_ += total * total;
    heading2_ += heading * heading;
    inclination2_ += inclination * inclination;
    ++n_;
  }
  [[nodiscard]] Score score() const {
    const auto rms = [this](double sum) {
      return n_ > 0 ? std::sqrt(sum / static_cast<double>(n_)) * kDegPerRad : 0.0;
    };
    return {rms(total2_), rms(heading2_), rms(inclination2_)};
  }

 private:
  double total2_ = 0.0, heading2_ = 0.0, inclination2_ = 0.0;
  std::size_t n_ = 0;
};

/// Every trial of the folder in the order of its number; empty when the folder is absent or cannot be read.
inline std::vector<Trial> read_trials(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code absent;
  for (const auto& entry : std::filesystem::directory_iterator(folder, absent)) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Trial> trials;
  for (const auto& file : files) {
    if (Result<io::Recording> read = io::read_recording(file.string())) {
      trials.push_back({file.stem().string(), std::move(*read)});
    } else {
      std::fprintf(stderr, "%s\n", read.error().message.c_str());
    }
  }
  return trials;
}

}  // namespace stillpoint::bench
