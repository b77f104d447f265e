/// A subscriber as others write it: Fast DDS with nothing configured, or kept to loopback by a whitelist.
/// `plain_reader default|loopback DOMAIN` says "received" at the first rt/imu/data; code 1 when none came in 10 s.
#include <stillpoint_idl/ros2PubSubTypes.h>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

namespace {

namespace fast = eprosima::fastdds::dds;

fast::DomainParticipantQos loopback_only() {
  fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  return qos;
}

bool receives(fast::DataReader* reader) {
  sensor_msgs::msg::Imu message;
  fast::SampleInfo info;
  for (int i = 0; i < 10; ++i)
    if (reader->wait_for_unread_message({1, 0}) &&
        reader->take_next_sample(&message, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK &&
        info.valid_data)
      return true;
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 64;
  auto* factory = fast::DomainParticipantFactory::get_instance();
  auto* participant = factory->create_participant(
      static_cast<fast::DomainId_t>(std::atoi(argv[2])),
      std::strcmp(argv[1], "default") == 0 ? fast::PARTICIPANT_QOS_DEFAULT : loopback_only());
  if (participant == nullptr) return 2;
  const fast::TypeSupport type(new sensor_msgs::msg::ImuPubSubType);
  type.register_type(participant);
  auto* topic = participant->create_topic("rt/imu/data", type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  auto* reader = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)
                     ->create_datareader(topic, fast::DATAREADER_QOS_DEFAULT);
  const bool received = reader != nullptr && receives(reader);
  if (received) std::puts("received");
  std::fflush(stdout);
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return received ? 0 : 1;
}
