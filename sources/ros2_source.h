/// Readings of a ROS 2 driver: sensor_msgs/Imu and sensor_msgs/MagneticField, heard over DDS without ROS.
#pragma once
#include <memory>

#include "io/dds_params.h"
#include "io/source_config.h"
#include "pipeline/stage.h"
#include "sources/report.h"

namespace stillpoint::sources {

class Ros2Source {
 public:
  /// `dds` says which interfaces are used, and the domain where `params` names none. Fails as DdsEntities does.
  [[nodiscard]] static Result<Ros2Source> create(const io::Ros2Params& params, const io::DdsParams& dds);
  ~Ros2Source();
  Ros2Source(Ros2Source&&) noexcept;
  Ros2Source& operator=(Ros2Source&&) noexcept;

  /// Blocks for at most 100 ms. What this process publishes itself is not taken for a reading.
  pipeline::SourceState next(pipeline::Arrival& out) noexcept;
  [[nodiscard]] bool live() const noexcept { return true; }

  [[nodiscard]] ReportCell report() const noexcept;

 private:
  struct Impl;
  explicit Ros2Source(std::unique_ptr<Impl> impl) noexcept;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillpoint::sources
