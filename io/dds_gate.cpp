#include "io/dds_gate.h"

#include <fastrtps/utils/IPLocator.h>

#include <cstring>

#include "core/clock.h"
#include "io/dds_addresses.h"

namespace stillpoint::io {
namespace {

namespace rtps = eprosima::fastdds::rtps;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;
using eprosima::fastrtps::rtps::octet;

std::uint32_t address_of(const Locator_t& locator) {
  std::uint32_t address = 0;
  std::memcpy(&address, IPLocator::getIPv4(locator), sizeof address);
  return address;
}

class Gate : public rtps::ChainingTransport {
 public:
  explicit Gate(const GateDescriptor& d) : ChainingTransport(d), descriptor_(d), params_(d.params), counts_(d.counts) {}

  rtps::TransportDescriptorInterface* get_configuration() override { return &descriptor_; }

  bool send(eprosima::fastrtps::rtps::SenderResource* below, const octet* data, std::uint32_t size,
            eprosima::fastrtps::rtps::LocatorsIterator* begin, eprosima::fastrtps::rtps::LocatorsIterator* end,
            const std::chrono::steady_clock::time_point& timeout) override {
    return below->send(data, size, begin, end, timeout);
  }

  void receive(rtps::TransportReceiverInterface* next, const octet* data, std::uint32_t size, const Locator_t& local,
               const Locator_t& remote) override {
    if (admit(const_cast<octet*>(data), size, remote)) next->OnDataReceived(data, size, local, remote);
  }

  /// A default participant of this machine names the address of its network interface. Fast DDS's whitelist would leave
  /// it out; the packets of a socket on 127.0.0.1 reach its socket, which listens on every address.
  bool transform_remote_locator(const Locator_t& remote, Locator_t& result) const override {
    if (!params_.this_machine_only || !IsLocatorSupported(remote) || IPLocator::isMulticast(remote))
      return ChainingTransport::transform_remote_locator(remote, result);
    if (!addresses_.has(address_of(remote))) return false;
    result = remote;
    IPLocator::setIPv4(result, "127.0.0.1");
    return true;
  }

 private:
  bool admit(octet* data, std::uint32_t size, const Locator_t& remote) {
    if (params_.this_machine_only && !addresses_.has(address_of(remote))) return count(counts_->off_host);
    const auto message = judge_rtps({data, size});
    if (!message) return count(counts_->malformed);
    if (params_.relays_announcements) return true;
    if (message->announces_for_another) return count(counts_->malformed);
    if (!message->announces_participant) return true;
    const std::uint64_t source = std::uint64_t{address_of(remote)} << 16U | IPLocator::getPhysicalPort(remote);
    return admission_.admit(message->sender, source, monotonic_ns()) || count(counts_->flooded);
  }
  static bool count(std::atomic<std::uint64_t>& counter) {
    counter.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  GateDescriptor descriptor_;
  GateParams params_;
  std::shared_ptr<GateCounts> counts_;
  mutable LocalAddresses addresses_;
  Admission admission_;
};

}  // namespace

rtps::TransportInterface* GateDescriptor::create_transport() const { return new Gate(*this); }

}  // namespace stillpoint::io
