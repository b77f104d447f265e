// Quality of service of the topics.
#include <algorithm>

#include "io/dds_entities.h"

namespace stillpoint::io {
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
