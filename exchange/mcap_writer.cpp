// The format: mcap.dev/spec.
#include "exchange/mcap_writer.h"

#include <zlib.h>

#include <algorithm>

#include "exchange/cdr.h"
#include "exchange/mcap_records.h"

namespace stillpoint::exchange {
namespace {

constexpr std::uint64_t kChunk_ns = 1'000'000'000;
constexpr std::size_t kChunk_bytes = std::size_t{1} << 20;

struct WrittenTopic {
  const char *name, *type, *definition;
};
#define STILLPOINT_HEADER_DEFINITION                                                                                 \
  "================================================================================\nMSG: std_msgs/Header\n"         \
  "builtin_interfaces/Time stamp\nstring frame_id\n"                                                                 \
  "================================================================================\nMSG: builtin_interfaces/Time\n" \
  "int32 sec\nuint32 nanosec\n"
#define STILLPOINT_VECTOR_DEFINITION                                                                               \
  "================================================================================\nMSG: geometry_msgs/Vector3\n" \
  "float64 x\nfloat64 y\nfloat64 z\n"
constexpr WrittenTopic kAll[] = {
    {"/imu/data_raw", "sensor_msgs/msg/Imu",
     "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
     "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
     "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] "
     "linear_acceleration_covariance\n" STILLPOINT_HEADER_DEFINITION STILLPOINT_VECTOR_DEFINITION
     "================================================================================\nMSG: geometry_msgs/Quaternion\n"
     "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"},
    {"/imu/mag", "sensor_msgs/msg/MagneticField",
     "std_msgs/Header header\ngeometry_msgs/Vector3 magnetic_field\nfloat64[9] "
     "magnetic_field_covariance\n" STILLPOINT_HEADER_DEFINITION STILLPOINT_VECTOR_DEFINITION},
    {"/imu/temperature", "sensor_msgs/msg/Temperature",
     "std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n" STILLPOINT_HEADER_DEFINITION},
};
#undef STILLPOINT_HEADER_DEFINITION
#undef STILLPOINT_VECTOR_DEFINITION

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}
std::string record(mcap::Opcode opcode, const std::string& body) {
  std::string out(1, static_cast<char>(opcode));
  put(out, static_cast<std::uint64_t>(body.size()));
  return out + body;
}

std::string schemas_and_channels() {
  std::string out;
  std::uint16_t id = 0;
  for (const auto& topic : kAll) {
    ++id;
    std::string schema, channel;
    put(schema, id);
    for (const char* text : {topic.type, "ros2msg", topic.definition}) put_text(schema, text);
    put(channel, id);
    put(channel, id);
    put_text(channel, topic.name);
    put_text(channel, "cdr");
    put(channel, std::uint32_t{0});
    out += record(mcap::kSchema, schema) + record(mcap::kChannel, channel);
  }
  return out;
}

/// An element -1 of a covariance says that its quantity was not measured (REP-145).
std::string imu_message(const RawSample& s) {
  CdrWriter m;
  const auto covariance = [&m](bool measured) {
    m.number(measured ? 0.0 : -1.0);
    m.numbers(0.0, 8);
  };
  m.header(s.t_ns, "imu_link");
  m.numbers(0.0, 3);
  m.number(1.0);
  covariance(false);
  m.vector(s.gyr_radps);
  covariance(s.holds(kGyr));
  m.vector(s.acc_mps2);
  covariance(s.holds(kAcc));
  return m.bytes();
}
std::string mag_message(const RawSample& s) {
  CdrWriter m;
  m.header(s.t_ns, "imu_link");
  for (const double x : s.mag_uT) m.number(1e-6 * x);
  m.numbers(0.0, 9);
  return m.bytes();
}
std::string temp_message(const RawSample& s) {
  CdrWriter m;
  m.header(s.t_ns, "imu_link");
  m.number(s.temp_degC);
  m.number(0.0);
  return m.bytes();
}

}  // namespace

Result<McapWriter> McapWriter::create(const std::string& path) {
  auto file = io::OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  McapWriter writer(std::move(*file));
  std::string header;
  put_text(header, "ros2");
  put_text(header, "stillpoint");
  if (auto done = writer.write(std::string(mcap::kMagic) + record(mcap::kHeader, header) + schemas_and_channels());
      !done)
    return tl::unexpected(done.error());
  return writer;
}

Result<void> McapWriter::write(const std::string& bytes) {
  at_ += bytes.size();
  return file_.write(bytes);
}

void McapWriter::add_message(std::size_t topic, std::uint64_t t_ns, const std::string& message) {
  index_[topic].push_back({t_ns, chunk_.size()});
  std::string body;
  put(body, static_cast<std::uint16_t>(topic + 1));
  put(body, static_cast<std::uint32_t>(messages_[topic]++));
  put(body, t_ns);
  put(body, t_ns);
  chunk_ += record(mcap::kMessage, body + message);
}

Result<void> McapWriter::append(const RawSample& sample) {
  const auto t_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(sample.t_ns, 0));
  if (!chunk_.empty() && (t_ns - first_ns_ >= kChunk_ns || chunk_.size() > kChunk_bytes))
    if (auto done = write_chunk(); !done) return done;
  if (chunk_.empty()) first_ns_ = t_ns;
  last_ns_ = std::max(t_ns, first_ns_);
  if (sample.holds(kAcc) || sample.holds(kGyr)) add_message(0, t_ns, imu_message(sample));
  if (sample.holds(kMag)) add_message(1, t_ns, mag_message(sample));
  if (sample.holds(kTemp)) add_message(2, t_ns, temp_message(sample));
  ++rows_;
  return {};
}

Result<void> McapWriter::write_chunk() {
  std::string body;
  put(body, first_ns_);
  put(body, last_ns_);
  put(body, static_cast<std::uint64_t>(chunk_.size()));
  put(body, static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(chunk_.data()), chunk_.size())));
  put_text(body, "");
  put(body, static_cast<std::uint64_t>(chunk_.size()));
  std::string out = record(mcap::kChunk, body + chunk_);
  ChunkPlace place{first_ns_, last_ns_, at_, out.size(), 0, chunk_.size(), {}};
  for (std::size_t topic = 0; topic < kTopics; ++topic) {
    if (index_[topic].empty()) continue;
    place.index_at[topic] = at_ + out.size();
    std::string index;
    put(index, static_cast<std::uint16_t>(topic + 1));
    put(index, static_cast<std::uint32_t>(16 * index_[topic].size()));
    for (const Entry& e : index_[topic]) put(index, e.t_ns), put(index, e.offset);
    out += record(mcap::kMessageIndex, index);
    index_[topic].clear();
  }
  place.index_length = out.size() - place.length;
  chunks_.push_back(place);
  chunk_.clear();
  if (auto done = write(out); !done) return done;
  return file_.flush();
}

Result<void> McapWriter::finish() {
  if (!chunk_.empty())
    if (auto done = write_chunk(); !done) return done;
  std::string out = record(mcap::kDataEnd, std::string(4, '\0'));
  const std::uint64_t summary_at = at_ + out.size();
  out += schemas_and_channels();
  std::string statistics;
  put(statistics, messages_[0] + messages_[1] + messages_[2]);
  put(statistics, std::uint16_t{kTopics});
  put(statistics, std::uint32_t{kTopics});
  put(statistics, std::uint64_t{0});  // attachments, metadata
  put(statistics, static_cast<std::uint32_t>(chunks_.size()));
  put(statistics, chunks_.empty() ? std::uint64_t{0} : chunks_.front().first_ns);
  put(statistics, chunks_.empty() ? std::uint64_t{0} : chunks_.back().last_ns);
  put(statistics, std::uint32_t{10 * kTopics});
  for (std::size_t topic = 0; topic < kTopics; ++topic)
    put(statistics, static_cast<std::uint16_t>(topic + 1)), put(statistics, messages_[topic]);
  out += record(mcap::kStatistics, statistics);
  for (const ChunkPlace& c : chunks_) {
    std::string index, places;
    for (const std::uint64_t x : {c.first_ns, c.last_ns, c.start, c.length}) put(index, x);
    for (std::size_t topic = 0; topic < kTopics; ++topic)
      if (c.index_at[topic] != 0) put(places, static_cast<std::uint16_t>(topic + 1)), put(places, c.index_at[topic]);
    put_text(index, places);
    put(index, c.index_length);
    put_text(index, "");
    put(index, c.size);
    put(index, c.size);
    out += record(mcap::kChunkIndex, index);
  }
  std::string footer;
  put(footer, summary_at);
  put(footer, std::uint64_t{0});
  put(footer, std::uint32_t{0});
  if (auto done = write(out + record(mcap::kFooter, footer) + std::string(mcap::kMagic)); !done) return done;
  return file_.flush();
}

}  // namespace stillpoint::exchange
