/// `bench/latency`: from the instant a sample is due to the callback in another process, for the daemon and,
/// interleaved in the same run, for the floors beneath it. docs/latency.md explains how to read it.
#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <thread>

#include "bench/arguments.h"
#include "bench/latency_report.h"
#include "io/dds_domain.h"

namespace stillpoint::bench {
namespace {

struct Options {
  std::vector<double> rates_hz{100, 1000, 4000};
  std::vector<std::string> channels = kChannels;
  int repeats = 5;
  double seconds = 2.0;
  int fifo_priority = 50;
  std::string daemon, json_path, figure_path, limits_path;
  std::string receive_channel;  ///< set in the receiving process
  int where = 0, core = -1;
};

/// Total and stolen processor time since boot, in ticks.
std::array<double, 2> processor_time() {
  std::ifstream file("/proc/stat");
  std::string word;
  file >> word;
  double total = 0, steal = 0, value = 0;
  for (int i = 0; i < 8 && file >> value; ++i) {
    total += value;
    if (i == 7) steal = value;
  }
  return {total, steal};
}

double load() {
  double one_minute = 0;
  std::ifstream("/proc/loadavg") >> one_minute;
  return one_minute;
}

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

bool fifo_permitted(int priority) {
  bool granted = false;
  std::thread([&] { granted = schedule_this_thread(-1, priority); }).join();
  return granted;
}

Series& series_of(LatencyReport& report, const std::string& channel, double rate_hz) {
  for (Series& s : report.series)
    if (s.channel == channel && s.rate_hz == rate_hz) return s;
  return report.series.emplace_back(Series{.channel = channel, .rate_hz = rate_hz, .repeats = {}, .sorted_us = {}});
}

/// Repeats outermost: every channel is measured once before any is measured again.
Result<LatencyReport> measure(const Options& options, CellSetup setup) {
  LatencyReport report;
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    for (const double rate_hz : options.rates_hz)
      for (const std::string& channel : options.channels) {
        setup.channel = channel;
        setup.rate_hz = rate_hz;
        // The daemon is matched while it already runs, so it needs more time for as many messages.
        setup.seconds = options.seconds + (channel.starts_with("daemon/") ? 0.5 : 0.0);
        const auto receipts = run_cell(setup);
        if (!receipts)
          return fail(receipts.error().kind,
                      fmt::format("{} at {} Hz: {}", channel, rate_hz, receipts.error().message));
        if (receipts->size() < 20)
          return fail(ErrorKind::kUnavailable,
                      fmt::format("{} at {} Hz: only {} messages arrived", channel, rate_hz, receipts->size()));
        Series& series = series_of(report, channel, rate_hz);
        series.repeats.push_back(make_cell(*receipts));
        for (std::size_t i = receipts->size() / 4; i < receipts->size(); ++i)
          series.sorted_us.push_back(1e-3 * static_cast<double>((*receipts)[i].latency_ns));
        std::fprintf(stderr, "\rrepeat %d/%d  %5.0f Hz  %-22s", repeat + 1, options.repeats, rate_hz, channel.c_str());
      }
  std::fputs("\n", stderr);
  for (Series& s : report.series) std::sort(s.sorted_us.begin(), s.sorted_us.end());
  return report;
}

bool write_file(const std::string& path, const std::string& content) {
  std::ofstream file(path);
  file << content;
  if (file.flush()) return true;
  std::fprintf(stderr, "latency: %s: cannot be written; does the folder exist?\n", path.c_str());
  return false;
}

int judge(const LatencyReport& report, const std::string& path) {
  std::ifstream file(path);
  const auto limits = nlohmann::json::parse(file, nullptr, false);
  if (limits.is_discarded() || !limits.contains("limits")) {
    std::fprintf(stderr, "latency: %s: no such file, or no limits in it\n", path.c_str());
    return static_cast<int>(ErrorKind::kBadConfig);
  }
  const auto found = regressions(report, limits);
  for (const std::string& line : found) std::fprintf(stderr, "latency: regression: %s\n", line.c_str());
  if (found.empty()) std::fprintf(stderr, "latency: within the limits of %s\n", path.c_str());
  return found.empty() ? 0 : static_cast<int>(ErrorKind::kThreshold);
}

int run(const Options& options) {
  const bool with_daemon = std::any_of(options.channels.begin(), options.channels.end(),
                                       [](const std::string& channel) { return channel.starts_with("daemon/"); });
  if (with_daemon && access(options.daemon.c_str(), X_OK) != 0) {
    std::fprintf(stderr, "latency: %s: no such program; build stillpointd, or name it with --daemon\n",
                 options.daemon.c_str());
    return static_cast<int>(ErrorKind::kNoInput);
  }
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  const bool fifo = options.fifo_priority > 0 && fifo_permitted(options.fifo_priority);
  CellSetup setup;
  setup.domain = io::own_domain();
  setup.fifo_priority = fifo ? options.fifo_priority : 0;
  if (cores >= 2) {
    setup.send_core = 0;
    setup.receive_core = 1;
  }
  setup.daemon = options.daemon;
  setup.self = std::filesystem::read_symlink("/proc/self/exe");
  const double load_before = load();
  const auto time_before = processor_time();
  auto report = measure(options, setup);
  if (!report) {
    std::fprintf(stderr, "\nlatency: %s\n", report.error().message.c_str());
    return static_cast<int>(report.error().kind);
  }
  const auto time_after = processor_time();
  utsname system{};
  uname(&system);
  report->machine = {.cpu = cpu_name(),
                     .kernel = system.release,
                     .scheduling = fmt::format("{}, {}", fifo ? "SCHED_FIFO" : "normal scheduling",
                                               cores >= 2 ? "sender on core 0, receiver on core 1" : "one core"),
                     .cores = cores,
                     .load_before = load_before,
                     .load_after = load(),
                     .steal_share = (time_after[1] - time_before[1]) / std::max(1.0, time_after[0] - time_before[0])};
  const std::string document = json(*report).dump(2) + "\n";
  if (options.json_path != "-") std::cout << text(*report) << std::flush;
  if (options.json_path == "-") std::cout << document << std::flush;
  bool written = options.json_path.empty() || options.json_path == "-" || write_file(options.json_path, document);
  if (!options.figure_path.empty()) written = write_file(options.figure_path, svg(*report)) && written;
  if (!written) return static_cast<int>(ErrorKind::kCannotCreate);
  return options.limits_path.empty() ? 0 : judge(*report, options.limits_path);
}

}  // namespace
}  // namespace stillpoint::bench

int main(int argc, char** argv) {
  using namespace stillpoint::bench;
  Options options;
  options.daemon = STILLPOINTD;
  CLI::App app{"Latency from a sample to a subscriber in another process, beside the floors of the same run"};
  app.add_option("--rates", options.rates_hz, "Hz")->capture_default_str();
  app.add_option("--channels", options.channels)->check(CLI::IsMember(kChannels))->capture_default_str();
  app.add_option("--repeats", options.repeats)->check(CLI::Range(1, 100))->capture_default_str();
  app.add_option("--seconds", options.seconds, "of one channel at one rate in one repeat")->capture_default_str();
  app.add_option("--fifo", options.fifo_priority, "SCHED_FIFO priority where permitted, 0 for normal scheduling")
      ->capture_default_str();
  app.add_option("--daemon", options.daemon, "path of stillpointd")->capture_default_str();
  app.add_option("--json", options.json_path, "file, - for standard output");
  app.add_option("--figure", options.figure_path, "percentile curves (.svg)");
  app.add_option("--regression", options.limits_path, "exit 1 when a ratio exceeds the limits in this file");
  app.add_option("--receive", options.receive_channel)->group("");
  app.add_option("--where", options.where)->group("");
  app.add_option("--core", options.core)->group("");
  if (const auto end = parse(app, argc, argv)) return *end;
  if (options.receive_channel.empty()) return run(options);
  schedule_this_thread(options.core, options.fifo_priority);
  return receive(options.receive_channel, options.where);
}
