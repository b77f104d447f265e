/// The options that say where the daemon is.
#pragma once
#include <CLI/CLI.hpp>
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

}  // namespace stillpoint::app
