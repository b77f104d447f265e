/// A discovery server as `fastdds discovery -i ID -l 127.0.0.1 -p PORT` is one, for tests and benches.
#pragma once
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>

#include "io/dds_servers.h"

namespace stillpoint::test {

class DiscoveryServer {
 public:
  DiscoveryServer(std::size_t id, std::uint16_t port) : port_(port) {
    namespace dds = eprosima::fastdds::dds;
    dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
    auto& wire = qos.wire_protocol();
    wire.builtin.discovery_config.discoveryProtocol = eprosima::fastrtps::rtps::DiscoveryProtocol::SERVER;
    const auto prefix = io::server_prefix(id);
    std::copy(prefix.begin(), prefix.end(), wire.prefix.value);
    eprosima::fastrtps::rtps::Locator_t here;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(here, "127.0.0.1");
    here.port = port;
    wire.builtin.metatrafficUnicastLocatorList.push_back(here);
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(0, qos);
  }
  ~DiscoveryServer() {
    if (participant_ != nullptr)
      eprosima::fastdds::dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  DiscoveryServer(const DiscoveryServer&) = delete;
  DiscoveryServer& operator=(const DiscoveryServer&) = delete;
  [[nodiscard]] bool started() const { return participant_ != nullptr; }
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  std::uint16_t port_;
  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
};

}  // namespace stillpoint::test
