/// live_sources [--seconds S] [--rate HZ]: four daemons at once on one machine, in a network of their own, each with
/// another door for the same sensor: a recording at its own pace, a text stream through a FIFO, a ROS 2 driver, and an
/// iiod with an accelerometer and a gyroscope. Printed is what was sent and what went through, and the latency from
/// arrival to just before the write, beside that of the recording in the same run. Exit 1 when a reading was lost.
/// With --hours: so much of a stream at its rate, as fast as it goes through, and whether the daemon's memory grows.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "bench/arguments.h"
#include "core/clock.h"
#include "core/units.h"
#include "pipeline/clock.h"
#include "tests/dds/network_namespace.h"
#include "tests/dds/process.h"
#include "tests/sources/fake_iiod.h"

namespace {

using namespace stillpoint;

constexpr std::uint16_t kPort = 30431;
constexpr int kSettle_s = 3;  // for discovery, before anything is sent; and for the last reading, after it

/// No two readings in a row are the same: a living sensor.
std::string reading_text(std::int64_t k) {
  const double x = 0.01 * static_cast<double>(k % 7), w = 1e-3 * static_cast<double>(k % 5);
  return fmt::format("{:.3f},0.1,{:.3f},{:.4f},0.001,{:.4f}", x, 9.8 + x, w, -w);
}
constexpr char kColumns[] = "acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps\n";

test::FakeDevice device(const char* id, const char* name, const std::string& type, double rate_hz,
                        std::atomic<std::int64_t>& sent) {
  std::string xml;
  std::map<std::string, std::string> attributes{{"/sampling_frequency", std::to_string(rate_hz)},
                                                {"/current_timestamp_clock", "monotonic"}};
  for (int axis = 0; axis < 3; ++axis) {
    const std::string channel = type + "_" + "xyz"[axis];
    xml += fmt::format(
        R"(<channel id="{}" type="input"><scan-element index="{}" format="le:s32/32&gt;&gt;0" /><attribute name="raw" filename="r" /><attribute name="scale" filename="s" /></channel>)",
        channel, axis);
    attributes[channel + "/scale"] = "0.001";
    attributes[channel + "/raw"] = "0";
  }
  xml += R"(<channel id="timestamp" type="input"><scan-element index="3" format="le:s64/64&gt;&gt;0" /></channel>)";
  return {id,
          name,
          xml,
          rate_hz,
          [&sent, rate_hz, start_ns = std::int64_t{0}](std::int64_t k) mutable {
            if (k == 0) start_ns = monotonic_ns();  // both devices' stamps are those of their readings
            std::string scan(24, '\0');
            const std::array<std::int32_t, 3> raw{static_cast<std::int32_t>(k % 7), 100,
                                                  static_cast<std::int32_t>(9800 + k % 5)};
            const std::int64_t t_ns = start_ns + static_cast<std::int64_t>(1e9 / rate_hz) * k;
            std::memcpy(scan.data(), raw.data(), 12);
            std::memcpy(scan.data() + 16, &t_ns, 8);
            sent = k + 1;
            return scan;
          },
          attributes};
}

struct Door {
  std::string name, source;
  std::int64_t sent = 0;
};

/// What the daemon says at its end: "... samples=1 published=1 gaps=0 ... latency_us p50=1.0 p99=2.0 max=3.0 ...".
double said(const std::string& text, const std::string& key) {
  const auto line = text.rfind("ended: ");
  const auto at = line == std::string::npos ? line : text.find(" " + key + "=", line);
  return at == std::string::npos ? NAN : std::strtod(text.c_str() + at + key.size() + 2, nullptr);
}

void write_stream(const std::string& fifo, int rate_hz, std::int64_t count) {
  std::ofstream out(fifo);
  out << "time_us," << kColumns << std::flush;
  const std::int64_t start_ns = monotonic_ns();
  for (std::int64_t k = 0; k < count; ++k) {
    pipeline::sleep_until_ns(start_ns + 1'000'000'000LL * k / rate_hz);
    out << fmt::format("{},{}\n", 1'000'000LL * k / rate_hz, reading_text(k)) << std::flush;
  }
}

int run(int seconds, int rate_hz, const std::filesystem::path& folder) {
  const std::int64_t count = static_cast<std::int64_t>(seconds) * rate_hz;
  const std::string recording = folder / "recording.csv", fifo = folder / "imu.fifo";
  {
    std::ofstream out(recording);
    out << "time_us," << kColumns;
    for (std::int64_t k = 0; k < count; ++k) out << fmt::format("{},{}\n", 1'000'000LL * k / rate_hz, reading_text(k));
  }
  if (mkfifo(fifo.c_str(), 0600) != 0) throw std::runtime_error("no FIFO");
  std::atomic<std::int64_t> acc_sent{0}, gyr_sent{0};
  const double hz = rate_hz;
  test::FakeIiod iiod(
      {device("iio:device0", "accel", "accel", hz, acc_sent), device("iio:device1", "gyro", "anglvel", hz, gyr_sent)},
      kPort);
  std::vector<Door> doors{{"recording", "{kind: recording, file: " + recording + ", speed: 1}", count},
                          {"stream (FIFO, text)", "{kind: stream, from: " + fifo + "}", count},
                          {"ROS 2", "{kind: ros2, reliable: true, domain: 9}", count},
                          {"iiod", fmt::format("{{kind: iio, uri: 'ip:127.0.0.1:{}', block_s: 0.005}}", kPort), 0}};
  std::vector<std::unique_ptr<test::Process>> daemons;
  for (std::size_t i = 0; i < doors.size(); ++i) {
    const std::string config = folder / fmt::format("{}.yaml", i);
    std::ofstream(config) << fmt::format("source: {}\nsensor: {{id: door{}}}\ndds: {{domain: {}}}\n", doors[i].source,
                                         i, i + 1);
    daemons.push_back(std::make_unique<test::Process>(std::vector<std::string>{STILLPOINTD, "--config", config},
                                                      folder / fmt::format("{}.log", i)));
  }
  std::this_thread::sleep_for(std::chrono::seconds(kSettle_s));
  test::Process driver({ROS2_DRIVER, "9", std::to_string(count), std::to_string(rate_hz)});
  write_stream(fifo, rate_hz, count);
  doors[2].sent -= std::atoll(driver.output().c_str());  // before the two had met
  driver.wait();
  std::this_thread::sleep_for(std::chrono::seconds(kSettle_s));
  doors[3].sent = gyr_sent;
  for (auto& daemon : daemons) daemon->send(SIGTERM);
  for (auto& daemon : daemons) daemon->wait();
  fmt::print("| door | sent | through | refused | gaps | p50 us | p99 us | max us | p50, p99 over the recording's |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|\n");
  bool whole = true;
  double p50 = NAN, p99 = NAN;
  for (std::size_t i = 0; i < doors.size(); ++i) {
    std::stringstream text;
    text << std::ifstream(folder / fmt::format("{}.log", i)).rdbuf();
    const std::string log = text.str();
    const double through = said(log, "samples"), refused = said(log, "refused"), gaps = said(log, "gaps"),
                 middle = said(log, "p50"), late = said(log, "p99");
    if (i == 0) p50 = middle, p99 = late;
    // An iiod sends until it is cut off: what it has in hand then was never asked for.
    const double in_hand = i == 3 ? 0.02 * hz + kSettle_s * hz : 0.0;
    // The stamps of the ROS 2 driver are those of its writes, and as uneven as these.
    whole = whole && refused == 0 && (gaps == 0 || i == 2) && through >= static_cast<double>(doors[i].sent) - in_hand;
    fmt::print("| {} | {} | {:.0f} | {:.0f} | {:.0f} | {:.1f} | {:.1f} | {:.0f} | {:.2f}, {:.2f} |\n", doors[i].name,
               doors[i].sent, through, refused, gaps, middle, late, said(log, "max"), middle / p50, late / p99);
    if (!(through > 0) || refused > 0) fmt::print(stderr, "{}\n", log);
  }
  return whole ? 0 : 1;
}

/// Resident memory of a process, kB.
double resident_kb(pid_t pid) {
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) return std::strtod(line.c_str() + 6, nullptr);
  return NAN;
}

int run_long(double hours, int rate_hz, const std::filesystem::path& folder) {
  const std::string fifo = folder / "imu.fifo", config = folder / "long.yaml", log = folder / "long.log";
  if (mkfifo(fifo.c_str(), 0600) != 0) throw std::runtime_error("no FIFO");
  std::ofstream(config) << fmt::format("source: {{kind: stream, from: {}}}\nsensor: {{id: long}}\n", fifo);
  test::Process daemon({STILLPOINTD, "--config", config}, log);
  std::ofstream out(fifo);
  out << "time_us," << kColumns;
  const auto count = static_cast<std::int64_t>(hours * 3600.0 * rate_hz);
  double settled_kb = NAN;
  const std::int64_t start_ns = monotonic_ns();
  for (std::int64_t k = 0; k < count; ++k) {
    if (k == count / 10) settled_kb = resident_kb(daemon.id());
    out << fmt::format("{},{}\n", 1'000'000LL * k / rate_hz, reading_text(k));
  }
  out << std::flush;
  const double end_kb = resident_kb(daemon.id()), took_s = in_seconds(monotonic_ns() - start_ns);
  std::this_thread::sleep_for(std::chrono::seconds(kSettle_s));
  daemon.send(SIGTERM);
  daemon.wait();
  std::stringstream text;
  text << std::ifstream(log).rdbuf();
  const double through = said(text.str(), "samples"), dropped = said(text.str(), "dropped");
  fmt::print(
      "{:.3g} h at {} Hz in {:.0f} s: sent {}, through {:.0f}, gaps {:.0f}, dropped {:.0f}; resident {:.0f} kB "
      "after a tenth, {:.0f} kB at the end\n",
      hours, rate_hz, took_s, count, through, said(text.str(), "gaps"), dropped, settled_kb, end_kb);
  return through == static_cast<double>(count) && end_kb - settled_kb < 0.02 * settled_kb ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli{"Live sources beside a recording: what is lost, and how late it goes on.", "live_sources"};
  int seconds = 20, rate_hz = 1000;
  double hours = 0.0;
  cli.add_option("--seconds", seconds)->check(CLI::Range(5, 100000))->capture_default_str();
  cli.add_option("--rate", rate_hz, "readings a second")->check(CLI::Range(10, 4000))->capture_default_str();
  cli.add_option("--hours", hours, "of a stream, as fast as it goes through; 0: the four doors at their rate")
      ->check(CLI::Range(0.0, 10000.0));
  if (const auto code = bench::parse(cli, argc, argv)) return *code;
  const test::NetworkNamespace network;
  if (!network.ready()) return fmt::print(stderr, "live_sources: needs root and `ip`, for a network of its own\n"), 69;
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("live_sources.{}", getpid());
  std::filesystem::create_directory(folder);
  int code = 69;
  try {
    code = hours > 0 ? run_long(hours, rate_hz, folder) : run(seconds, rate_hz, folder);
  } catch (const std::exception& e) {
    fmt::print(stderr, "live_sources: {}\n", e.what());
  }
  std::filesystem::remove_all(folder);
  return code;
}
