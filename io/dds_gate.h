/// The transport between UDP and Fast DDS: what comes in is judged before Fast DDS reads it, and what participants of
/// this machine call themselves is turned into an address at which a loopback-only participant reaches them.
#pragma once
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>

#include <atomic>
#include <cstdint>
#include <memory>

#include "io/dds_admission.h"

namespace stillpoint::io {

/// What was not handed on, so far. Written by Fast DDS's receiving threads.
struct GateCounts {
  std::atomic<std::uint64_t> malformed{0};
  std::atomic<std::uint64_t> off_host{0};  ///< from another machine, where only this one is served
  std::atomic<std::uint64_t> flooded{0};   ///< announcements of too many new participants
};

struct GateParams {
  bool this_machine_only = true;
  bool relays_announcements = false;  ///< a discovery server hands on what others announced
};

struct GateDescriptor : public eprosima::fastdds::rtps::ChainingTransportDescriptor {
  GateDescriptor(std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> udp, const GateParams& with,
                 std::shared_ptr<GateCounts> to)
      : ChainingTransportDescriptor(std::move(udp)), params(with), counts(std::move(to)) {}
  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override;

  GateParams params;
  std::shared_ptr<GateCounts> counts;
};

}  // namespace stillpoint::io
