/// `bench/throughput`: how fast all stages go offline on one core, as `estimate` runs them: from memory, from CSV text,
/// and a day at 200 Hz. Prints samples a second; `--json` for scripts; `--at-least N` ends with 1 when the stages are
/// slower.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/arguments.h"
#include "bench/hand_samples.h"
#include "bench/processor_time.h"
#include "io/config.h"
#include "io/recording.h"
#include "pipeline/stages.h"

namespace stillpoint::bench {
namespace {

constexpr double kRate_hz = 200.0;
constexpr std::size_t kBlock = 12'000;  // a minute

/// The stages of `estimate` with its own calibrator.
class Offline {
 public:
  Offline()
      : calibrator_(config_.calibration.online, io::factory_calibration(config_.sensor)),
        link_(calibrator_),
        stages_(io::stages_params(config_), calibrator_.snapshot()) {}
  /// One sample; the heading's cosine goes into a sum, so that nothing is optimised away.
  void process(const RawSample& sample) {
    if (stages_.process(sample, out_, link_) != pipeline::StageStatus::kDrop) sum_ += out_.attitude.q_world_body[0];
  }
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] std::uint64_t windows() const { return stages_.counts().windows; }

 private:
  io::DaemonConfig config_;
  calib::OnlineCalibrator calibrator_;
  pipeline::DirectLink link_;
  pipeline::Stages stages_;
  pipeline::Processed out_;
  double sum_ = 0.0;
};

struct Speed {
  std::string what;
  std::uint64_t samples = 0;
  double wall_s = 0.0, processor_s = 0.0;
  std::uint64_t windows = 0;
  [[nodiscard]] double per_second() const { return static_cast<double>(samples) / processor_s; }
};

template <class Work>
Speed time(const char* what, std::uint64_t samples, const Work& work) {
  using Clock = std::chrono::steady_clock;
  const double processor_before = processor_s();
  const auto start = Clock::now();
  const std::uint64_t windows = work();
  return {.what = what,
          .samples = samples,
          .wall_s = std::chrono::duration<double>(Clock::now() - start).count(),
          .processor_s = processor_s() - processor_before,
          .windows = windows};
}

Speed from_memory(const std::vector<RawSample>& block, const char* what, std::uint64_t samples) {
  return time(what, samples, [&] {
    Offline offline;
    for (std::uint64_t k = 0; k < samples; ++k) {
      RawSample sample = block[k % kBlock];
      sample.sequence = k;
      sample.t_ns = static_cast<std::int64_t>(k) * 5'000'000;
      offline.process(sample);
    }
    if (!std::isfinite(offline.sum())) std::abort();
    return offline.windows();
  });
}

Result<Speed> from_csv(const std::vector<RawSample>& block, std::uint64_t samples) {
  std::string text =
      "time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps,mag_x_uT,mag_y_uT,mag_z_uT,"
      "temp_degC\n";
  for (std::uint64_t k = 0; k < samples; ++k) {
    const RawSample& s = block[k % kBlock];
    fmt::format_to(std::back_inserter(text),
                   "{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f},{:.4f},{:.2f}\n", k * 5'000'000,
                   s.acc_mps2[0], s.acc_mps2[1], s.acc_mps2[2], s.gyr_radps[0], s.gyr_radps[1], s.gyr_radps[2],
                   s.mag_uT[0], s.mag_uT[1], s.mag_uT[2], s.temp_degC);
  }
  std::string error;
  const Speed speed = time("CSV text to attitude", samples, [&]() -> std::uint64_t {
    const auto recording = io::parse_recording(text, "memory");
    if (!recording) {
      error = recording.error().message;
      return 0;
    }
    Offline offline;
    for (std::size_t row = 0; row < recording->size(); ++row) offline.process(recording->sample(row));
    return offline.windows();
  });
  if (!error.empty()) return fail(ErrorKind::kBadData, error);
  return speed;
}

int run(bool json, double day_h, double at_least) {
  const auto block = hand_samples(kBlock, kRate_hz);
  std::vector<Speed> speeds{from_memory(block, "samples in memory to attitude", 1'000'000)};
  const auto csv = from_csv(block, 500'000);
  if (!csv)
    return std::fprintf(stderr, "throughput: %s\n", csv.error().message.c_str()), static_cast<int>(csv.error().kind);
  speeds.push_back(*csv);
  if (day_h > 0)
    speeds.push_back(from_memory(block, "a day at 200 Hz", static_cast<std::uint64_t>(day_h * 3600.0 * kRate_hz)));
  auto list = nlohmann::json::array();
  for (const Speed& s : speeds) {
    list.push_back({{"what", s.what},
                    {"samples", s.samples},
                    {"wall_s", s.wall_s},
                    {"processor_s", s.processor_s},
                    {"rest_windows", s.windows},
                    {"samples_per_second", s.per_second()}});
    if (!json)
      fmt::print("{:<32}{:>10} samples  {:7.2f} s ({:.2f} s of processor)  {:>9.0f} samples/s  {} rest windows\n",
                 s.what, s.samples, s.wall_s, s.processor_s, s.per_second(), s.windows);
  }
  if (json) fmt::print("{}\n", nlohmann::json{{"schema", "stillpoint.throughput/1"}, {"runs", list}}.dump(2));
  return speeds.front().per_second() < at_least ? static_cast<int>(ErrorKind::kThreshold) : 0;
}

}  // namespace
}  // namespace stillpoint::bench

int main(int argc, char** argv) {
  bool json = false;
  double day_h = 24.0, at_least = 0.0;
  CLI::App app{"How fast all stages go offline on one core; rates are per second of processor time"};
  app.add_flag("--json", json);
  app.add_option("--day", day_h, "length of the long run at 200 Hz, h; 0: none")->capture_default_str();
  app.add_option("--at-least", at_least, "samples a second from memory; slower ends with exit code 1");
  if (const auto end = stillpoint::bench::parse(app, argc, argv)) return *end;
  return stillpoint::bench::run(json, day_h, at_least);
}
