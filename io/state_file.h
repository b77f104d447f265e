/// Keeps what was learnt about one sensor across restarts: versioned, checksummed, never half written (docs/daemon.md).
/// DIR/ID.state is the newest; DIR/ID.1.state, DIR/ID.2.state, ... are the good ones before it.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace stillpoint::io {

/// One state file: what was learnt, and about which sensor.
struct StateFile {
  std::string sensor_id;
  std::vector<std::byte> payload;
  [[nodiscard]] std::string_view text() const {
    return {reinterpret_cast<const char*>(payload.data()), payload.size()};
  }
};
/// Fails with 66 (not there) or 65 (not a state file, cut short, damaged).
[[nodiscard]] Result<StateFile> read_state_file(const std::string& path);
/// Temporary file beside it, fsync, rename, fsync of the folder. Fails with 73; what was there stays.
[[nodiscard]] Result<void> write_state_file(const std::string& path, const StateFile& state);

class Descriptor;

class StateStore {
 public:
  /// `sensor_id` may not hold '/'. `keep` versions stay, the newest included.
  StateStore(std::string directory, std::string sensor_id, int keep);

  /// Creates the folder, tries to write there and locks the sensor's files against a second daemon, before anything is
  /// learnt that could not be kept. Fails with 73, with 69 where another daemon has the lock. The lock ends with the
  /// process, however that ends.
  [[nodiscard]] Result<void> claim();

  /// Temporary file, fsync, the older ones moved up, rename, fsync of the folder. Fails with 73; the older ones stay.
  /// A folder that was claimed and has been removed since is claimed again.
  [[nodiscard]] Result<void> save(std::span<const std::byte> payload);

  struct Loaded {
    std::vector<std::byte> payload;      ///< empty: nothing usable was found
    std::string file;                    ///< where it came from
    std::vector<std::string> set_aside;  ///< what was damaged, in words; those files are renamed, never deleted
  };
  /// The newest file that is whole and that `why_not` has nothing against; the others are set aside like damaged ones.
  [[nodiscard]] Loaded load(const std::function<std::string(std::span<const std::byte>)>& why_not) const;

  [[nodiscard]] std::string path(int age = 0) const;

 private:
  [[nodiscard]] std::string lock_file() const;

  std::string directory_, sensor_id_;
  int keep_;
  std::shared_ptr<const Descriptor> lock_;
};

}  // namespace stillpoint::io
