#include "io/dds_neighbours.h"

#include <fmt/format.h>

#include <fastdds/dds/core/policy/QosPolicies.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>

#include "io/quote.h"

namespace stillpoint::io {
namespace {

namespace dds = eprosima::fastdds::dds;
using Writer = eprosima::fastrtps::rtps::WriterDiscoveryInfo;
using Participant = eprosima::fastrtps::rtps::ParticipantDiscoveryInfo;
using Reader = eprosima::fastrtps::rtps::ReaderDiscoveryInfo;

/// +1 for an endpoint that came, -1 for one that left or was lost, 0 for one that changed.
int change(const Writer& found) {
  return found.status == Writer::DISCOVERED_WRITER ? 1 : found.status == Writer::REMOVED_WRITER ? -1 : 0;
}
int change(const Reader& found) {
  return found.status == Reader::DISCOVERED_READER ? 1 : found.status == Reader::REMOVED_READER ? -1 : 0;
}

/// Fast DDS tells of one's own endpoints too.
template <class Found>
bool is_of_another(const Found& found, const dds::DomainParticipant& own) {
  return found.info.guid().guidPrefix != own.guid().guidPrefix;
}

std::string in_words(int policy) {
  switch (policy) {
    case dds::RELIABILITY_QOS_POLICY_ID:
      return "reliable delivery; this topic is best effort";
    case dds::DURABILITY_QOS_POLICY_ID:
      return "samples of the past (transient local); this topic is volatile";
    default:
      return fmt::format("more than is offered, by the quality-of-service policy {}", policy);
  }
}

}  // namespace

Neighbours NeighbourWatch::seen() const {
  const int refused = refused_.load();
  const std::lock_guard lock(mutex_);
  return {publishers_.load(),  of_other_type_.load(), refused, refused > 0 ? in_words(policy_.load()) : "",
          unreachable_.load(), unreachable_name_};
}

/// The transport has left out of its addresses those that it does not serve.
void NeighbourWatch::on_participant_discovery(dds::DomainParticipant*, Participant&& found) {
  if (found.status != Participant::DISCOVERED_PARTICIPANT) return;
  const auto& data = found.info.default_locators;
  if (!data.unicast.empty() || !data.multicast.empty()) return;
  const std::lock_guard lock(mutex_);
  unreachable_name_ = printable(found.info.m_participantName.c_str(), 60);
  ++unreachable_;
}

void NeighbourWatch::on_publisher_discovery(dds::DomainParticipant* own, Writer&& found) {
  if (found.info.topicName() != topic_.c_str() || !is_of_another(found, *own)) return;
  (found.info.typeName() == type_.c_str() ? publishers_ : of_other_type_) += change(found);
}

void NeighbourWatch::on_subscriber_discovery(dds::DomainParticipant* own, Reader&& found) {
  if (found.info.topicName() != topic_.c_str() || !is_of_another(found, *own)) return;
  if (found.info.typeName() != type_.c_str()) of_other_type_ += change(found);
}

void NeighbourWatch::on_offered_incompatible_qos(dds::DataWriter*, const dds::OfferedIncompatibleQosStatus& status) {
  policy_ = static_cast<int>(status.last_policy_id);
  refused_ = static_cast<int>(status.total_count);
}

}  // namespace stillpoint::io
