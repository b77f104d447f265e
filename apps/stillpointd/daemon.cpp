#include "apps/stillpointd/daemon.h"

#include <fmt/format.h>

#include <cstdlib>
#include <thread>

#include "apps/stillpointd/log.h"
#include "apps/stillpointd/signals.h"
#include "apps/stillpointd/slow_work.h"
#include "apps/stillpointd/source.h"
#include "core/clock.h"
#include "io/calibration_state.h"

namespace stillpoint::app {
namespace {

constexpr double kLastSave_s = 5.0, kLastMessages_s = 1.0;

int report(const Error& error) {
  log(error.message);
  return static_cast<int>(error.kind);
}

/// What lives from the start of the program to its end.
struct Surroundings {
  const Signals signals{};
  ServiceManager service{};
  std::shared_ptr<Troubles> troubles = std::make_shared<Troubles>();
};

/// The configured source, waited for if the configuration says so. None: a signal came first.
Result<std::optional<DaemonSource>> wait_for_source(const io::DaemonConfig& config, Surroundings& around) {
  for (std::uint64_t tries = 1;; ++tries) {
    auto source = open_source(config);
    if (source) return std::optional<DaemonSource>(std::move(*source));
    if (source.error().kind != ErrorKind::kNoInput || !config.source.wait_for_file)
      return tl::unexpected(source.error());
    if (tries == 1) {
      log(fmt::format("waiting for {} (source.wait_for_file)", config.source.file));
      around.service.ready();
      around.service.status("waiting for " + config.source.file);
    }
    around.service.alive(tries);
    if (around.signals.end_is_asked()) return std::optional<DaemonSource>();
  }
}

std::string state_directory(const io::StateConfig& config) {
  if (!config.directory.empty()) return config.directory;
  const char* given = std::getenv("STATE_DIRECTORY");  // systemd sets it for StateDirectory=
  return given != nullptr ? given : "";
}

void restore(calib::OnlineCalibrator& calibrator, const io::StateStore& store) {
  std::vector<std::string> remarks;
  const auto loaded = store.load([&](std::span<const std::byte> bytes) {
    auto taken = io::restore_calibration({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, calibrator);
    if (taken) remarks = std::move(*taken);
    return taken ? std::string() : taken.error().message;
  });
  for (const auto& message : loaded.set_aside) log(message);
  for (const auto& remark : remarks) log(fmt::format("{}: {}", loaded.file, remark));
  log(loaded.payload.empty()
          ? "no kept calibration: the factory values serve"
          : fmt::format("calibration version {} from {}", calibrator.snapshot().version, loaded.file));
}

/// The driver's own topics are left to it: the daemon would hear itself.
io::DdsParams dds_of(const io::DaemonConfig& config) {
  io::DdsParams dds = config.dds;
  if (config.source.kind == io::SourceKind::kRos2) dds.ros2_readings = false;
  return dds;
}

/// What the system refuses a thread is said and shown; the thread runs on without it.
void prepare(const char* name, int core, int priority, Troubles& troubles) {
  int k = 0;
  for (const auto& refused : pipeline::prepare_thread(name, core, priority))
    troubles.set(fmt::format("{} thread {}", name, k++), refused);
}

void prepare_machine(const pipeline::ThreadParams& threads, Troubles& troubles) {
  if (threads.lock_memory) troubles.set("memory", pipeline::lock_memory().value_or(""));
  if (threads.cpu_latency_us >= 0)
    troubles.set("processors", pipeline::limit_cpu_latency(threads.cpu_latency_us).value_or(""));
}

/// Everything that lives as long as the two threads.
class Running {
 public:
  Running(const io::DaemonConfig& config, const std::string& config_file, Surroundings& around, DaemonSource source,
          Wire& wire, calib::OnlineCalibrator& calibrator, Keeper* keeper)
      : config_(config),
        config_file_(config_file),
        around_(around),
        live_(config),
        source_(std::move(source)),
        wire_(wire),
        keeper_(keeper),
        shared_(std::make_unique<pipeline::Shared>()),
        stages_(io::stages_params(config), calibrator.snapshot()),
        work_({config_, live_, wire_, calibrator, keeper_, *around_.troubles, around_.service, source_.report()},
              *shared_),
        sensor_(source_, stages_, wire_, *shared_,
                pipeline::is_live(source_) ? pipeline::OnLateAnswer::kGoOn : pipeline::OnLateAnswer::kWait,
                config.threads.rehearse_ahead_s),
        calibration_(calibrator, *shared_, work_, config.threads.calibration_poll_s) {}

  /// Returns when both threads have ended.
  void run() {
    std::jthread slow([this] {
      prepare("calibration", config_.threads.calibration_core, 0, *around_.troubles);
      calibration_.run();
    });
    std::jthread fast;
    try {
      fast = std::jthread([this] { run_sensor(); });
    } catch (...) {
      shared_->sensor_done = true;  // the other thread ends by this
      throw;
    }
    around_.service.ready();
    while (!shared_->sensor_done.load(std::memory_order_acquire)) obey_and_watch();
    around_.service.stopping();
    fast.join();
    slow.join();
    if (const auto report = shared_->report.try_load()) work_.tell_news(*report);
    work_.save();
    if (keeper_ != nullptr && !keeper_->finish(kLastSave_s)) log("the last state is not on disk: it takes too long");
    wire_.wait_for_acknowledgements(kLastMessages_s);
    summary();
  }

 private:
  void run_sensor() {
    const auto& threads = config_.threads;
    prepare("sensor", threads.sensor_core, threads.fifo_priority, *around_.troubles);
    sensor_.run(config_.source.at_end == io::SourceEnd::kStop ? pipeline::AtEnd::kStop : pipeline::AtEnd::kWait);
  }

  /// The watchdog is fed with what the sensor thread does: that this thread lives proves nothing.
  void obey_and_watch() {
    const auto asked = around_.signals.poll();
    if (const auto report = shared_->report.try_load()) around_.service.alive(report->rounds);
    if (!asked) return;
    if (asked->what == Asked::What::kReload)
      reload();
    else if (!shared_->stop.exchange(true))
      log(fmt::format("{}: ending", asked->by));
  }

  /// A configuration with a fault changes nothing.
  void reload() {
    around_.service.reloading();
    if (const auto read = io::read_config(config_file_); !read) {
      log("the configuration stays as it was:\n" + read.error().message);
    } else {
      const ConfigChange change = compare(config_, *read);
      live_.take(*read);
      if (change.dds) wire_.use(dds_of(*read));
      log(fmt::format(
          "{} read again: {}", config_file_,
          change.live.empty() ? "nothing that can change now" : fmt::format("{}", fmt::join(change.live, ", "))));
      if (!change.at_next_start.empty())
        log(fmt::format("only at the next start: {}", fmt::join(change.at_next_start, ", ")));
      config_.dds = read->dds;
      config_.stale_after_s = read->stale_after_s;
      config_.state.save_period_s = read->state.save_period_s;
    }
    around_.service.ready();
  }

  void summary() const {
    const auto report = shared_->report.try_load();
    if (!report) return;
    const auto latency = shared_->latency.counts(), processing = shared_->processing.counts();
    const auto us = [](const LatencyCounts& counts, double p) {
      return 1e-3 * static_cast<double>(latency_percentile_ns(counts, p));
    };
    log(fmt::format(
        "ended: samples={} published={} refused={} gaps={} windows={} version={} dropped={} "
        "latency_us p50={:.1f} p99={:.1f} max={:.1f} processing_us p50={:.2f} p99={:.2f}",
        report->guard.samples, report->published, report->guard.unused(), report->guard.gaps, report->stages.windows,
        stages_.live().version, report->ring_dropped, us(latency, 0.5), us(latency, 0.99),
        1e-3 * static_cast<double>(shared_->latency.max_ns()), us(processing, 0.5), us(processing, 0.99)));
  }

  io::DaemonConfig config_;
  const std::string config_file_;
  Surroundings& around_;
  LiveSettings live_;
  DaemonSource source_;
  Wire& wire_;
  Keeper* keeper_;
  std::unique_ptr<pipeline::Shared> shared_;
  pipeline::Stages stages_;
  SlowWork work_;
  pipeline::SensorLoop<DaemonSource, Wire> sensor_;
  pipeline::CalibrationLoop<SlowWork> calibration_;
};

void say_what_runs(const io::DaemonConfig& config) {
  log(fmt::format("sensor {}, source {}, world {}, domain {}, transport {}", config.sensor.id,
                  config.source.description(), config.output.world_frame == pipeline::WorldFrame::kEnu ? "ENU" : "NED",
                  config.dds.domain, config.dds.transport));
}

/// False: the end was asked for first.
bool subscribers_are_there(int wanted, Wire& wire, const Signals& signals) {
  // One that this side has matched drops what comes before it has matched this side, which no one is told of.
  constexpr std::int64_t kUntilMatched_ns = 200'000'000;
  for (std::int64_t since_ns = monotonic_ns(); wanted > 0 && monotonic_ns() - since_ns < kUntilMatched_ns;) {
    if (signals.end_is_asked()) return false;
    if (wire.report().attitude_subscribers < wanted) since_ns = monotonic_ns();
  }
  return true;
}

}  // namespace

int run_daemon(const io::DaemonConfig& config, const DaemonOptions& options) {
  Surroundings around;
  auto source = wait_for_source(config, around);
  if (!source) return report(source.error());
  if (!*source) return 0;

  calib::OnlineCalibrator calibrator(config.calibration.online, io::factory_calibration(config.sensor));
  std::optional<Keeper> keeper;
  if (const std::string directory = state_directory(config.state); !directory.empty()) {
    auto store = std::make_shared<io::StateStore>(directory, config.sensor.id, config.state.keep);
    keeper.emplace(store, around.troubles);
    if (const auto claimed = keeper->claim(); !claimed)
      return report({ErrorKind::kCannotCreate, claimed.error().message});
    restore(calibrator, *store);
  }
  Wire wire(dds_of(config), around.troubles);
  if (const auto started = wire.start(); !started) return report(started.error());
  prepare_machine(config.threads, *around.troubles);
  say_what_runs(config);
  if (!subscribers_are_there(options.wait_for_subscribers, wire, around.signals)) return 0;
  Running(config, options.config_file, around, std::move(**source), wire, calibrator, keeper ? &*keeper : nullptr)
      .run();
  return 0;
}

}  // namespace stillpoint::app
