#include "io/dds_entities.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <algorithm>
#include <cstdio>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <mutex>
#include <set>

#ifdef __SANITIZE_ADDRESS__
// libfastrtps 2.9.1 deletes its StatisticsWriterImpl through a base of another size; AddressSanitizer would end there.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" const char* __asan_default_options() { return "new_delete_type_mismatch=0"; }
#endif

namespace stillpoint::io {
namespace {

namespace rtps = eprosima::fastdds::rtps;
using Code = eprosima::fastrtps::types::ReturnCode_t;

// The default of 4 is the number of participants of one machine that find each other by unicast; the fifth is silently
// alone.
constexpr std::uint32_t kParticipantsPerMachine = 50;
constexpr std::int32_t kLease_s = 5, kAnnouncement_s = 1;  // Fast DDS: 20 and 3
constexpr std::uint32_t kSocketBuffer_bytes = 1U << 20U;   // some 2000 attitudes: half a second at 4 kHz
constexpr std::uint32_t kSharedSegment_bytes = 2U << 20U;

/// Participants of one process talk through the transport, as those of two do. Fast DDS 2.9.1 would hand their
/// discovery on by pointers, and one that ends while the other still holds its readers crashes: in 8 of 360 daemons
/// that were ended just after their start. Counts before the first participant only.
void keep_participants_apart() {
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
}

/// Standard output belongs to the program (`--json -`), so the library's complaints go to standard error.
class ToStandardError : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    std::fprintf(stderr, "fast dds: %s: %s\n", entry.context.category != nullptr ? entry.context.category : "",
                 entry.message.c_str());
  }
};

void send_log_to_standard_error() {
  static std::once_flag once;
  std::call_once(once, [] {
    dds::Log::ClearConsumers();
    dds::Log::RegisterConsumer(std::make_unique<ToStandardError>());
    dds::Log::SetVerbosity(dds::Log::Kind::Error);
  });
}

/// Whether an interface of this machine has the address. Fast DDS itself goes on with a whitelist that matches nothing.
bool address_is_local(const std::string& address) {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return false;
  bool found = false;
  for (const ifaddrs* i = all; i != nullptr && !found; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET || (i->ifa_flags & IFF_UP) == 0) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto* in = reinterpret_cast<const sockaddr_in*>(i->ifa_addr);
    inet_ntop(AF_INET, &in->sin_addr, text, sizeof text);
    found = address == text;
  }
  freeifaddrs(all);
  return found;
}

dds::DomainParticipantQos participant_qos(const DdsParams& params, const std::string& transport,
                                          const std::string& name) {
  dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
  qos.name(name.c_str());
  qos.transport().use_builtin_transports = false;
  // A killed peer keeps its shared memory port until its lease ends, and its successor on that port gets nothing until
  // then.
  qos.wire_protocol().builtin.discovery_config.leaseDuration = {kLease_s, 0};
  qos.wire_protocol().builtin.discovery_config.leaseDuration_announcementperiod = {kAnnouncement_s, 0};
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
  if (params.interface != "any") udp->interfaceWhiteList.push_back(params.interface);
  qos.transport().user_transports.push_back(udp);
  if (params.interface == "127.0.0.1") {
    // Loopback carries no multicast, so peers are looked for at the known ports of this machine.
    eprosima::fastrtps::rtps::Locator_t peer;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(peer, params.interface);
    qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  }
  return qos;
}

}  // namespace

std::vector<std::string> check(const DdsParams& p) {
  std::vector<std::string> faults;
  if (p.transport != "udp" && p.transport != "shm" && p.transport != "data_sharing")
    faults.push_back(fmt::format("transport '{}' is not known; use udp, shm or data_sharing", p.transport));
  in_addr address{};
  if (p.interface != "any" && inet_pton(AF_INET, p.interface.c_str(), &address) != 1)
    faults.push_back(fmt::format(
        "interface '{}' is not an IPv4 address; use 127.0.0.1, another address of this machine, or any", p.interface));
  if (p.attitude_topic.empty()) faults.emplace_back("attitude_topic is empty; every daemon publishes its attitude");
  if (p.calibration_topic.empty()) faults.emplace_back("calibration_topic is empty");
  if (p.diagnostics_topic.empty()) faults.emplace_back("diagnostics_topic is empty");
  std::set<std::string> names;
  for (const auto& topic : {p.attitude_topic, p.calibration_topic, p.diagnostics_topic, p.raw_topic})
    if (!topic.empty() && !names.insert(topic).second)
      faults.push_back(
          fmt::format("two topics are named '{}'; each has a type of its own and needs a name of its own", topic));
  return faults;
}

Result<std::unique_ptr<DdsEntities>> DdsEntities::create(const DdsParams& params, const std::string& transport,
                                                         const std::string& name,
                                                         std::unique_ptr<NeighbourWatch> watch) {
  send_log_to_standard_error();
  if (const auto faults = check(params); !faults.empty()) {
    std::string all;
    for (const auto& fault : faults) all += (all.empty() ? "dds: " : "\ndds: ") + fault;
    return fail(ErrorKind::kBadConfig, all);
  }
  if (params.interface != "any" && !address_is_local(params.interface))
    return fail(ErrorKind::kUnavailable,
                fmt::format("dds: no interface of this machine is up with the address {}; `ip -4 addr` lists them",
                            params.interface));
  std::unique_ptr<DdsEntities> entities(new DdsEntities);
  keep_participants_apart();
  auto* factory = dds::DomainParticipantFactory::get_instance();
  entities->neighbours_ = std::move(watch);
  // With its listener from the start: a neighbour that is found before a listener is set would never be told of.
  entities->participant_ =
      factory->create_participant(static_cast<dds::DomainId_t>(params.domain), participant_qos(params, transport, name),
                                  entities->neighbours_.get(), dds::StatusMask::offered_incompatible_qos());
  if (entities->participant_ == nullptr)
    return fail(
        ErrorKind::kUnavailable,
        fmt::format("dds: no participant could be created in domain {} over {} ({}); are its UDP ports from {} on "
                    "free, and /dev/shm writable?",
                    params.domain, transport, params.interface, 7400 + 250 * params.domain));
  entities->publisher_ = entities->participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  entities->subscriber_ = entities->participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  if (entities->publisher_ == nullptr || entities->subscriber_ == nullptr)
    return fail(ErrorKind::kUnavailable,
                "dds: Fast DDS refused to create a publisher and a subscriber; its reason stands above");
  return entities;
}

DdsEntities::~DdsEntities() {
  if (participant_ == nullptr) return;
  stop();
  participant_->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

DdsEntities::DdsEntities() = default;

void DdsEntities::stop() noexcept {
  participant_->set_listener(nullptr);
  if (subscriber_ == nullptr) return;
  std::vector<dds::DataReader*> readers;
  subscriber_->get_datareaders(readers);
  for (auto* reader : readers) reader->set_listener(nullptr);
  subscriber_->delete_contained_entities();
}

Result<dds::Topic*> DdsEntities::topic(const std::string& name, const dds::TypeSupport& type) {
  if (type.register_type(participant_) != Code::RETCODE_OK)
    return fail(ErrorKind::kUnavailable,
                fmt::format("dds: type {} is already registered otherwise", type.get_type_name()));
  auto* topic = participant_->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  if (topic == nullptr)
    return fail(ErrorKind::kBadConfig,
                fmt::format("dds: topic '{}' cannot be created; do two topics have that name?", name));
  return topic;
}

Result<dds::DataWriter*> DdsEntities::writer(const std::string& name, const dds::TypeSupport& type,
                                             const dds::DataWriterQos& qos) {
  const auto made = topic(name, type);
  if (!made) return tl::unexpected(made.error());
  auto* writer = publisher_->create_datawriter(*made, qos);
  if (writer == nullptr)
    return fail(ErrorKind::kUnavailable,
                fmt::format("dds: no writer could be created for '{}'; Fast DDS's reason stands above", name));
  return writer;
}

Result<dds::DataReader*> DdsEntities::reader(const std::string& name, const dds::TypeSupport& type,
                                             const dds::DataReaderQos& qos, dds::DataReaderListener* listener) {
  const auto made = topic(name, type);
  if (!made) return tl::unexpected(made.error());
  auto* reader = subscriber_->create_datareader(*made, qos, listener);
  if (reader == nullptr)
    return fail(ErrorKind::kUnavailable,
                fmt::format("dds: no reader could be created for '{}'; Fast DDS's reason stands above", name));
  return reader;
}

namespace {

template <class Qos>
void limit(Qos& qos, int depth) {
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  qos.resource_limits().max_samples = depth;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().allocated_samples = std::min(depth, 64);
}

template <class Qos>
void share_data(Qos& qos, const std::string& transport) {
  if (transport == "data_sharing")
    qos.data_sharing().automatic();
  else
    qos.data_sharing().off();
}

}  // namespace

dds::DataWriterQos attitude_writer_qos(const std::string& transport) {
  constexpr int kDepth = 64;  // data sharing: how far the readers may fall behind before they lose samples
  dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
  limit(qos, kDepth);
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_MEMORY_MODE;
  share_data(qos, transport);
  return qos;
}

dds::DataReaderQos attitude_reader_qos(const std::string& transport) {
  constexpr int kDepth = 256;
  dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
  limit(qos, kDepth);
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_MEMORY_MODE;
  share_data(qos, transport);
  return qos;
}

dds::DataWriterQos reliable_writer_qos(int depth, bool for_late_joiners) {
  dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
  limit(qos, depth);
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = for_late_joiners ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  // A reader that asks again must not wait for the default heartbeat of 3 s.
  qos.reliable_writer_qos().times.heartbeatPeriod = {0, 100'000'000};
  qos.data_sharing().off();
  return qos;
}

dds::DataReaderQos reliable_reader_qos(int depth, bool late_joiner) {
  dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
  limit(qos, depth);
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = late_joiner ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
  return qos;
}

}  // namespace stillpoint::io
