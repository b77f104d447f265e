/// Recordings: the CSV of docs/formats.md, read whole, with every irregularity counted and located.
#pragma once
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"
#include "core/units.h"
#include "io/text_file.h"

namespace stillpoint::io {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// How often something was met, and the first line where it was (0: never).
struct Irregularity {
  std::size_t count = 0;
  std::size_t first_line = 0;
  void note(std::size_t line) {
    if (count++ == 0) first_line = line;
  }
};

/// What a recording holds that a careful reader must know about. Rows named here as dropped are not in the columns.
struct RecordingIssues {
  Irregularity not_finite;           ///< NaN or infinity in a field; taken as not measured
  Irregularity repeated_time;        ///< row dropped
  Irregularity backward_time;        ///< row dropped
  Irregularity gap;                  ///< a sensor's step longer than 2.5 times its own median step; rows are kept
  Irregularity malformed;            ///< row dropped (only when the reader is told to go on)
  bool truncated_last_line = false;  ///< the last row was cut short; dropped
  double longest_gap_s = 0.0;
  std::vector<std::string> unknown_columns;
  std::vector<std::string> malformed_messages;  ///< "file:line:column: ..." for the first few malformed rows

  [[nodiscard]] std::size_t dropped_rows() const {
    return repeated_time.count + backward_time.count + malformed.count + (truncated_last_line ? 1 : 0);
  }
};

/// Columns of one recording; every non-empty column has one entry per row, kMissing where nothing was measured.
/// Readings in counts stay counts: the header's unit says so and `in_counts` is set for that sensor.
struct Recording {
  std::map<std::string, std::string> header;  ///< the "# key: value" lines
  std::vector<std::int64_t> t_ns;
  std::vector<Vec3> acc_mps2, gyr_radps, mag_uT;  ///< empty vector: no such columns
  std::vector<double> temp_degC, current_A, supply_V;
  std::vector<Eigen::Vector4d> ref_q_world_body;  ///< w, x, y, z
  std::vector<Vec3> ref_position_m;
  std::vector<double> ref_moving;
  std::map<std::string, std::vector<double>> user_columns;  ///< those of other names, kept for who asks for them
  bool acc_in_counts = false, gyr_in_counts = false, mag_in_counts = false;
  RecordingIssues issues;

  [[nodiscard]] std::size_t size() const { return t_ns.size(); }
  [[nodiscard]] double t_s(std::size_t row) const { return in_seconds(t_ns[row]); }
  /// Median time step in seconds; 0 with fewer than two rows.
  [[nodiscard]] double median_step_s() const;
  /// Row as the sensor's sample. A triad with a missing axis is not in the sample.
  [[nodiscard]] RawSample sample(std::size_t row) const;
};

/// When one sensor was read. Sensors have rates of their own: a row without a sensor is no gap of it.
struct SensorTimes {
  const char* name;  ///< as in its columns: acc, gyr, mag, temp
  std::size_t readings = 0;
  double median_step_s = 0.0;  ///< 0 with fewer than two readings
  double longest_gap_s = 0.0;  ///< of its gaps; 0 without one
  std::size_t gaps = 0;
};

enum class OnMalformedRow { kFail, kCount };

/// Reads a recording. Fails on: no such file (66), no or incomplete columns, malformed rows (65, all of the first ten
/// are named by line and column) unless they are to be counted.
[[nodiscard]] Result<Recording> read_recording(const std::string& path, OnMalformedRow policy = OnMalformedRow::kFail);

/// The same from text already in memory; `name` stands for the file in messages.
[[nodiscard]] Result<Recording> parse_recording(std::string_view text, const std::string& name,
                                                OnMalformedRow policy = OnMalformedRow::kFail);

/// Writes the non-empty columns; "-" is standard output. Fails with 73, as OutputFile.
[[nodiscard]] Result<void> write_recording(const Recording& recording, const std::string& path);

/// The same in parts: the header lines and the names of the non-empty columns, then rows of those very columns.
[[nodiscard]] Result<void> write_header(const Recording& recording, OutputFile& file);
[[nodiscard]] Result<void> write_rows(const Recording& recording, OutputFile& file);

/// The sensors that were read at all, in the order acc, gyr, mag, temp.
[[nodiscard]] std::vector<SensorTimes> sensor_times(const Recording& recording);

/// Fills the gaps of the issues; `lines` are those of the rows in their file.
void find_gaps(Recording& recording, const std::vector<std::size_t>& lines);

/// The irregularities in words, one a line, empty when there are none.
[[nodiscard]] std::vector<std::string> describe(const RecordingIssues& issues);

}  // namespace stillpoint::io
