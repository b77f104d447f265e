// The format: docs.px4.io, "ULog File Format".
#include "exchange/ulog.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "exchange/bytes.h"

namespace stillpoint::exchange {
namespace {

constexpr std::string_view kUlogMagic("ULog\x01\x12\x35", 7);

constexpr std::size_t kLongestRecord = 65535;                ///< what the length of a message can say
constexpr std::uint64_t kLatest_us = 4'600'000'000'000'000;  ///< 146 years: in ns the difference of any two fits

struct Field {
  std::string type, name;
  std::size_t count = 1;
};

std::size_t size_of(const std::string& type) {
  static const std::map<std::string, std::size_t> kSizes{
      {"int8_t", 1},  {"uint8_t", 1},  {"bool", 1},  {"char", 1},    {"int16_t", 2},  {"uint16_t", 2},
      {"int32_t", 4}, {"uint32_t", 4}, {"float", 4}, {"int64_t", 8}, {"uint64_t", 8}, {"double", 8}};
  const auto found = kSizes.find(type);
  return found == kSizes.end() ? 0 : found->second;
}

/// "float[3] gyro_rad" and the like.
Field parse_field(std::string_view text) {
  Field f;
  const auto blank = text.find(' ');
  std::string_view type = text.substr(0, blank);
  if (blank != std::string_view::npos) f.name = text.substr(blank + 1);
  if (const auto open = type.find('['); open != std::string_view::npos) {
    std::from_chars(type.data() + open + 1, type.data() + type.size(), f.count);
    type = type.substr(0, open);
  }
  f.type = type;
  return f;
}

/// What is read of a topic: where its vector stands, or its three numbers, and the factor to our unit.
struct Wanted {
  const char* topic;
  const char* vector;  ///< empty: fields x, y, z
  Quantity quantity;
  double factor;
  bool second_choice;
};
constexpr Wanted kWanted[] = {
    {"sensor_accel", "", Quantity::kAcc, 1.0, false},
    {"sensor_gyro", "", Quantity::kGyr, 1.0, false},
    {"sensor_mag", "", Quantity::kMag, 100.0, false},  // gauss
    {"sensor_combined", "accelerometer_m_s2", Quantity::kAcc, 1.0, true},
    {"sensor_combined", "gyro_rad", Quantity::kGyr, 1.0, true},
    {"vehicle_magnetometer", "magnetometer_ga", Quantity::kMag, 100.0, true},
};

struct Place {
  std::size_t offset;
  std::string type;
};

/// NaN where the record ends before it.
double number_at(std::string_view data, const Place& place) {
  Bytes bytes(data);
  bytes.seek(place.offset);
  const double value = place.type == "double" ? bytes.number<double>() : static_cast<double>(bytes.number<float>());
  return bytes.ran_out() ? io::kMissing : value;
}

/// None where the record ends before it, or where no clock can be.
std::optional<std::int64_t> time_at(std::string_view data, const Place& place) {
  Bytes bytes(data);
  bytes.seek(place.offset);
  const auto us = bytes.number<std::uint64_t>();
  if (bytes.ran_out() || us > kLatest_us) return std::nullopt;
  return static_cast<std::int64_t>(us) * 1000;
}

class UlogReader {
 public:
  UlogReader(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  Result<std::vector<Stream>> run(std::vector<std::string>& reasons) {
    bytes_.skip(16);
    while (!bytes_.done()) {
      const auto size = bytes_.number<std::uint16_t>();
      const char type = bytes_.number<char>();
      const std::string_view body = bytes_.take(size);
      if (bytes_.ran_out()) {
        reasons.push_back(name_ + ": ends in the middle of a message; what is whole before it was taken");
        break;
      }
      if (auto done = message(type, body); !done) return tl::unexpected(done.error());
    }
    if (dropouts_ > 0) reasons.push_back(fmt::format("{}: {} dropouts of the logger", name_, dropouts_));
    return chosen(reasons);
  }

 private:
  Result<void> message(char type, std::string_view body) {
    if (type == 'F') {
      const auto colon = body.find(':');
      if (colon == std::string_view::npos)
        return fail(ErrorKind::kBadData, name_ + ": a format without fields; damaged");
      formats_[std::string(body.substr(0, colon))] = body.substr(colon + 1);
    } else if (type == 'A' && body.size() > 3) {
      Bytes b(body);
      const auto instance = b.number<std::uint8_t>();
      const auto id = b.number<std::uint16_t>();
      if (instance == 0) subscribe(id, std::string(body.substr(3)));
    } else if (type == 'D' && body.size() > 2) {
      Bytes b(body);
      const auto found = topics_.find(b.number<std::uint16_t>());
      if (found != topics_.end())
        for (auto& part : found->second) add(part, body.substr(2));
    } else if (type == 'O') {
      ++dropouts_;
    }
    return {};
  }

  struct Part {
    Stream stream;
    Place time;
    std::array<Place, 3> axes;
    std::optional<Place> temp;
    Stream temps;
    double factor;
    bool second_choice;
  };

  void subscribe(std::uint16_t id, const std::string& topic) {
    for (const Wanted& w : kWanted) {
      if (topic != w.topic) continue;
      const auto places = places_of(formats_[topic]);
      const auto at = [&](const std::string& field) -> std::optional<Place> {
        const auto found = places.find(field);
        return found == places.end() ? std::nullopt : std::optional(found->second);
      };
      const std::string vector = w.vector;
      auto time = at("timestamp_sample");
      if (!time) time = at("timestamp");
      auto x = at(vector.empty() ? "x" : vector + "[0]"), y = at(vector.empty() ? "y" : vector + "[1]"),
           z = at(vector.empty() ? "z" : vector + "[2]");
      const auto is_number = [](const Place& p) { return p.type == "float" || p.type == "double"; };
      if (!time || !x || !y || !z || time->type != "uint64_t" || !is_number(*x) || !is_number(*y) || !is_number(*z))
        continue;
      const auto temp = w.quantity == Quantity::kAcc ? at("temperature") : std::nullopt;
      const std::string from = name_ + " " + topic;
      topics_[id].push_back({{w.quantity, from, {}, {}},
                             *time,
                             {*x, *y, *z},
                             temp && is_number(*temp) ? temp : std::nullopt,
                             {Quantity::kTemp, from + ".temperature", {}, {}},
                             w.factor,
                             w.second_choice});
    }
  }

  /// Fields of plain types by name, of arrays the first three elements as name[i]; what comes after a nested type, or
  /// cannot be in a record, is not found.
  static std::map<std::string, Place> places_of(std::string_view format) {
    std::map<std::string, Place> out;
    std::size_t offset = 0;
    while (!format.empty()) {
      const auto end = format.find(';');
      const Field f = parse_field(format.substr(0, end));
      format.remove_prefix(end == std::string_view::npos ? format.size() : end + 1);
      const std::size_t size = size_of(f.type);
      if (size == 0 || f.count > kLongestRecord / size || offset > kLongestRecord) break;
      for (std::size_t i = 0; i < std::min<std::size_t>(f.count, 3); ++i)
        out[f.count > 1 ? fmt::format("{}[{}]", f.name, i) : f.name] = {offset + i * size, f.type};
      offset += f.count * size;
    }
    return out;
  }

  static void add(Part& part, std::string_view data) {
    const auto t_ns = time_at(data, part.time);
    const Vec3 frd(number_at(data, part.axes[0]), number_at(data, part.axes[1]), number_at(data, part.axes[2]));
    const Vec3 flu = part.factor * Vec3(frd.x(), -frd.y(), -frd.z());
    if (!t_ns || !flu.allFinite()) return;
    part.stream.add(*t_ns, flu);
    const double temp = part.temp ? number_at(data, *part.temp) : io::kMissing;
    if (std::isfinite(temp)) part.temps.add(*t_ns, Vec3(temp, 0.0, 0.0));
  }

  /// The raw topic, or the one made of it where that has clearly more readings: PX4's default profile logs the raw ones
  /// at 1 Hz, to watch their temperature.
  Part* best_of(Quantity quantity, std::vector<std::string>& reasons) {
    Part *raw = nullptr, *made = nullptr;
    for (auto& [id, parts] : topics_)
      for (Part& part : parts) {
        if (part.stream.quantity != quantity || part.stream.t_ns.empty()) continue;
        Part*& place = part.second_choice ? made : raw;
        if (place == nullptr) place = &part;
      }
    if (raw == nullptr || made == nullptr) return raw != nullptr ? raw : made;
    const std::size_t few = raw->stream.t_ns.size(), many = made->stream.t_ns.size();
    if (many < few + few / 2) return raw;
    reasons.push_back(fmt::format("{} is taken for {}: it has {} readings, {} has {}", made->stream.from,
                                  name(quantity), many, raw->stream.from, few));
    if (made->temps.t_ns.empty()) made->temps = std::move(raw->temps);
    return made;
  }

  Result<std::vector<Stream>> chosen(std::vector<std::string>& reasons) {
    std::vector<Stream> out;
    for (const Quantity quantity : {Quantity::kAcc, Quantity::kGyr, Quantity::kMag}) {
      Part* const part = best_of(quantity, reasons);
      if (part == nullptr) continue;
      out.push_back(std::move(part->stream));
      if (!part->temps.t_ns.empty()) out.push_back(std::move(part->temps));
    }
    if (out.empty())
      return fail(ErrorKind::kBadData, name_ +
                                           ": no sensor_accel, sensor_gyro or sensor_combined in this log; log them "
                                           "(PX4: SDLOG_PROFILE, \"high rate\" or \"sensor comparison\")");
    reasons.push_back(name_ + ": axes turned from forward-right-down to forward-left-up");
    return out;
  }

  Bytes bytes_;
  std::string name_;
  std::map<std::string, std::string> formats_;
  std::map<std::uint16_t, std::vector<Part>> topics_;
  std::size_t dropouts_ = 0;
};

}  // namespace

bool is_ulog(std::string_view bytes) { return bytes.substr(0, kUlogMagic.size()) == kUlogMagic; }

Result<std::vector<Stream>> read_ulog(std::string_view bytes, const std::string& name,
                                      std::vector<std::string>& reasons) {
  if (!is_ulog(bytes)) return fail(ErrorKind::kBadData, name + ": no ULog file");
  return UlogReader(bytes, name).run(reasons);
}

}  // namespace stillpoint::exchange
