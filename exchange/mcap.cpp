// The format: mcap.dev/spec.
#include "exchange/mcap.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <map>
#include <set>

#include "exchange/cdr.h"
#include "exchange/mcap_records.h"

namespace stillpoint::exchange {
namespace {

constexpr std::size_t kLargestChunk_bytes = std::size_t{1} << 30;
constexpr std::size_t kTightest = 40000;  // zstd: a block of 128 KB out of four bytes

Result<std::string> unpacked(std::string_view packed, const std::string& how, std::size_t size,
                             const std::string& name) {
  if (size > kLargestChunk_bytes) return fail(ErrorKind::kBadData, name + ": a chunk of more than 1 GB; damaged");
  if (how.empty()) return std::string(packed);
  if (size / kTightest > packed.size())  // before memory is asked for it
    return fail(ErrorKind::kBadData, name + ": a chunk says more of its size than it holds; damaged");
  std::string out(size, '\0');
  std::size_t written = 0;
  if (how == "zstd") {
    written = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
    if (ZSTD_isError(written) != 0) written = out.size() + 1;
  } else if (how == "lz4") {
    LZ4F_dctx* context = nullptr;
    LZ4F_createDecompressionContext(&context, LZ4F_VERSION);
    std::size_t room = out.size(), used = packed.size();
    const std::size_t left = LZ4F_decompress(context, out.data(), &room, packed.data(), &used, nullptr);
    LZ4F_freeDecompressionContext(context);
    written = LZ4F_isError(left) != 0 ? out.size() + 1 : room;
  } else {
    return fail(ErrorKind::kBadData, fmt::format("{}: packed by '{}'; lz4, zstd and none are known", name, how));
  }
  if (written != size) return fail(ErrorKind::kBadData, name + ": a chunk is damaged; `mcap recover` keeps the others");
  return out;
}

/// A vector and its covariance, whose first element is -1 where the vector was not measured (REP-145): then NaN.
Vec3 measured_vector(CdrReader& cdr) {
  const Vec3 v = cdr.vector();
  const bool measured = cdr.number<double>() != -1.0;
  cdr.skip_numbers(8);
  return measured ? v : Vec3::Constant(io::kMissing);
}

struct Topic {
  std::string name, type;
  std::vector<Stream> streams;
  std::vector<std::vector<std::int64_t>> logged_ns;  ///< of each stream: when the bag took its messages
  std::size_t messages = 0, damaged = 0;
};

class Reader {
 public:
  explicit Reader(std::string name) : name_(std::move(name)) {}

  Result<void> records(std::string_view text, bool inside_chunk) {
    Bytes bytes(text);
    while (!bytes.done()) {
      const auto opcode = bytes.number<std::uint8_t>();
      const auto size = bytes.number<std::uint64_t>();
      const std::string_view body = bytes.take(size);
      if (bytes.ran_out()) {
        cut_ = true;
        return {};
      }
      if (opcode == mcap::kDataEnd || opcode == mcap::kFooter) return {};
      if (opcode == mcap::kChunk && inside_chunk)
        return fail(ErrorKind::kBadData, name_ + ": a chunk in a chunk; damaged");
      if (auto done = record(opcode, body); !done) return done;
    }
    return {};
  }

  Result<std::vector<Stream>> chosen(const std::string& wanted, std::vector<std::string>& reasons) {
    if (cut_) reasons.push_back(name_ + ": ends in the middle of a record; what is whole before it was taken");
    std::vector<Stream> out;
    for (const char* type : {"sensor_msgs/msg/Imu", "sensor_msgs/msg/MagneticField", "sensor_msgs/msg/Temperature"}) {
      Topic* best = nullptr;
      for (auto& [id, topic] : topics_)
        if (topic.type == type && topic.messages > 0 &&
            (best == nullptr || topic.name == wanted || (best->name != wanted && topic.messages > best->messages)))
          best = &topic;
      if (best == nullptr) continue;
      if (best->damaged > 0)
        reasons.push_back(fmt::format("{}: {} messages of {} are damaged", name_, best->damaged, best->name));
      if (unstamped(*best)) {
        reasons.push_back(fmt::format("{}: the stamps of {} do not advance; its times are those of the bag's log",
                                      name_, best->name));
        for (std::size_t i = 0; i < best->streams.size(); ++i) best->streams[i].t_ns = std::move(best->logged_ns[i]);
      }
      std::move(best->streams.begin(), best->streams.end(), std::back_inserter(out));
    }
    if (!out.empty()) return out;
    std::set<std::string> there;
    for (const auto& [id, topic] : topics_) there.insert(fmt::format("{} ({})", topic.name, topic.type));
    return fail(ErrorKind::kBadData, fmt::format("{}: no sensor_msgs/msg/Imu in it; topics: {}", name_,
                                                 there.empty() ? "none" : fmt::format("{}", fmt::join(there, ", "))));
  }

 private:
  Result<void> record(std::uint8_t opcode, std::string_view body) {
    Bytes b(body);
    if (opcode == mcap::kSchema) {
      const auto id = b.number<std::uint16_t>();
      schemas_[id] = b.prefixed();
    } else if (opcode == mcap::kChannel) {
      const auto id = b.number<std::uint16_t>(), schema = b.number<std::uint16_t>();
      const std::string topic(b.prefixed()), encoding(b.prefixed());
      topics_.try_emplace(id, Topic{topic, encoding == "cdr" ? schemas_[schema] : encoding, {}, {}, 0, 0});
    } else if (opcode == mcap::kMessage) {
      const auto id = b.number<std::uint16_t>();
      b.skip(4);  // sequence
      const auto logged_ns = static_cast<std::int64_t>(std::min<std::uint64_t>(b.number<std::uint64_t>(), kLatest_ns));
      if (const auto topic = topics_.find(id); topic != topics_.end() && body.size() > 22)
        message(topic->second, logged_ns, body.substr(22));
    } else if (opcode == mcap::kChunk) {
      b.skip(16);  // first and last time
      const auto size = b.number<std::uint64_t>();
      b.skip(4);  // checksum
      const std::string how(b.prefixed());
      const std::string_view packed = b.take(b.number<std::uint64_t>());
      const auto text = unpacked(packed, how, size, name_);
      return text ? records(*text, true) : tl::make_unexpected(text.error());
    }
    return {};
  }

  /// A driver without a clock leaves the same stamp, most often zero, in every message.
  static bool unstamped(const Topic& topic) {
    return std::any_of(topic.streams.begin(), topic.streams.end(), [](const Stream& s) {
      return s.t_ns.size() > 1 && s.t_ns == std::vector<std::int64_t>(s.t_ns.size(), s.t_ns.front());
    });
  }

  void message(Topic& topic, std::int64_t logged_ns, std::string_view data) {
    const bool imu = topic.type == "sensor_msgs/msg/Imu", mag = topic.type == "sensor_msgs/msg/MagneticField";
    if (!imu && !mag && topic.type != "sensor_msgs/msg/Temperature") return;
    CdrReader cdr(data);
    const std::int64_t t_ns = cdr.header();
    Vec3 first, second = Vec3::Zero();
    if (imu) {
      cdr.skip_numbers(4 + 9);  // orientation and its covariance
      first = measured_vector(cdr);
      second = measured_vector(cdr);
    } else {
      first = mag ? Vec3(1e6 * cdr.vector()) : Vec3(cdr.number<double>(), 0.0, 0.0);
    }
    if (!cdr.good()) {
      ++topic.damaged;
      return;
    }
    ++topic.messages;
    if (topic.streams.empty()) {
      const std::string from = name_ + " " + topic.name;
      if (imu) topic.streams = {{Quantity::kGyr, from, {}, {}}, {Quantity::kAcc, from, {}, {}}};
      if (!imu) topic.streams = {{mag ? Quantity::kMag : Quantity::kTemp, from, {}, {}}};
    }
    topic.logged_ns.resize(topic.streams.size());
    const auto add = [&](std::size_t i, const Vec3& value) {
      if (!value.allFinite()) return;
      topic.streams[i].add(t_ns, value);
      topic.logged_ns[i].push_back(logged_ns);
    };
    add(0, first);
    if (imu) add(1, second);
  }

  std::string name_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, Topic> topics_;
  bool cut_ = false;
};

}  // namespace

bool is_mcap(std::string_view bytes) { return bytes.substr(0, mcap::kMagic.size()) == mcap::kMagic; }

Result<std::vector<Stream>> read_mcap(std::string_view bytes, const std::string& name, const std::string& topic,
                                      std::vector<std::string>& reasons) {
  if (!is_mcap(bytes)) return fail(ErrorKind::kBadData, name + ": no MCAP file");
  Reader reader(name);
  if (auto done = reader.records(bytes.substr(mcap::kMagic.size()), false); !done) return tl::unexpected(done.error());
  return reader.chosen(topic, reasons);
}

}  // namespace stillpoint::exchange
