#include "io/yaml.h"

#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <sstream>

#include "core/nearest.h"
#include "io/quote.h"
#include "io/text_file.h"

namespace stillpoint::io {
namespace {

/// Aliases are refused: one that contains itself would send every reader of the tree round for ever.
class AliasFinder : public YAML::EventHandler {
 public:
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw YAML::ParserException(mark, "aliases (*name) are not used here; write the value out");
  }
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

/// yaml-cpp keeps the last of two equal keys without a word.
void find_repeated_keys(const YAML::Node& node, YamlFaults& faults) {
  if (node.IsSequence())
    for (const auto& item : node) find_repeated_keys(item, faults);
  if (!node.IsMap()) return;
  std::set<std::string> seen;
  for (const auto& entry : node) {
    if (entry.first.IsScalar() && !seen.insert(entry.first.Scalar()).second)
      faults.add(entry.first, fmt::format("key {} stands twice; remove one", quote(entry.first.Scalar())));
    find_repeated_keys(entry.second, faults);
  }
}

bool read_number(const YAML::Node& node, double& out, const Range& range, const std::string& key, YamlFaults& faults) {
  double value = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value)) {
    faults.add(node,
               fmt::format("'{}' must be a number{}", key, node.IsScalar() ? ", not " + quote(node.Scalar()) : ""));
    return false;
  }
  if (!range.holds(value)) {
    faults.add(node, std::isfinite(value)
                         ? fmt::format("'{}' is {}, allowed is {:g} to {:g}", key, node.Scalar(), range.low, range.high)
                         : fmt::format("'{}' is {}; it must be a finite number", key, node.Scalar()));
    return false;
  }
  out = value;
  return true;
}

bool has_tab(const std::string& text, int line) {
  std::istringstream stream(text);
  std::string found;
  for (int k = 0; k <= line && std::getline(stream, found);) ++k;
  return found.find('\t') != std::string::npos;
}

}  // namespace

void YamlFaults::add(const YAML::Node& where, const std::string& what) {
  const YAML::Mark mark = where.Mark();
  messages_.push_back(fmt::format("{}:{}:{}: {}", file_, mark.line + 1, mark.column + 1, what));
}

tl::unexpected<Error> YamlFaults::error() const {
  return fail(ErrorKind::kBadConfig, fmt::format("{}", fmt::join(messages_, "\n")));
}

Result<YAML::Node> parse_yaml(const std::string& text, const std::string& name) {
  try {
    std::istringstream stream(text);
    AliasFinder no_aliases;
    YAML::Parser(stream).HandleNextDocument(no_aliases);
    YAML::Node root = YAML::Load(text);
    if (!root.IsMap())
      return fail(ErrorKind::kBadConfig, fmt::format("{}:1:1: the file must hold keys with values", name));
    YamlFaults faults(name);
    find_repeated_keys(root, faults);
    if (!faults.empty()) return faults.error();
    return root;
  } catch (const YAML::Exception& e) {
    return fail(ErrorKind::kBadConfig,
                fmt::format("{}:{}:{}: not valid YAML: {}{}", name, e.mark.line + 1, e.mark.column + 1,
                            printable(e.msg), has_tab(text, e.mark.line) ? "; indent with spaces, not tabs" : ""));
  }
}

Result<YAML::Node> load_yaml(const std::string& path) {
  const auto text = read_text_file(path, "a .yaml");
  if (!text) return tl::unexpected(text.error());
  return parse_yaml(*text, path);
}

std::string suggestion(const std::string& key, const std::vector<std::string>& known) {
  if (const auto meant = nearest(key, known); !meant.empty()) return fmt::format("; did you mean '{}'?", meant);
  return fmt::format("; known here: {}", fmt::join(known, ", "));
}

std::string yaml_text(const std::string& text) {
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  const char quote = std::any_of(text.begin(), text.end(), control) ? '"' : '\'';
  std::string out(1, quote);
  for (const char c : text) {
    if (control(c))
      out += fmt::format("\\x{:02x}", c);
    else if (quote == '"' && (c == '"' || c == '\\'))
      out += {'\\', c};
    else
      out += c == quote ? std::string(2, c) : std::string(1, c);
  }
  return out + quote;
}

void refuse_unknown_keys(const YAML::Node& map, const std::vector<std::string>& known, YamlFaults& faults) {
  for (const auto& entry : map) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(not a name)";
    if (std::find(known.begin(), known.end(), key) == known.end())
      faults.add(entry.first, fmt::format("unknown key {}{}", quote(key), suggestion(key, known)));
  }
}

void read_value(const YAML::Node& node, double& out, const Range& range, const std::string& key, YamlFaults& faults) {
  read_number(node, out, range, key, faults);
}

void read_value(const YAML::Node& node, int& out, const Range& range, const std::string& key, YamlFaults& faults) {
  double value = out;
  if (!read_number(node, value, range, key, faults)) return;
  if (value != std::floor(value) || std::abs(value) > 2e9)
    return faults.add(node, fmt::format("'{}' must be a whole number, not {}", key, node.Scalar()));
  out = static_cast<int>(value);
}

void read_value(const YAML::Node& node, bool& out, const Range&, const std::string& key, YamlFaults& faults) {
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, out))
    faults.add(node, fmt::format("'{}' must be true or false", key));
}

void read_value(const YAML::Node& node, std::string& out, const Range&, const std::string& key, YamlFaults& faults) {
  if (!node.IsScalar()) return faults.add(node, fmt::format("'{}' must be a text", key));
  out = node.Scalar();
}

void read_value(const YAML::Node& node, std::vector<double>& out, const Range& range, const std::string& key,
                YamlFaults& faults) {
  std::vector<double> values;
  if (node.IsScalar()) {
    double x = 0.0;
    if (!read_number(node, x, range, key, faults)) return;
    values.push_back(x);
  } else if (node.IsSequence()) {
    for (const auto& item : node) {
      std::vector<double> inner;  // a list of rows is flattened row by row
      if (!reads(item, inner, range, key, faults)) return;
      values.insert(values.end(), inner.begin(), inner.end());
    }
  } else {
    return faults.add(node, fmt::format("'{}' must be a number or a list of numbers", key));
  }
  out = std::move(values);
}

void read_value(const YAML::Node& node, Vec3& out, const Range& range, const std::string& key, YamlFaults& faults) {
  if (!node.IsSequence() || node.size() != 3)
    return faults.add(node, fmt::format("'{}' must be three numbers, [x, y, z]", key));
  Vec3 value;
  for (std::size_t i = 0; i < 3; ++i)
    if (!read_number(node[i], value[static_cast<Eigen::Index>(i)], range, key, faults)) return;
  out = value;
}

void read_value(const YAML::Node& node, Mat3& out, const Range& range, const std::string& key, YamlFaults& faults) {
  if (!node.IsSequence() || node.size() != 3)
    return faults.add(node, fmt::format("'{}' must be three rows of three numbers", key));
  Mat3 value;
  for (std::size_t i = 0; i < 3; ++i) {
    Vec3 row = Vec3::Zero();
    if (!reads(node[i], row, range, key, faults)) return;
    value.row(static_cast<Eigen::Index>(i)) = row.transpose();
  }
  out = value;
}

}  // namespace stillpoint::io
