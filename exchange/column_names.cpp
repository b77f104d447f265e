/// What the names of columns say, as programs of all kinds write them.
#include <algorithm>
#include <cctype>
#include <map>
#include <optional>

#include "core/units.h"
#include "exchange/column_map.h"

namespace stillpoint::exchange {
namespace {

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size())
    text.replace(at, what.size(), with);
  return text;
}

/// One spelling a unit: lower case, no blanks, no signs that fonts write in several ways.
std::string plain(const std::string& unit) {
  std::string u;
  for (const char c : unit)
    if (c != ' ') u += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [from, to] : {std::pair{"\xC2\xB2", "2"},
                                 {"\xC2\xB5", "u"},
                                 {"\xCE\xBC", "u"},
                                 {"\xC2\xB0", "deg"},
                                 {"^", ""},
                                 {"*", ""},
                                 {"_", ""},
                                 {"micro", "u"}})
    u = replaced(u, from, to);
  return u;
}

/// Parts of a name between signs and at the change from small to capital letters, in small letters, units left out.
std::vector<std::string> parts_of(const std::string& column) {
  const std::string bare = column.substr(0, std::min(column.find('['), column.find('(')));
  std::vector<std::string> parts(1);
  for (std::size_t i = 0; i < bare.size(); ++i) {
    const auto c = static_cast<unsigned char>(bare[i]);
    const bool turns = i > 0 && std::isupper(c) != 0 && std::islower(static_cast<unsigned char>(bare[i - 1])) != 0;
    if (std::isalnum(c) == 0 || turns) parts.emplace_back();
    if (std::isalnum(c) != 0) parts.back() += static_cast<char>(std::tolower(c));
  }
  std::erase(parts, "");
  return parts;
}

struct Word {
  std::string_view text;
  Quantity quantity;
};
constexpr Word kSensorWords[] = {{"acc", Quantity::kAcc},
                                 {"accel", Quantity::kAcc},
                                 {"accelerometer", Quantity::kAcc},
                                 {"alpha", Quantity::kAcc},
                                 {"acceleration", Quantity::kAcc},
                                 {"a", Quantity::kAcc},
                                 {"xl", Quantity::kAcc},
                                 {"totalacceleration", Quantity::kAcc},
                                 {"gyr", Quantity::kGyr},
                                 {"gyro", Quantity::kGyr},
                                 {"gyroscope", Quantity::kGyr},
                                 {"omega", Quantity::kGyr},
                                 {"w", Quantity::kGyr},
                                 {"g", Quantity::kGyr},
                                 {"angular", Quantity::kGyr},
                                 {"angularvelocity", Quantity::kGyr},
                                 {"rotationrate", Quantity::kGyr},
                                 {"mag", Quantity::kMag},
                                 {"magn", Quantity::kMag},
                                 {"magnetometer", Quantity::kMag},
                                 {"magnetic", Quantity::kMag},
                                 {"m", Quantity::kMag},
                                 {"b", Quantity::kMag},
                                 {"compass", Quantity::kMag}};

/// The first of several has its number behind the word.
std::optional<Quantity> sensor_word(std::string_view part) {
  constexpr std::size_t kShortestWord = 3;  // a1, b2 are too little to tell
  const auto end = part.find_last_not_of("0123456789") + 1;
  if (end >= kShortestWord) part = part.substr(0, end);
  for (const Word& w : kSensorWords)
    if (w.text == part) return w.quantity;
  return std::nullopt;
}

struct Meaning {
  Quantity quantity;
  int axis;
};

/// Not by units that others have too: gauss, and angles.
std::optional<Quantity> by_unit(const std::string& unit) {
  const std::string u = plain(unit);
  for (const Quantity q : {Quantity::kAcc, Quantity::kGyr, Quantity::kMag})
    if (u != "g" && u != "rad" && u != "deg" && factor_of(q, unit) != 0.0) return q;
  return std::nullopt;
}

/// An axis at the end of the name (acc_x, ax, accelX), and the sensor by a part before it, the unit or the file's name.
std::optional<Meaning> meaning_of(const std::string& column, const std::string& file) {
  const bool in_brackets = column.find_first_of("[(") != std::string::npos;
  const bool suffixed = !in_brackets && column.size() > 1 && !unit_in(column).empty();
  auto parts = parts_of(suffixed ? column.substr(0, column.find_last_of("_ ")) : column);
  if (parts.empty()) return std::nullopt;
  std::string& last = parts.back();
  const int axis = last.empty() ? -1 : last.back() - 'x';
  if (axis < 0 || axis > 2) return std::nullopt;
  last.pop_back();
  for (const auto& part : parts)
    if (const auto sensor = sensor_word(part)) return Meaning{*sensor, axis};
  const bool bare = parts.size() == 1 && parts[0].empty();
  if (!bare) return std::nullopt;
  if (const auto sensor = by_unit(unit_in(column))) return Meaning{*sensor, axis};
  const std::string leaf =
      file.substr(file.find_last_of("/:\\") == std::string::npos ? 0 : file.find_last_of("/:\\") + 1);
  for (const auto& part : parts_of(leaf))
    if (const auto sensor = sensor_word(part)) return Meaning{*sensor, axis};
  return std::nullopt;
}

/// What a column's name holds that makes it second choice: gravity taken out, already processed, a reference.
bool second_choice(const std::string& column) {
  const std::string p = plain(column);
  for (const char* word :
       {"gravity", "linear", "user", "filtered", "bias", "ref", "orientation", "cov", "uncalibrated"})
    if (p.find(word) != std::string::npos) return true;
  return false;
}

}  // namespace

double factor_of(Quantity quantity, const std::string& unit) {
  static const std::map<std::string, double> kUnits[] = {{{"m/s2", 1.0},
                                                          {"ms-2", 1.0},
                                                          {"mps2", 1.0},
                                                          {"m/s/s", 1.0},
                                                          {"g", kStandardGravity_mps2},
                                                          {"mg", 1e-3 * kStandardGravity_mps2}},
                                                         {{"rad/s", 1.0},
                                                          {"rad", 1.0},
                                                          {"rads-1", 1.0},
                                                          {"radps", 1.0},
                                                          {"deg/s", kRadPerDeg},
                                                          {"deg", kRadPerDeg},
                                                          {"degs-1", kRadPerDeg},
                                                          {"dps", kRadPerDeg},
                                                          {"degps", kRadPerDeg},
                                                          {"mdps", 1e-3 * kRadPerDeg}},
                                                         {{"ut", 1.0},
                                                          {"nt", 1e-3},
                                                          {"mt", 1e3},
                                                          {"t", 1e6},
                                                          {"gauss", 100.0},
                                                          {"ga", 100.0},
                                                          {"g", 100.0},
                                                          {"mgauss", 0.1},
                                                          {"mga", 0.1},
                                                          {"mg", 0.1}},
                                                         {{"degc", 1.0}, {"c", 1.0}, {"celsius", 1.0}}};
  const auto& known = kUnits[static_cast<int>(quantity)];
  const auto found = known.find(plain(unit));
  return found == known.end() ? 0.0 : found->second;
}

double time_factor_ns(const std::string& unit) {
  static const std::map<std::string, double> kUnits{{"s", 1e9},  {"sec", 1e9},  {"seconds", 1e9},
                                                    {"ms", 1e6}, {"us", 1e3},   {"usec", 1e3},
                                                    {"ns", 1.0}, {"nsec", 1.0}, {"msec", 1e6}};
  const auto found = kUnits.find(plain(unit));
  return found == kUnits.end() ? 0.0 : found->second;
}

std::string unit_in(const std::string& column) {
  const auto open = column.find_last_of("[(");
  const auto close = column.find_last_of("])");
  if (open != std::string::npos && close != std::string::npos && close > open)
    return column.substr(open + 1, close - open - 1);
  const auto at = column.find_last_of("_ ");
  if (at == std::string::npos) return "";
  std::string last = column.substr(at + 1);
  if (last.size() < 2 && last != "s" && last != "g" && last != "T") return "";
  for (const Quantity q : {Quantity::kAcc, Quantity::kGyr, Quantity::kMag})
    if (factor_of(q, last) != 0.0) return last;
  return time_factor_ns(last) != 0.0 ? last : "";
}

int rank_as_time(const std::string& name) {
  const std::string p = plain(name.substr(0, name.find('[')));
  int rank = 0;
  if (p == "t" || p == "ts" || p == "sec" || p == "secondselapsed") rank = 1;
  if (p.find("time") != std::string::npos) rank = 2;
  if (p == "time" || p.find("timestamp") != std::string::npos) rank = 3;
  return rank > 0 && !unit_in(name).empty() ? rank + 1 : rank;
}

std::string time_column(const Table& table) {
  std::string best;
  int best_rank = 0;
  for (const Column& c : table.columns) {
    if (2 * c.numbers < table.rows()) continue;
    if (const int rank = rank_as_time(c.name); rank > best_rank) {
      best_rank = rank;
      best = c.name;
    }
  }
  return best;
}

ColumnMap guess(const Table& table) {
  ColumnMap map;
  map.time = time_column(table);
  for (const bool second : {false, true})
    for (const Quantity quantity : {Quantity::kAcc, Quantity::kGyr, Quantity::kMag}) {
      const bool known = std::any_of(map.sensors.begin(), map.sensors.end(),
                                     [&](const SensorColumns& s) { return s.quantity == quantity; });
      SensorColumns s{quantity, std::vector<std::string>(3), "", ""};
      for (const Column& c : table.columns) {
        const auto meaning = meaning_of(c.name, table.name);
        if (!meaning || meaning->quantity != quantity || second_choice(c.name) != second || c.numbers == 0) continue;
        auto& place = s.columns[static_cast<std::size_t>(meaning->axis)];
        if (place.empty()) place = c.name;
      }
      const bool whole = std::none_of(s.columns.begin(), s.columns.end(), [](const auto& c) { return c.empty(); });
      if (!whole || known) continue;
      s.unit = unit_in(s.columns[0]);
      map.sensors.push_back(s);
    }
  std::stable_sort(map.sensors.begin(), map.sensors.end(),
                   [](const auto& a, const auto& b) { return a.quantity < b.quantity; });
  for (const Column& c : table.columns) {
    const std::string p = plain(c.name);
    if (c.numbers == 0 || p.rfind("temp", 0) != 0) continue;
    map.sensors.push_back({Quantity::kTemp, {c.name}, "degC", ""});
    break;
  }
  return map;
}

}  // namespace stillpoint::exchange
