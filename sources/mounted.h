/// Any source whose sensors sit in other axes than those of the common sensor frame.
#pragma once
#include <optional>
#include <utility>

#include "io/source_config.h"
#include "pipeline/stage.h"

namespace stillpoint::sources {

[[nodiscard]] inline RawSample mounted(RawSample sample, const io::SensorMounts& mounts) noexcept {
  const auto turn = [](const io::Mount& mount, Array3& reading) {
    reading = array(Vec3(mount.R_body_sensor * vec(std::as_const(reading))));
  };
  turn(mounts.accelerometer, sample.acc_mps2);
  turn(mounts.gyroscope, sample.gyr_radps);
  turn(mounts.magnetometer, sample.mag_uT);
  return sample;
}

template <pipeline::Source S>
class Mounted {
 public:
  Mounted(S source, std::optional<io::SensorMounts> mounts) noexcept : source_(std::move(source)), mounts_(mounts) {}
  pipeline::SourceState next(pipeline::Arrival& out) noexcept {
    const auto state = source_.next(out);
    if (mounts_ && state == pipeline::SourceState::kSample) out.sample = mounted(out.sample, *mounts_);
    return state;
  }
  void prepare() noexcept { pipeline::prepare(source_); }
  [[nodiscard]] bool live() const noexcept { return pipeline::is_live(source_); }

 private:
  S source_;
  std::optional<io::SensorMounts> mounts_;
};

}  // namespace stillpoint::sources
