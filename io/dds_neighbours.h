/// What other programs of the domain do on one topic of ours that would otherwise go wrong in silence: publish on it
/// too, use its name for another type, or ask for more than it offers.
#pragma once
#include <atomic>
#include <cstdint>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <mutex>
#include <string>

namespace stillpoint::io {

/// A copy of the counts at one moment.
struct Neighbours {
  int publishers = 0;              ///< other programs' writers of the topic, now: two daemons in one domain
  int of_other_type = 0;           ///< other programs' writers and readers of the name with another type, now
  int refused = 0;                 ///< readers so far that get nothing because their quality of service asks for more
  std::string asked_for{};         ///< what the last of them asked for, in words
  int unreachable = 0;             ///< participants so far that name no address which this one can send to
  std::string unreachable_name{};  ///< of the last of them; fit for a line of the log
  bool operator==(const Neighbours&) const = default;
};

/// Datagrams that were not let in (io/dds_gate.h).
struct RefusedDatagrams {
  std::uint64_t malformed = 0;
  std::uint64_t off_host = 0;  ///< from another machine, where only this one is served
  std::uint64_t flooded = 0;   ///< announcements of too many new participants
  bool operator==(const RefusedDatagrams&) const = default;
};

/// Called on Fast DDS's own threads, read from any.
class NeighbourWatch : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  NeighbourWatch(std::string topic, std::string type) : topic_(std::move(topic)), type_(std::move(type)) {}
  [[nodiscard]] Neighbours seen() const;

  void on_participant_discovery(eprosima::fastdds::dds::DomainParticipant* own,
                                eprosima::fastrtps::rtps::ParticipantDiscoveryInfo&& found) override;
  void on_publisher_discovery(eprosima::fastdds::dds::DomainParticipant* own,
                              eprosima::fastrtps::rtps::WriterDiscoveryInfo&& found) override;
  void on_subscriber_discovery(eprosima::fastdds::dds::DomainParticipant* own,
                               eprosima::fastrtps::rtps::ReaderDiscoveryInfo&& found) override;
  void on_offered_incompatible_qos(eprosima::fastdds::dds::DataWriter* writer,
                                   const eprosima::fastdds::dds::OfferedIncompatibleQosStatus& status) override;

 private:
  const std::string topic_, type_;
  std::atomic<int> publishers_{0}, of_other_type_{0}, refused_{0}, policy_{0}, unreachable_{0};
  mutable std::mutex mutex_;
  std::string unreachable_name_;
};

}  // namespace stillpoint::io
