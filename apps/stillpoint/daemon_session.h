/// What the commands that listen to a daemon share: words for one that is not there, and a clean end on SIGINT and
/// SIGTERM.
#pragma once
#include <fmt/format.h>

#include <csignal>
#include <string>

#include "io/dds_params.h"
#include "io/dds_security.h"

namespace stillpoint::app {

/// Why nothing arrives, as far as it can be known from here.
inline std::string nothing_arrives(const io::DdsParams& params, const std::string& name, bool matched) {
  const std::string topic = params.name_space.empty() ? name : params.name_space + "/" + name;
  if (matched)
    return fmt::format(
        "a daemon publishes '{}' in domain {}, but no message arrives; is its source silent? Over shm and "
        "data_sharing two users, or two versions of Fast DDS, get nothing: use udp",
        topic, params.domain);
  return fmt::format(
      "no daemon publishes '{}' in domain {} over {} ({}); is stillpointd running, with the same domain and "
      "interface{}?",
      topic, params.domain, params.transport, params.interface,
      io::is_secured(params.security) ? ", and do both sides' permissions allow the topic"
                                      : "; if it has 'security:', give --security FOLDER");
}

namespace detail {
inline volatile std::sig_atomic_t stop_signal = 0;
}
/// Asks to stop at the first signal; the second one ends the process as usual.
inline void stop_on_signals() {
  const auto handler = [](int number) {
    detail::stop_signal = number;
    std::signal(number, SIG_DFL);
  };
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
}
inline bool stop_asked() { return detail::stop_signal != 0; }

}  // namespace stillpoint::app
