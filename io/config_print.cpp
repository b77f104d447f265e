// A configuration as YAML that reads back to the same, each key with its meaning.
#include <filesystem>
#include <sstream>

#include "io/config.h"
#include "io/simulation_yaml.h"

namespace stillpoint::io {
namespace {

std::string value_text(double x) { return fmt::format("{}", x); }
std::string value_text(int x) { return fmt::format("{}", x); }
std::string value_text(bool x) { return x ? "true" : "false"; }
std::string value_text(const std::string& x) { return yaml_text(x); }
std::string value_text(const Vec3& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }
std::string value_text(const Mat3& m) {
  return fmt::format("[{}, {}, {}]", value_text(Vec3(m.row(0))), value_text(Vec3(m.row(1))),
                     value_text(Vec3(m.row(2))));
}
std::string value_text(const Mount& m) { return value_text(m.R_body_sensor); }
std::string value_text(const std::optional<double>& x) { return x ? value_text(*x) : "not set"; }
std::string value_text(SourceKind x) { return word_of(x, kSourceKinds); }
std::string value_text(SourceEnd x) { return word_of(x, kSourceEnds); }
std::string value_text(StreamFormat x) { return word_of(x, kStreamFormats); }
std::string value_text(const ColumnMap& columns) {
  std::vector<std::string> texts;
  for (const auto& [ours, theirs] : columns) texts.push_back(fmt::format("{}: {}", ours, value_text(theirs)));
  return fmt::format("{{{}}}", fmt::join(texts, ", "));
}
std::string value_text(const std::vector<std::string>& names) {
  std::vector<std::string> texts;
  for (const auto& name : names) texts.push_back(value_text(name));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}
std::string value_text(pipeline::WorldFrame x) { return x == pipeline::WorldFrame::kEnu ? "enu" : "ned"; }
std::string value_text(const std::vector<sim::EffectConfig>& effects) {
  std::vector<std::string> texts;
  texts.reserve(effects.size());
  for (const auto& effect : effects) texts.push_back(format_effect(effect));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

template <HasFields P>
void print(std::string& out, const P& values, const P& defaults, int depth);

template <class T>
void print_one(std::string& out, std::string_view name, std::string_view help, const T& value, const T& by_default,
               int depth) {
  const std::string indent(static_cast<std::size_t>(2 * depth), ' ');
  if constexpr (HasFields<T>) {
    out += fmt::format("{}{}:  # {}\n", indent, name, help);
    print(out, value, by_default, depth + 1);
  } else {
    const std::string text = value_text(value);
    const char* mark = text == value_text(by_default) ? " (default)" : "";
    const bool unset = text == "not set";
    out += fmt::format("{:<58}# {}{}\n", fmt::format("{}{}{}: {}", indent, unset ? "# " : "", name, text), help, mark);
  }
}

template <HasFields T>
void print_one(std::string& out, std::string_view name, std::string_view help, const std::optional<T>& value,
               const std::optional<T>&, int depth) {
  if (value) print_one(out, name, help, *value, T{}, depth);
}

/// Without a source there is nothing that could be read back: its keys are shown as a comment.
void print_one(std::string& out, std::string_view name, std::string_view help, const SourceConfig& value,
               const SourceConfig& by_default, int depth);

template <class P, class Fields>
void print_fields(std::string& out, const P& values, const P& defaults, const Fields& fields, int depth) {
  std::apply(
      [&](const auto&... f) { (print_one(out, f.name, f.help, values.*(f.member), defaults.*(f.member), depth), ...); },
      fields);
}

template <HasFields P>
void print(std::string& out, const P& values, const P& defaults, int depth) {
  print_fields(out, values, defaults, P::fields(), depth);
}

void print_one(std::string& out, std::string_view name, std::string_view help, const SourceConfig& value,
               const SourceConfig&, int depth) {
  std::string block = fmt::format("{}:  # {}\n", name, help);
  for_each_block(value, [&](const auto& values, const auto& fields) {
    print_fields(block, values, std::decay_t<decltype(values)>{}, fields, depth + 1);
  });
  if (value.kind != SourceKind::kNone) {
    out += block;
    return;
  }
  std::istringstream lines(block);
  for (std::string line; std::getline(lines, line);) out += "# " + line + "\n";
}

}  // namespace

std::string print_config(const DaemonConfig& config) {
  std::string out;
  DaemonConfig anywhere = config;  // read back, the text may lie in another folder
  const auto from_anywhere = [](std::string& path) { path = std::filesystem::absolute(path).string(); };
  for (std::string* path : {&anywhere.source.file, &anywhere.source.stream.from})
    if (is_path(*path)) from_anywhere(*path);
  SecurityParams& security = anywhere.dds.security;
  if (!security.folder.empty()) from_anywhere(security.folder);
  for (const auto& file : kSecurityFiles)
    if (!(security.*file.path).empty()) from_anywhere(security.*file.path);
  print(out, anywhere, DaemonConfig{}, 0);
  return out;
}

}  // namespace stillpoint::io
