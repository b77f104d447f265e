/// What other programs of the domain do on one topic of ours that would otherwise go wrong in silence: publish on it
/// too, use its name for another type, or ask for more than it offers.
#pragma once
#include <atomic>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <string>

namespace stillpoint::io {

/// A copy of the counts at one moment.
struct Neighbours {
  int publishers = 0;       ///< other programs' writers of the topic, now: two daemons in one domain
  int of_other_type = 0;    ///< other programs' writers and readers of the name with another type, now
  int refused = 0;          ///< readers so far that get nothing because their quality of service asks for more
  std::string asked_for{};  ///< what the last of them asked for, in words
  bool operator==(const Neighbours&) const = default;
};

/// Called on Fast DDS's own threads, read from any.
class NeighbourWatch : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  NeighbourWatch(std::string topic, std::string type) : topic_(std::move(topic)), type_(std::move(type)) {}
  [[nodiscard]] Neighbours seen() const;

  void on_publisher_discovery(eprosima::fastdds::dds::DomainParticipant* own,
                              eprosima::fastrtps::rtps::WriterDiscoveryInfo&& found) override;
  void on_subscriber_discovery(eprosima::fastdds::dds::DomainParticipant* own,
                               eprosima::fastrtps::rtps::ReaderDiscoveryInfo&& found) override;
  void on_offered_incompatible_qos(eprosima::fastdds::dds::DataWriter* writer,
                                   const eprosima::fastdds::dds::OfferedIncompatibleQosStatus& status) override;

 private:
  const std::string topic_, type_;
  std::atomic<int> publishers_{0}, of_other_type_{0}, refused_{0}, policy_{0};
};

}  // namespace stillpoint::io
