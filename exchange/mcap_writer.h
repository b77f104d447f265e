/// Readings as an MCAP file in the ROS 2 profile: sensor_msgs Imu, MagneticField and Temperature, in chunks of a second
/// with their index. What a power cut leaves is whole up to the last chunk.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/types.h"
#include "io/text_file.h"

namespace stillpoint::exchange {

class McapWriter {
 public:
  /// Fails with 73, as io::OutputFile.
  [[nodiscard]] static Result<McapWriter> create(const std::string& path);
  [[nodiscard]] Result<void> append(const RawSample& sample);
  /// Writes what is left, and the summary by which readers find their way.
  [[nodiscard]] Result<void> finish();
  [[nodiscard]] std::uint64_t rows() const { return rows_; }

 private:
  static constexpr std::size_t kTopics = 3;
  struct Entry {
    std::uint64_t t_ns, offset;
  };
  struct ChunkPlace {
    std::uint64_t first_ns, last_ns, start, length, index_length, size;
    std::array<std::uint64_t, kTopics> index_at;  ///< 0: no message of that topic
  };

  explicit McapWriter(io::OutputFile file) : file_(std::move(file)) {}
  [[nodiscard]] Result<void> write(const std::string& bytes);
  void add_message(std::size_t topic, std::uint64_t t_ns, const std::string& message);
  [[nodiscard]] Result<void> write_chunk();

  io::OutputFile file_;
  std::uint64_t at_ = 0, rows_ = 0;
  std::string chunk_;
  std::array<std::vector<Entry>, kTopics> index_;
  std::array<std::uint64_t, kTopics> messages_{};
  std::uint64_t first_ns_ = 0, last_ns_ = 0;
  std::vector<ChunkPlace> chunks_;
};

}  // namespace stillpoint::exchange
