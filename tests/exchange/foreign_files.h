/// One simulated motion, written the way other programs write theirs.
#pragma once
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "core/units.h"
#include "io/recording.h"
#include "simulation/simulator.h"
#include "tests/scratch_folder.h"

namespace stillpoint::test {

/// 20 s at 100 Hz of a motion that the simulator knows.
inline std::vector<RawSample> moved(const std::string& kind) {
  sim::SimulationConfig config;
  config.accelerometer = sim::TriadConfig{.noise_sd = 0.02};
  config.gyroscope = sim::TriadConfig{.noise_sd = 0.001};
  config.magnetometer = sim::TriadConfig{.noise_sd = 0.3};
  config.motion = sim::MotionConfig{.kind = kind, .duration_s = 20.0};
  std::vector<RawSample> out;
  for (const auto& row : sim::simulate(config, 1)) out.push_back(row.sample);
  return out;
}
inline std::vector<RawSample> hand() { return moved("hand"); }

/// A table of time and vectors; each value goes through `factor` on the way.
struct Written {
  std::string header, separator = ",";
  double time_factor = 1.0;
  std::int64_t time_origin = 0;  ///< with it times are whole numbers
  std::vector<std::pair<Array3 RawSample::*, double>> vectors;
};

inline std::string table(const std::vector<RawSample>& samples, const Written& w) {
  std::string text = w.header + "\n";
  for (const RawSample& s : samples) {
    const double t = in_seconds(s.t_ns) * w.time_factor;
    text += w.time_origin != 0 ? std::to_string(w.time_origin + std::llround(t)) : fmt::format("{:.9f}", t);
    for (const auto& [vector, factor] : w.vectors)
      for (const double x : s.*vector) text += w.separator + fmt::format("{:.9g}", x * factor);
    text += "\n";
  }
  return text;
}

/// Where a file of this process may stand: tests of one name run side by side. TEST_TMPDIR keeps it for others to read.
inline std::string scratch(const std::string& name) {
  if (const char* kept = std::getenv("TEST_TMPDIR")) return kept + name;
  static const ScratchFolder folder;
  return folder / name;
}

inline std::string file(const std::string& name, const std::string& content) {
  const std::string path = scratch(name);
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

/// A zlib stream of this kind: 31 gzip, -15 raw.
inline std::string deflated(const std::string& text, int kind) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, kind, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, text.size()) + 64, '\0');
  std::string in = text;
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::string zip(const std::vector<std::pair<std::string, std::string>>& members) {
  std::string out, directory;
  const auto common = [](std::string& to, const std::string& name, const std::string& text, const std::string& packed) {
    put<std::uint16_t>(to, 20), put<std::uint16_t>(to, 0), put<std::uint16_t>(to, 8), put<std::uint32_t>(to, 0);
    put<std::uint32_t>(
        to, static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size())));
    put<std::uint32_t>(to, static_cast<std::uint32_t>(packed.size()));
    put<std::uint32_t>(to, static_cast<std::uint32_t>(text.size()));
    put<std::uint16_t>(to, static_cast<std::uint16_t>(name.size()));
    put<std::uint16_t>(to, 0);
  };
  for (const auto& [name, text] : members) {
    const std::string packed = deflated(text, -15);
    const auto offset = static_cast<std::uint32_t>(out.size());
    put<std::uint32_t>(out, 0x04034b50);
    common(out, name, text, packed);
    out += name + packed;
    put<std::uint32_t>(directory, 0x02014b50);
    put<std::uint16_t>(directory, 20);
    common(directory, name, text, packed);
    put<std::uint16_t>(directory, 0), put<std::uint32_t>(directory, 0), put<std::uint32_t>(directory, 0);
    put<std::uint32_t>(directory, offset);
    directory += name;
  }
  const auto start = static_cast<std::uint32_t>(out.size());
  out += directory;
  put<std::uint32_t>(out, 0x06054b50), put<std::uint32_t>(out, 0);
  put<std::uint16_t>(out, static_cast<std::uint16_t>(members.size()));
  put<std::uint16_t>(out, static_cast<std::uint16_t>(members.size()));
  put<std::uint32_t>(out, static_cast<std::uint32_t>(directory.size()));
  put<std::uint32_t>(out, start);
  put<std::uint16_t>(out, 0);
  return out;
}

/// PX4's log with sensor_accel, sensor_gyro (forward-right-down) and sensor_mag in gauss. Its default profile has them
/// with one row in `thinned` alone, and all rows in sensor_combined.
inline std::string ulog(const std::vector<RawSample>& samples, std::size_t thinned = 1) {
  std::string out("ULog\x01\x12\x35\x01", 8);
  put<std::uint64_t>(out, 0);
  const auto message = [&out](char type, const std::string& body) {
    put<std::uint16_t>(out, static_cast<std::uint16_t>(body.size()));
    out += type + body;
  };
  const char* topics[] = {"sensor_accel", "sensor_gyro", "sensor_mag"};
  for (const char* topic : topics)
    message('F', std::string(topic) +
                     ":uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;"
                     "float temperature;uint8_t[4] _padding0;");
  for (std::uint16_t id = 0; id < 3; ++id) {
    std::string body(1, '\0');
    put(body, id);
    message('A', body + topics[id]);
  }
  constexpr std::uint16_t kCombined = 3;
  message('F', "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t dt;float[3] accelerometer_m_s2;");
  std::string combined(1, '\0');
  put(combined, kCombined);
  if (thinned > 1) message('A', combined + "sensor_combined");
  for (std::size_t row = 0; row < samples.size(); ++row) {
    const RawSample& s = samples[row];
    const Array3* vectors[] = {&s.acc_mps2, &s.gyr_radps, &s.mag_uT};
    if (thinned > 1) {
      std::string body;
      put(body, kCombined);
      put<std::uint64_t>(body, 5'000'000 + static_cast<std::uint64_t>(s.t_ns / 1000));
      for (const std::size_t k : {1, 0}) {
        const Array3& v = *vectors[k];
        for (const double x : {v[0], -v[1], -v[2]}) put(body, static_cast<float>(x));
        if (k == 1) put<std::uint32_t>(body, 5000);
      }
      message('D', body);
    }
    for (std::uint16_t id = 0; id < 3 && row % thinned == 0; ++id) {
      const Array3& v = *vectors[id];
      const double factor = id == 2 ? 0.01 : 1.0;
      std::string body;
      put(body, id);
      put<std::uint64_t>(body, 5'000'100 + static_cast<std::uint64_t>(s.t_ns / 1000));
      put<std::uint64_t>(body, 5'000'000 + static_cast<std::uint64_t>(s.t_ns / 1000));
      put<std::uint32_t>(body, 17);
      for (const double x : {v[0], -v[1], -v[2]}) put(body, static_cast<float>(factor * x));
      put(body, 31.5F);
      message('D', body + std::string(4, '\0'));
    }
  }
  return out;
}

}  // namespace stillpoint::test
