#include "io/dds_params.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "io/dds_addresses.h"
#include "io/dds_servers.h"

namespace stillpoint::io {
namespace {

bool is_of_this_machine(const std::string& address) {
  in_addr asked{};
  inet_pton(AF_INET, address.c_str(), &asked);
  const auto own = local_addresses();
  return address.starts_with("127.") || std::find(own.begin(), own.end(), asked.s_addr) != own.end();
}

void check_servers(const DdsParams& p, std::vector<std::string>& faults) {
  const auto& servers = p.discovery_server;
  if (!servers.empty() && std::all_of(servers.begin(), servers.end(), [](const auto& s) { return s.empty(); }))
    faults.emplace_back("discovery_server names no server; leave the key out, or write [127.0.0.1:11811]");
  if (servers.size() > kMostServers) faults.push_back(fmt::format("discovery_server: at most {} fit", kMostServers));
  for (const auto& text : servers) {
    if (text.empty()) continue;
    const auto server = parse_server(text);
    if (!server)
      faults.push_back("discovery_server: " + server.error().message);
    else if (p.interface == "127.0.0.1" && !is_of_this_machine(server->address))
      faults.push_back(
          fmt::format("discovery_server {} is not on this machine, and interface 127.0.0.1 reaches nothing "
                      "else; set 'interface' to this machine's address in that network",
                      text));
  }
}

void check_namespace(const DdsParams& p, std::vector<std::string>& faults) {
  const std::string& n = p.name_space;
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '/';
  };
  if (n.empty()) return;
  if (!std::all_of(n.begin(), n.end(), is_allowed) || n.front() == '/' || n.back() == '/')
    faults.push_back(fmt::format("namespace '{}' may hold letters, digits, _ and / between them, as robot1/left", n));
}

}  // namespace

DdsParams in_namespace(DdsParams params) {
  if (params.name_space.empty()) return params;
  const std::string before = params.name_space + "/";
  for (std::string* topic :
       {&params.attitude_topic, &params.calibration_topic, &params.diagnostics_topic, &params.raw_topic})
    if (!topic->empty()) *topic = before + *topic;
  params.ros2_namespace = params.ros2_namespace.empty() ? params.name_space : before + params.ros2_namespace;
  params.name_space.clear();
  return params;
}

std::vector<std::string> check(const DdsParams& p) {
  std::vector<std::string> faults;
  if (p.transport != "udp" && p.transport != "shm" && p.transport != "data_sharing")
    faults.push_back(fmt::format("transport '{}' is not known; use udp, shm or data_sharing", p.transport));
  if (p.transport == "data_sharing" && is_secured(p.security))
    faults.emplace_back(
        "transport data_sharing shows every sample to whoever may read the shared memory, unencrypted; "
        "with 'security' use udp or shm");
  in_addr address{};
  if (p.interface != "any" && inet_pton(AF_INET, p.interface.c_str(), &address) != 1)
    faults.push_back(fmt::format(
        "interface '{}' is not an IPv4 address; use 127.0.0.1, another address of this machine, or any", p.interface));
  check_servers(p, faults);
  check_namespace(p, faults);
  if (p.attitude_topic.empty()) faults.emplace_back("attitude_topic is empty; every daemon publishes its attitude");
  if (p.calibration_topic.empty()) faults.emplace_back("calibration_topic is empty");
  if (p.diagnostics_topic.empty()) faults.emplace_back("diagnostics_topic is empty");
  std::set<std::string> names;
  for (const auto& topic : {p.attitude_topic, p.calibration_topic, p.diagnostics_topic, p.raw_topic})
    if (!topic.empty() && !names.insert(topic).second)
      faults.push_back(
          fmt::format("two topics are named '{}'; each has a type of its own and needs a name of its own", topic));
  return faults;
}

}  // namespace stillpoint::io
