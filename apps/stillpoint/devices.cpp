/// `stillpoint devices`: the sensors that can be attached here, and what stands in the way.
#include "sources/devices.h"

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/dds_options.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "io/quote.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

struct DevicesOptions {
  std::string uri = "local:";
  double listen_s = 1.5;
  io::DdsParams dds;
  JsonOption json;
};

nlohmann::json to_json(const sources::DeviceList& list) {
  nlohmann::json out{
      {"schema", "stillpoint.devices/1"}, {"devices", nlohmann::json::array()}, {"missing", nlohmann::json::array()}};
  for (const auto& d : list.found) {
    nlohmann::json one{{"kind", d.kind}, {"name", d.name}, {"parts", d.parts}, {"config", d.config}};
    if (d.rate_hz > 0.0) one["rate_hz"] = d.rate_hz;
    if (!d.detail.empty()) one["detail"] = d.detail;
    if (!d.problem.empty()) one["problem"] = {{"what", d.problem}, {"fix", d.fix}};
    out["devices"].push_back(std::move(one));
  }
  for (const auto& m : list.missing) out["missing"].push_back({{"what", m.what}, {"fix", m.fix}});
  return out;
}

std::string to_text(const sources::DeviceList& list) {
  std::string out;
  for (const auto& d : list.found) {
    out += fmt::format("{:<7}{}", d.kind, io::printable(d.name));
    if (!d.parts.empty()) out += fmt::format("  {}", d.parts);
    if (d.rate_hz > 0.0) out += fmt::format("  {:.4g} Hz", d.rate_hz);
    out += d.detail.empty() ? "\n" : fmt::format("  ({})\n", io::printable(d.detail));
    if (!d.problem.empty()) out += fmt::format("       PROBLEM {}; {}\n", d.problem, d.fix);
    out += fmt::format("       {}\n", io::printable(d.config));
  }
  for (const auto& m : list.missing) out += fmt::format("none   {}\n       {}\n", io::printable(m.what), m.fix);
  return out;
}

int run_devices(const DevicesOptions& o) {
  const auto list = sources::list_devices(o.uri, o.dds, o.listen_s);
  const std::string file = o.json.file();
  if (file != "-") std::fputs(to_text(list).c_str(), stdout);
  if (file.empty()) return 0;
  const auto written = io::write_text_file(file, json_text(to_json(list)));
  return written ? 0 : report(written.error());
}

}  // namespace

void add_devices(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("devices", "List the sensors that can be attached here, and what is missing");
  static DevicesOptions o;
  o.json.add(*command, "write the list");
  command->add_option("--uri", o.uri, "of IIO: local: or ip:HOST[:PORT]")->capture_default_str();
  command->add_option("--listen", o.listen_s, "seconds to listen for ROS 2 drivers; 0: not at all")
      ->check(between(0.0, 60.0))
      ->capture_default_str();
  add_dds_options(*command, o.dds);
  command->callback([&run] { run = [] { return run_devices(o); }; });
}

}  // namespace stillpoint::app
