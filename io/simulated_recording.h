/// Rows of the simulator as a recording.
#pragma once
#include <string>

#include "io/recording.h"
#include "simulation/recorded_motion.h"
#include "simulation/simulator.h"

namespace stillpoint::io {

/// Adds one row. Columns that a row does not carry stay kMissing; reference columns are there when the first row has
/// them.
void append(const sim::SimulatedSample& row, Recording& to);

[[nodiscard]] Recording to_recording(const std::vector<sim::SimulatedSample>& rows);

/// A file that simulated rows are written to as they come, a part at a time, so that memory does not grow with the
/// length of the recording; "-" is standard output. Fails with 73, as OutputFile.
class SimulatedRecordingFile {
 public:
  [[nodiscard]] static Result<SimulatedRecordingFile> create(const std::string& path,
                                                             const sim::SimulationConfig& config);
  [[nodiscard]] Result<void> add(const sim::SimulatedSample& row);
  /// Writes what is left.
  [[nodiscard]] Result<void> finish();

 private:
  SimulatedRecordingFile(OutputFile file, const sim::SimulationConfig& config);
  [[nodiscard]] Result<void> write_part();

  OutputFile file_;
  bool has_[3];  ///< acc, gyr, mag: columns of the file, whether a part holds a reading of them or not
  bool begun_ = false;
  Recording part_;
};

/// Reference columns as a track for sim::RecordedMotion; rows without a reference orientation are left out.
[[nodiscard]] sim::ReferenceTrack reference_track(const Recording& recording);

/// Measured temperature (its noise smoothed over a second), current, supply and user columns, on the clock of that
/// track.
[[nodiscard]] sim::RecordedEnvironment recorded_environment(const Recording& recording);

}  // namespace stillpoint::io
