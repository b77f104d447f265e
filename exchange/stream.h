/// Readings of one sensor at their own times: what every foreign file comes down to, and the way from there to a
/// recording.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "io/recording.h"

namespace stillpoint::exchange {

enum class Quantity { kAcc, kGyr, kMag, kTemp };
[[nodiscard]] const char* name(Quantity quantity);

struct Stream {
  Quantity quantity = Quantity::kAcc;
  std::string from;                ///< file and columns, or topic, for messages
  std::vector<std::int64_t> t_ns;  ///< in the file's own time base
  std::vector<Vec3> values;        ///< SI, uT, degC (x alone)

  void add(std::int64_t t, const Vec3& value) {
    t_ns.push_back(t);
    values.push_back(value);
  }
};

/// What came of a foreign file, and why it was read as it was.
struct Imported {
  io::Recording recording;
  std::vector<std::string> reasons;  ///< sentences for a person
};

/// One row for each time that any of them has, starting at 0; each stream is put in order first (order.h). Fails (65)
/// without an accelerometer or gyroscope, and where streams do not overlap in time.
[[nodiscard]] Result<Imported> merge(std::vector<Stream> streams, const std::string& name);

}  // namespace stillpoint::exchange
