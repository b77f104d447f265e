/// What a participant of ours is: its transports, who it looks for, and its keys.
#pragma once
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <memory>
#include <string>

#include "io/dds_gate.h"
#include "io/dds_params.h"

namespace stillpoint::io {

/// `transport` overrides params.transport; `gate` counts what is refused at the door.
[[nodiscard]] eprosima::fastdds::dds::DomainParticipantQos participant_qos(const DdsParams& params,
                                                                           const std::string& transport,
                                                                           const std::string& name,
                                                                           std::shared_ptr<GateCounts> gate);

}  // namespace stillpoint::io
