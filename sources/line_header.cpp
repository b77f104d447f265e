/// What the header line of a stream says, and where it does not fit.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "io/recording_columns.h"
#include "sources/json_line.h"
#include "sources/line.h"
#include "sources/line_text.h"

namespace stillpoint::sources {

std::optional<Field> LineFormat::field_of_header(std::string_view name) const {
  name = unquoted(name);
  const auto field = field_named(name);
  return field || !by_name_.empty() ? field : known_field(in_our_letters(name));
}

bool LineFormat::use_header(std::string_view line) {
  if (configured_positions_) return false;
  std::vector<std::optional<Field>> fields;
  std::string_view name;
  for (Fields names(bare(line)); names.next(name) && fields.size() < io::kMostColumns;)
    fields.push_back(field_of_header(name));
  const bool any = std::any_of(fields.begin(), fields.end(), [](const auto& f) {
    return f && f->place != io::kColumnGroupInfo[io::kTimeGroup].first;
  });
  if (any) by_position_ = std::move(fields);
  return any;
}

std::string LineFormat::unknown_names(std::string_view line) const {
  if (!by_name_.empty()) return {};
  std::string names;
  const auto add = [&names](std::string_view name) {
    const std::string meant = io::meant_column(name);
    names += fmt::format("{}{}{}", names.empty() ? "" : ", ", name, meant.empty() ? "" : " (" + meant + "?)");
  };
  line = bare(line);
  if (!line.empty() && line[0] == '{') {
    const bool whole = for_each_number(line, [&](std::string_view name, double) {
      if (!field_of_json(name)) add(name);
    });
    return whole ? names : std::string();
  }
  std::string_view name;
  for (Fields fields(line); fields.next(name);)
    if (!io::known_column(in_our_letters(unquoted(name)))) add(name);
  return names;
}

std::string LineFormat::contradiction(std::string_view line) const {
  std::string_view name;
  std::size_t n = 0;
  for (Fields names(bare(line)); names.next(name) && n < by_position_.size(); ++n) {
    const auto& ours = by_position_[n];
    const auto theirs = known_field(in_our_letters(unquoted(name)));
    if (ours && theirs && (ours->place != theirs->place || ours->to_si != theirs->to_si))
      return fmt::format(
          "column {} is {} in the header line and another one in 'source: columns', which serves; correct the list, or "
          "leave it out",
          n + 1, name);
  }
  return {};
}

std::string LineFormat::names_missing(std::string_view line) const {
  std::string missing;
  for (const auto& [theirs, field] : by_name_) {
    bool there = false;
    std::string_view name;
    for (Fields names(bare(line)); names.next(name);) there = there || unquoted(name) == theirs;
    if (!there) missing += fmt::format("{}'{}'", missing.empty() ? "" : ", ", theirs);
  }
  if (missing.empty()) return {};
  return fmt::format("the header line lacks {} of 'source: columns'; write each as it stands there", missing);
}

std::string LineFormat::axis_missing(std::string_view line) const {
  std::array<bool, io::kRowFields> there{};
  std::string_view name;
  for (Fields names(bare(line)); names.next(name);)
    if (const auto field = field_of_header(name)) there[field->place] = true;
  for (const io::ColumnGroup group : {io::kAccGroup, io::kGyrGroup, io::kMagGroup}) {
    const io::ColumnGroupInfo& info = io::kColumnGroupInfo[group];
    const auto axes = std::span(there).subspan(info.first, info.size);
    const auto first_missing = std::find(axes.begin(), axes.end(), false);
    if (first_missing == axes.end() || std::find(axes.begin(), axes.end(), true) == axes.end()) continue;
    return fmt::format("the header line has no {}{}; without it nothing of {} is used: send all three axes",
                       std::string_view(info.names).substr(0, 4), "xyz"[first_missing - axes.begin()], info.names);
  }
  return {};
}

std::string LineFormat::header_faults(std::string_view line) const {
  if (configured_positions_) return contradiction(line);
  std::string missing = names_missing(line);
  return missing.empty() ? axis_missing(line) : missing;
}

}  // namespace stillpoint::sources
