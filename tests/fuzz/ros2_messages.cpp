/// Messages of a ROS 2 driver: payload, message, reading, stamp. Several in one input, as they arrive.
#include <stillpoint_idl/ros2PubSubTypes.h>

#include "sources/ros2_convert.h"
#include "sources/stamps.h"
#include "tests/fuzz/cdr.h"
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices input(data, size);
  sensor_msgs::msg::Imu imu;
  sensor_msgs::msg::MagneticField field;
  sources::Stamps stamps(0.0);
  for (std::int64_t arrival_ns = 1'000'000'000; !input.rest().empty(); arrival_ns += 10'000'000) {
    const std::uint8_t kind = input.byte();
    const std::string_view payload = input.bytes(2 * std::size_t{input.byte()});
    sources::Reading reading;
    if (kind % 2 == 0 && fuzz::deserialize<sensor_msgs::msg::ImuPubSubType>(payload, imu))
      reading = sources::from_ros2(imu, kind % 4 == 0);
    if (kind % 2 == 1 && fuzz::deserialize<sensor_msgs::msg::MagneticFieldPubSubType>(payload, field))
      reading = sources::from_ros2(field, kind % 4 == 1);
    for (const auto* vector : {&reading.sample.acc_mps2, &reading.sample.gyr_radps, &reading.sample.mag_uT})
      fuzz::expect(vec(*vector).allFinite(), "a reading is finite");
    for (const double sd : {reading.noise.acc_mps2, reading.noise.gyr_radps, reading.noise.mag_uT})
      fuzz::expect(sd >= 0.0 && sd <= 1000.0, "a noise is one");
    if (reading.sample.has != 0 && stamps.stamp(reading, arrival_ns, 1)) fuzz::taken();
    if (kind >= 0xf0) stamps.restart();  // the driver went and came back
  }
  return 0;
}
