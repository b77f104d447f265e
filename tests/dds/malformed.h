/// A stranger that publishes, under the names of our topics and types, payloads that are no message of that type.
#pragma once
#include <gtest/gtest.h>
#include <stillpoint_idl/ros2PubSubTypes.h>
#include <stillpoint_idl/stillpointPubSubTypes.h>

#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "io/dds_entities.h"

namespace stillpoint::test {

/// Writes the bytes it is given in place of a message.
template <class PubSubType>
class Bytes : public PubSubType {
 public:
  Bytes() { this->m_typeSize = 4096; }
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<const std::string*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<const std::string*>(data)->size()); };
  }
  bool is_bounded() const override { return false; }
  bool is_plain() const override { return false; }
};

/// Cut anywhere, of no known encapsulation, with a text that ends beyond the payload.
inline std::array<std::string, 4> malformed_payloads() {
  const std::string header("\0\1\0\0", 4);
  return {header, header + "abc", std::string("\x77\x77\0\0", 4) + std::string(64, '\1'),
          header + std::string(60, '\xff')};
}

class MalformedPublisher {
 public:
  explicit MalformedPublisher(const io::DdsParams& params) {
    auto entities = io::DdsEntities::create(params, "udp", "stranger");
    EXPECT_TRUE(entities) << entities.error().message;
    entities_ = std::move(*entities);
    add<msg::AttitudePubSubType>(params.attitude_topic, io::attitude_writer_qos("udp"));
    add<msg::RawImuPubSubType>(params.raw_topic, io::reliable_writer_qos(64, false));
    add<msg::CalibrationStatePubSubType>(params.calibration_topic, io::reliable_writer_qos(8, true));
    add<msg::DiagnosticsPubSubType>(params.diagnostics_topic, io::reliable_writer_qos(8, true));
    add<sensor_msgs::msg::ImuPubSubType>("rt/imu/data_raw", io::reliable_writer_qos(64, false));
    add<sensor_msgs::msg::MagneticFieldPubSubType>("rt/imu/mag", io::reliable_writer_qos(64, false));
  }

  /// Each payload some times on each topic, in half a second.
  void write_all() {
    for (int round = 0; round < 25; ++round) {
      for (std::string& payload : payloads_)
        for (auto* writer : writers_) writer->write(&payload);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

 private:
  template <class PubSubType>
  void add(const std::string& topic, const io::dds::DataWriterQos& qos) {
    const auto writer = entities_->writer(topic, io::dds::TypeSupport(new Bytes<PubSubType>), qos);
    EXPECT_TRUE(writer) << writer.error().message;
    writers_.push_back(*writer);
  }
  std::unique_ptr<io::DdsEntities> entities_;
  std::vector<io::dds::DataWriter*> writers_;
  std::array<std::string, 4> payloads_ = malformed_payloads();
};

}  // namespace stillpoint::test
