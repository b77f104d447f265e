/// A payload on its way from a stranger's writer to our code: as the readers of DDS take it.
#pragma once
#include <cstring>
#include <string_view>

#include "io/dds_entities.h"

namespace stillpoint::fuzz {

/// False where the payload is refused.
template <class PubSubType, class Message>
bool deserialize(std::string_view bytes, Message& message) {
  io::Guarded<PubSubType> type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(static_cast<std::uint32_t>(bytes.size()));
  if (!bytes.empty()) std::memcpy(payload.data, bytes.data(), bytes.size());
  payload.length = payload.max_size;
  return type.deserialize(&payload, &message);
}

}  // namespace stillpoint::fuzz
