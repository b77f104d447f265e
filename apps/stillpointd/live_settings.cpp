#include "apps/stillpointd/live_settings.h"

#include <algorithm>
#include <map>
#include <sstream>

namespace stillpoint::app {
namespace {

/// Each key with its printed value: print_config knows every field, so a new one is compared without a word here.
std::map<std::string, std::string> by_key(const io::DaemonConfig& config) {
  std::map<std::string, std::string> out;
  std::vector<std::string> path;
  std::istringstream lines(io::print_config(config));
  for (std::string line; std::getline(lines, line);) {
    const auto depth = line.find_first_not_of(' ') / 2;
    std::string text = line.substr(2 * depth);
    if (text.starts_with("# ")) text.erase(0, 2);  // a value that is not set
    const auto colon = text.find(':');
    if (colon == std::string::npos) continue;
    path.resize(depth);
    path.push_back(text.substr(0, colon));
    std::string key;
    for (const auto& word : path) key += (key.empty() ? "" : ".") + word;
    out[key] = text;
  }
  return out;
}

bool is_live(const std::string& key) {
  return key.starts_with("dds.") || key == "stale_after_s" || key == "state.save_period_s";
}

}  // namespace

ConfigChange compare(const io::DaemonConfig& before, const io::DaemonConfig& after) {
  ConfigChange change;
  const auto old_values = by_key(before), new_values = by_key(after);
  auto keys = old_values;
  keys.insert(new_values.begin(), new_values.end());
  for (const auto& [key, value] : keys) {
    const auto was = old_values.find(key), is = new_values.find(key);
    if (was != old_values.end() && is != new_values.end() && was->second == is->second) continue;
    (is_live(key) ? change.live : change.at_next_start).push_back(key);
    change.dds = change.dds || key.starts_with("dds.");
  }
  return change;
}

}  // namespace stillpoint::app
