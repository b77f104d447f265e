/// The Fast DDS objects behind publisher and subscriber: one participant, what was made in it, and its orderly end.
#pragma once
#include <exception>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <string>

#include "core/result.h"
#include "io/dds_gate.h"
#include "io/dds_neighbours.h"
#include "io/dds_params.h"

namespace stillpoint::io {

namespace dds = eprosima::fastdds::dds;

/// One participant. Errors name the domain and what to look at (exit code 69), bad values the key (78).
class DdsEntities {
 public:
  /// `transport` overrides params.transport: the ROS 2 topics stay on UDP whatever the attitude uses. `watch` is told
  /// of the neighbours from the first moment on.
  [[nodiscard]] static Result<std::unique_ptr<DdsEntities>> create(const DdsParams& params,
                                                                   const std::string& transport,
                                                                   const std::string& name,
                                                                   std::unique_ptr<NeighbourWatch> watch = nullptr);
  ~DdsEntities();
  DdsEntities(const DdsEntities&) = delete;
  DdsEntities& operator=(const DdsEntities&) = delete;

  [[nodiscard]] Result<dds::DataWriter*> writer(const std::string& topic, const dds::TypeSupport& type,
                                                const dds::DataWriterQos& qos);
  [[nodiscard]] Result<dds::DataReader*> reader(const std::string& topic, const dds::TypeSupport& type,
                                                const dds::DataReaderQos& qos, dds::DataReaderListener* listener);
  /// Pre: one was given to create().
  [[nodiscard]] Neighbours neighbours() const { return neighbours_->seen(); }
  /// What was kept from Fast DDS at the door.
  [[nodiscard]] const GateCounts& gate() const { return *gate_; }
  /// Listeners are not called again once this returns.
  void stop() noexcept;

 private:
  DdsEntities();
  [[nodiscard]] Result<dds::Topic*> topic(const std::string& name, const dds::TypeSupport& type);
  [[nodiscard]] tl::unexpected<Error> refused(const char* endpoint, const std::string& topic) const;

  bool secured_ = false;
  std::unique_ptr<NeighbourWatch> neighbours_;
  std::shared_ptr<GateCounts> gate_ = std::make_shared<GateCounts>();
  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
};

/// A type whose malformed samples are left out. Fast DDS lets what a deserialisation throws end the program.
template <class PubSubType>
class Guarded : public PubSubType {
 public:
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    try {
      return PubSubType::deserialize(payload, data);
    } catch (const std::exception&) {
      return false;
    }
  }
};

/// Quality of service of the topics, the same on both sides.
[[nodiscard]] dds::DataWriterQos attitude_writer_qos(const std::string& transport);
[[nodiscard]] dds::DataReaderQos attitude_reader_qos(const std::string& transport);
/// Reliable, keeps the last `depth` for retransmission; a reader that does not keep up loses the oldest, nobody waits.
[[nodiscard]] dds::DataWriterQos reliable_writer_qos(int depth, bool for_late_joiners);
[[nodiscard]] dds::DataReaderQos reliable_reader_qos(int depth, bool late_joiner);

inline constexpr int kRawDepth = 4096;  ///< 4 s at 1 kHz of readings kept for a slow recorder

}  // namespace stillpoint::io
