/// YAML into structs that list their fields (core/fields.h). Every fault is reported, each as file:line:column, not
/// only the first.
#pragma once
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/fields.h"
#include "core/result.h"
#include "core/types.h"

namespace stillpoint::io {

/// Collects what is wrong with one file.
class YamlFaults {
 public:
  explicit YamlFaults(std::string file) : file_(std::move(file)) {}
  void add(const YAML::Node& where, const std::string& what);
  [[nodiscard]] bool empty() const { return messages_.empty(); }
  [[nodiscard]] const std::vector<std::string>& messages() const { return messages_; }
  [[nodiscard]] tl::unexpected<Error> error() const;  ///< all messages, one a line, exit code 78

 private:
  std::string file_;
  std::vector<std::string> messages_;
};

/// Parses a file into a map node. Fails with the position on bad YAML and on repeated keys, which yaml-cpp lets pass.
[[nodiscard]] Result<YAML::Node> load_yaml(const std::string& path);
[[nodiscard]] Result<YAML::Node> parse_yaml(const std::string& text, const std::string& name);

/// "; did you mean 'x'?" for the nearest known key within two edits, else the list of keys.
[[nodiscard]] std::string suggestion(const std::string& key, const std::vector<std::string>& known);

/// Reports every key of the map that is not in `known`.
void refuse_unknown_keys(const YAML::Node& map, const std::vector<std::string>& known, YamlFaults& faults);

/// A text as YAML that reads back to the same bytes. In single quotes, where nothing has a meaning but the quote; a
/// text of several lines or with control characters in double quotes, because single ones fold its lines.
[[nodiscard]] std::string yaml_text(const std::string& text);

// One read_value per type a field may have. Each leaves `out` as it was when it reports a fault.
void read_value(const YAML::Node& node, double& out, const Range& range, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, int& out, const Range& range, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, bool& out, const Range& range, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, std::string& out, const Range& range, const std::string& key,
                YamlFaults& faults);
void read_value(const YAML::Node& node, Vec3& out, const Range& range, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, Mat3& out, const Range& range, const std::string& key, YamlFaults& faults);
void read_value(const YAML::Node& node, std::vector<double>& out, const Range& range, const std::string& key,
                YamlFaults& faults);

/// The same for any of them; false when it reported a fault.
template <class T>
[[nodiscard]] bool reads(const YAML::Node& node, T& out, const Range& range, const std::string& key,
                         YamlFaults& faults) {
  const std::size_t before = faults.messages().size();
  read_value(node, out, range, key, faults);
  return faults.messages().size() == before;
}

template <HasFields P>
void read_fields(const YAML::Node& map, P& out, YamlFaults& faults);

template <HasFields P>
void read_value(const YAML::Node& node, P& out, const Range&, const std::string&, YamlFaults& faults) {
  read_fields(node, out, faults);
}
template <HasFields P>
void read_value(const YAML::Node& node, std::optional<P>& out, const Range&, const std::string&, YamlFaults& faults) {
  read_fields(node, out.emplace(), faults);
}
template <HasFields P>
void read_value(const YAML::Node& node, std::vector<P>& out, const Range&, const std::string& key, YamlFaults& faults) {
  if (!node.IsSequence()) return faults.add(node, fmt::format("'{}' must be a list", key));
  out.clear();
  for (const auto& item : node) read_fields(item, out.emplace_back(), faults);
}

template <class Fields>
void append_names(const Fields& fields, std::vector<std::string>& names) {
  std::apply([&](const auto&... f) { (names.emplace_back(f.name), ...); }, fields);
}

/// Reads those of the fields that are in the map; the others keep their defaults.
template <class P, class Fields>
void read_known_fields(const YAML::Node& map, P& out, const Fields& fields, YamlFaults& faults) {
  const auto read_one = [&](const auto& f) {
    const std::string key(f.name);
    if (const YAML::Node node = map[key]) read_value(node, out.*(f.member), f.range, key, faults);
  };
  std::apply([&](const auto&... f) { (read_one(f), ...); }, fields);
}

/// The same for every field of P; any other key is a fault.
template <HasFields P>
void read_fields(const YAML::Node& map, P& out, YamlFaults& faults) {
  if (!map.IsMap()) return faults.add(map, "expected keys with values here");
  std::vector<std::string> known;
  append_names(P::fields(), known);
  refuse_unknown_keys(map, known, faults);
  read_known_fields(map, out, P::fields(), faults);
}

}  // namespace stillpoint::io
