/// Lines of CSV or JSON into readings: pure functions over bytes, no allocation while readings are parsed.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/source_config.h"
#include "sources/reading.h"

namespace stillpoint::sources {

/// Where a field of a line goes: its place in an io::RecordingRow, and the factor to SI units.
struct Field {
  std::size_t place = 0;
  double to_si = 1.0;
};

/// How the lines of one stream are to be understood.
class LineFormat {
 public:
  /// From the configuration. Without `columns:` a header line or the names of JSON say what the fields are.
  explicit LineFormat(const io::StreamParams& params);

  /// A reading, or what else the line is.
  Piece parse(std::string_view line, Reading& out) const noexcept;

  /// Takes the names of a header line; false: there is no reading among them. Allocates.
  bool use_header(std::string_view line);

  /// The names of a header line or a JSON object that are no reading, each with the nearest that is one: "ax
  /// (acc_x_g?)". None where `columns:` names what is wanted. Allocates.
  [[nodiscard]] std::string unknown_names(std::string_view line) const;

  /// Where a header line contradicts `columns:`, lacks a name of it, or an axis; empty: nowhere. Allocates.
  [[nodiscard]] std::string header_faults(std::string_view line) const;

  /// CSV can be read: positions are known by configuration or header.
  [[nodiscard]] bool knows_positions() const noexcept { return !by_position_.empty(); }
  /// ... by `columns:`, whatever a header line says.
  [[nodiscard]] bool configured() const noexcept { return configured_positions_; }

 private:
  Piece parse_csv(std::string_view line, Reading& out) const noexcept;
  Piece parse_json(std::string_view line, Reading& out) const noexcept;
  /// In quotes or in any letters, capital or not. Allocates.
  [[nodiscard]] std::optional<Field> field_of_header(std::string_view name) const;
  [[nodiscard]] std::optional<Field> field_named(std::string_view name) const noexcept;
  [[nodiscard]] std::optional<Field> known_field(std::string_view name) const noexcept;
  [[nodiscard]] std::optional<Field> field_of_json(std::string_view name) const noexcept;
  [[nodiscard]] std::string contradiction(std::string_view line) const;
  [[nodiscard]] std::string names_missing(std::string_view line) const;
  [[nodiscard]] std::string axis_missing(std::string_view line) const;

  double count_to_si_[3];
  std::vector<std::pair<std::string, Field>> by_name_;  ///< of `columns:`, by the stream's own names
  std::vector<std::optional<Field>> by_position_;
  bool configured_positions_ = false;
};

}  // namespace stillpoint::sources
