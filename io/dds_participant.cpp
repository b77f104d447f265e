#include "io/dds_participant.h"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <algorithm>
#include <filesystem>

#include "io/dds_servers.h"

namespace stillpoint::io {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastdds::rtps;

// The default of 4 is the number of participants of one machine that find each other by unicast; the fifth is silently
// alone.
constexpr std::uint32_t kParticipantsPerMachine = 50;
constexpr std::int32_t kLease_s = 5;                      // Fast DDS: 20
constexpr std::uint32_t kAnnouncement_ns = 500'000'000;   // Fast DDS: 3 s; a newcomer waits for the next one
constexpr std::uint32_t kSocketBuffer_bytes = 1U << 20U;  // some 2000 attitudes: half a second at 4 kHz
constexpr std::uint32_t kSharedSegment_bytes = 2U << 20U;

eprosima::fastrtps::rtps::Locator_t locator(const char* address, std::uint32_t port) {
  eprosima::fastrtps::rtps::Locator_t out;
  eprosima::fastrtps::rtps::IPLocator::setIPv4(out, address);
  out.port = port;
  return out;
}

constexpr const char* kLoopback = "127.0.0.1";

/// Where a participant that serves this machine alone announces itself: at the known ports of this machine, and to the
/// discovery group over loopback, for participants on ports of their own choice (Cyclone DDS by default). Every default
/// participant joins the group on some interface, and Linux then delivers what comes over another one too.
void look_for_peers_on_this_machine(int domain, dds::DomainParticipantQos& qos) {
  auto& peers = qos.wire_protocol().builtin.initialPeersList;
  peers.push_back(locator(kLoopback, 0));
  peers.push_back(locator("239.255.0.1", static_cast<std::uint32_t>(7400 + 250 * domain)));
}

/// Servers tell of the others; nobody is looked for, and who is not a client of one of them is not met.
void ask_servers(const std::vector<std::string>& servers, dds::DomainParticipantQos& qos) {
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.discoveryProtocol = eprosima::fastrtps::rtps::DiscoveryProtocol::CLIENT;
  for (std::size_t k = 0; k < servers.size(); ++k) {
    const auto server = parse_server(servers[k]);
    if (!server) continue;  // left out; what is wrong was refused before
    eprosima::fastdds::rtps::RemoteServerAttributes remote;
    const auto prefix = server_prefix(k);
    std::copy(prefix.begin(), prefix.end(), remote.guidPrefix.value);
    remote.metatrafficUnicastLocatorList.push_back(locator(server->address.c_str(), server->port));
    discovery.m_DiscoveryServers.push_back(remote);
  }
}

/// The properties of DDS-Security 1.1 (8.5 and 9), with the plugins that Fast DDS brings along.
void secure(const SecurityParams& params, dds::DomainParticipantQos& qos) {
  const SecurityParams files = with_folder(params);
  const auto set = [&qos](const char* name, const std::string& value) {
    qos.properties().properties().emplace_back(name, value);
  };
  const auto set_file = [&set](const char* name, const std::string& path) {
    set(name, "file://" + std::filesystem::absolute(path).string());
  };
  set("dds.sec.auth.plugin", "builtin.PKI-DH");
  set_file("dds.sec.auth.builtin.PKI-DH.identity_ca", files.identity_ca);
  set_file("dds.sec.auth.builtin.PKI-DH.identity_certificate", files.certificate);
  set_file("dds.sec.auth.builtin.PKI-DH.private_key", files.private_key);
  set("dds.sec.access.plugin", "builtin.Access-Permissions");
  set_file("dds.sec.access.builtin.Access-Permissions.permissions_ca", files.permissions_ca);
  set_file("dds.sec.access.builtin.Access-Permissions.governance", files.governance);
  set_file("dds.sec.access.builtin.Access-Permissions.permissions", files.permissions);
  set("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
}

}  // namespace

dds::DomainParticipantQos participant_qos(const DdsParams& params, const std::string& transport,
                                          const std::string& name, std::shared_ptr<GateCounts> gate) {
  dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
  qos.name(name.c_str());
  qos.transport().use_builtin_transports = false;
  // A killed peer keeps its shared memory port until its lease ends, and its successor on that port gets nothing until
  // then.
  qos.wire_protocol().builtin.discovery_config.leaseDuration = {kLease_s, 0};
  qos.wire_protocol().builtin.discovery_config.leaseDuration_announcementperiod = {0, kAnnouncement_ns};
  if (transport == "shm") {
    auto memory = std::make_shared<rtps::SharedMemTransportDescriptor>();
    memory->segment_size(kSharedSegment_bytes);
    qos.transport().user_transports.push_back(memory);
  }
  // Discovery runs over UDP in every case, and data too wherever the peers share no memory.
  auto udp = std::make_shared<rtps::UDPv4TransportDescriptor>();
  udp->maxInitialPeersRange = kParticipantsPerMachine;
  udp->sendBufferSize = kSocketBuffer_bytes;
  udp->receiveBufferSize = kSocketBuffer_bytes;
  udp->non_blocking_send = true;  // a full socket buffer costs the sample, never the sensor thread's time
  // Beside an address of the machine also loopback: a default participant here sends to 127.0.0.1 whatever it is told.
  if (params.interface != "any") udp->interfaceWhiteList.push_back(params.interface);
  if (params.interface != "any" && params.interface != kLoopback) udp->interfaceWhiteList.emplace_back(kLoopback);
  const GateParams door{.this_machine_only = params.interface == kLoopback,
                        .relays_announcements = !params.discovery_server.empty()};
  qos.transport().user_transports.push_back(std::make_shared<GateDescriptor>(udp, door, std::move(gate)));
  if (!params.discovery_server.empty())
    ask_servers(params.discovery_server, qos);
  else if (door.this_machine_only)
    look_for_peers_on_this_machine(params.domain, qos);
  if (is_secured(params.security)) secure(params.security, qos);
  return qos;
}

}  // namespace stillpoint::io
