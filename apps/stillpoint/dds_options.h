/// What `watch` and `record` share: the options that say where the daemon is, words for a daemon that is not there, and
/// a clean end on SIGINT and SIGTERM.
#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <string>

#include "io/dds_params.h"

namespace stillpoint::app {

inline void add_dds_options(CLI::App& command, io::DdsParams& params) {
  command.add_option("--domain", params.domain, "DDS domain of the daemon")
      ->check(CLI::Range(0, 232))
      ->capture_default_str();
  command.add_option("--transport", params.transport, "udp, shm or data_sharing, as the daemon's configuration says")
      ->check(CLI::IsMember({"udp", "shm", "data_sharing"}))
      ->capture_default_str();
  command.add_option("--interface", params.interface, "address of the network interface, or any")
      ->check([](const std::string& text) {
        io::DdsParams asked;
        asked.interface = text;
        const auto faults = io::check(asked);
        return faults.empty() ? std::string() : faults.front();
      })
      ->capture_default_str();
}

/// Why nothing arrives, as far as it can be known from here.
inline std::string nothing_arrives(const io::DdsParams& params, const std::string& topic, bool matched) {
  if (matched)
    return fmt::format(
        "a daemon publishes '{}' in domain {}, but no message arrives; is its source silent? Over shm and "
        "data_sharing two users, or two versions of Fast DDS, get nothing: use udp",
        topic, params.domain);
  return fmt::format(
      "no daemon publishes '{}' in domain {} over {} ({}); is stillpointd running, with the same domain and "
      "interface?",
      topic, params.domain, params.transport, params.interface);
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
