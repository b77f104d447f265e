/// What `watch` and `record` share: the options that say where the daemon is, words for a daemon that is not there, and
/// a clean end on SIGINT and SIGTERM.
#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <string>

#include "io/dds_params.h"
#include "io/dds_servers.h"

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
  command.add_option("--namespace", params.name_space, "of the daemon, where several share a domain");
  command.add_option("--discovery-server", params.discovery_server, "ADDRESS:PORT of each discovery server, in order")
      ->check([](const std::string& text) {
        const auto server = io::parse_server(text);
        return text.empty() || server ? std::string() : server.error().message;
      });
  command
      .add_option("--security", params.security.folder,
                  "folder with one's own six files of DDS-Security, where the daemon has some (scripts/dds_keys.sh)")
      ->check([](const std::string& folder) {
        const auto faults = io::check(io::SecurityParams{.folder = folder});
        return faults.empty() ? std::string() : faults.front();
      });
}

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
