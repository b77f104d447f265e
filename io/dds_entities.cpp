#include "io/dds_entities.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>

#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <algorithm>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <mutex>
#include <set>

#include "io/dds_addresses.h"
#include "io/dds_participant.h"
#include "io/log_line.h"

#ifdef __SANITIZE_ADDRESS__
// libfastrtps 2.9.1 deletes its StatisticsWriterImpl through a base of another size; AddressSanitizer would end there.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" const char* __asan_default_options() { return "new_delete_type_mismatch=0"; }
#endif

namespace stillpoint::io {
namespace {

using Code = eprosima::fastrtps::types::ReturnCode_t;

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
    log_line(fmt::format("fast dds: {}: {}", entry.context.category != nullptr ? entry.context.category : "",
                         entry.message));
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
  in_addr asked{};
  const auto all = local_addresses();
  return inet_pton(AF_INET, address.c_str(), &asked) == 1 &&
         std::find(all.begin(), all.end(), asked.s_addr) != all.end();
}

/// Each once: a program has several participants with the same keys.
void warn_once(const std::vector<std::string>& lines) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  for (const auto& line : lines)
    if (said.insert(line).second) log_line("dds: " + line);
}

Result<void> expect_usable(const DdsParams& params) {
  std::vector<std::string> faults = check(params);
  for (const auto& fault : check(params.security)) faults.push_back("security: " + fault);
  std::string all;
  for (const auto& fault : faults) all += (all.empty() ? "dds: " : "\ndds: ") + fault;
  if (!all.empty()) return fail(ErrorKind::kBadConfig, all);
  warn_once(warnings(params.security));
  return {};
}

}  // namespace

Result<std::unique_ptr<DdsEntities>> DdsEntities::create(const DdsParams& params, const std::string& transport,
                                                         const std::string& name,
                                                         std::unique_ptr<NeighbourWatch> watch) {
  send_log_to_standard_error();
  if (const auto usable = expect_usable(params); !usable) return tl::unexpected(usable.error());
  if (params.interface != "any" && !address_is_local(params.interface))
    return fail(ErrorKind::kUnavailable,
                fmt::format("dds: no interface of this machine is up with the address {}; `ip -4 addr` lists them",
                            params.interface));
  std::unique_ptr<DdsEntities> entities(new DdsEntities);
  entities->secured_ = is_secured(params.security);
  keep_participants_apart();
  auto* factory = dds::DomainParticipantFactory::get_instance();
  entities->neighbours_ = std::move(watch);
  // With its listener from the start: a neighbour that is found before a listener is set would never be told of.
  entities->participant_ = factory->create_participant(
      static_cast<dds::DomainId_t>(params.domain), participant_qos(params, transport, name, entities->gate_),
      entities->neighbours_.get(), dds::StatusMask::offered_incompatible_qos());
  if (entities->participant_ == nullptr)
    return fail(
        ErrorKind::kUnavailable,
        fmt::format("dds: no participant could be created in domain {} over {} ({}); are its UDP ports from {} on "
                    "free, and /dev/shm writable?{}",
                    params.domain, transport, params.interface, 7400 + 250 * params.domain,
                    is_secured(params.security) ? " Do its permissions let it into this domain?" : ""));
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
  const bool known = !participant_->find_type(type.get_type_name()).empty();  // two topics may share one
  if (!known && type.register_type(participant_) != Code::RETCODE_OK)
    return fail(ErrorKind::kUnavailable,
                fmt::format("dds: type {} is already registered otherwise", type.get_type_name()));
  auto* topic = participant_->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  if (topic == nullptr)
    return fail(ErrorKind::kBadConfig,
                fmt::format("dds: topic '{}' cannot be created; do two topics have that name?", name));
  return topic;
}

tl::unexpected<Error> DdsEntities::refused(const char* endpoint, const std::string& topic) const {
  return fail(ErrorKind::kUnavailable,
              fmt::format("dds: no {} could be created for '{}'; Fast DDS's reason stands above{}", endpoint, topic,
                          secured_ ? ". Do the permissions of dds.security allow the topic?" : ""));
}

Result<dds::DataWriter*> DdsEntities::writer(const std::string& name, const dds::TypeSupport& type,
                                             const dds::DataWriterQos& qos) {
  const auto made = topic(name, type);
  if (!made) return tl::unexpected(made.error());
  auto* writer = publisher_->create_datawriter(*made, qos);
  if (writer == nullptr) return refused("writer", name);
  return writer;
}

Result<dds::DataReader*> DdsEntities::reader(const std::string& name, const dds::TypeSupport& type,
                                             const dds::DataReaderQos& qos, dds::DataReaderListener* listener) {
  const auto made = topic(name, type);
  if (!made) return tl::unexpected(made.error());
  auto* reader = subscriber_->create_datareader(*made, qos, listener);
  if (reader == nullptr) return refused("reader", name);
  return reader;
}

}  // namespace stillpoint::io
