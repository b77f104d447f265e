#include "apps/stillpointd/daemon.h"

#include <fmt/format.h>
#include <signal.h>

#include <cstdlib>
#include <cstring>
#include <thread>

#include "apps/stillpointd/log.h"
#include "apps/stillpointd/slow_work.h"
#include "apps/stillpointd/source.h"

namespace stillpoint::app {
namespace {

int report(const Error& error) {
  log(error.message);
  return static_cast<int>(error.kind);
}

/// SIGTERM, SIGINT and SIGHUP are taken here, by the main thread; every thread made later inherits that they are
/// blocked.
class Signals {
 public:
  Signals() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGTERM);
    sigaddset(&set_, SIGINT);
    sigaddset(&set_, SIGHUP);  // its terminal is gone
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of its write, not the end
  }
  /// Name of a signal that came within 50 ms.
  [[nodiscard]] const char* poll() const {
    const timespec wait{0, 50'000'000};
    const int number = sigtimedwait(&set_, nullptr, &wait);
    return number > 0 ? strsignal(number) : nullptr;
  }

 private:
  sigset_t set_{};
};

/// The configured source, waited for if the configuration says so. None: a signal came first.
Result<std::optional<DaemonSource>> wait_for_source(const io::SourceConfig& config, const Signals& signals) {
  bool told = false;
  while (true) {
    auto source = open_source(config);
    if (source) return std::optional<DaemonSource>(std::move(*source));
    if (source.error().kind != ErrorKind::kNoInput || !config.wait_for_file) return tl::unexpected(source.error());
    if (!told) log(fmt::format("waiting for {} (source.wait_for_file)", config.file));
    told = true;
    if (signals.poll() != nullptr) return std::optional<DaemonSource>();
  }
}

std::string state_directory(const io::StateConfig& config) {
  if (!config.directory.empty()) return config.directory;
  const char* given = std::getenv("STATE_DIRECTORY");  // systemd sets it for StateDirectory=
  return given != nullptr ? given : "";
}

void restore(calib::OnlineCalibrator& calibrator, const io::StateStore& store) {
  const auto loaded = store.load([&](std::span<const std::byte> bytes) { return calibrator.restore(bytes); });
  for (const auto& message : loaded.set_aside) log(message);
  log(loaded.payload.empty()
          ? "no kept calibration: the factory values serve"
          : fmt::format("calibration version {} from {}", calibrator.snapshot().version, loaded.file));
}

void prepare(const char* name, int core, int priority) {
  for (const auto& refused : pipeline::prepare_thread(name, core, priority)) log(refused);
}

/// Everything that lives as long as the two threads.
class Running {
 public:
  Running(const io::DaemonConfig& config, DaemonSource source, io::DdsPublisher& publisher,
          calib::OnlineCalibrator& calibrator, const io::StateStore* store)
      : config_(config),
        source_(std::move(source)),
        publisher_(publisher),
        shared_(std::make_unique<pipeline::Shared>()),
        stages_(io::stages_params(config), calibrator.snapshot()),
        work_(config, publisher, calibrator, store, *shared_),
        sensor_(source_, stages_, publisher_, *shared_, pipeline::OnLateAnswer::kWait, config.threads.rehearse_ahead_s),
        calibration_(calibrator, *shared_, work_, config.threads.calibration_poll_s) {}

  /// Returns when both threads have ended.
  void run(const Signals& signals) {
    const auto& threads = config_.threads;
    std::thread slow([&] {
      prepare("calibration", threads.calibration_core, 0);
      calibration_.run();
    });
    std::thread fast([&] {
      prepare("sensor", threads.sensor_core, threads.fifo_priority);
      sensor_.run(config_.source.at_end == io::SourceEnd::kStop ? pipeline::AtEnd::kStop : pipeline::AtEnd::kWait);
    });
    while (!shared_->sensor_done.load(std::memory_order_acquire)) {
      const char* name = signals.poll();
      if (name == nullptr || shared_->stop.exchange(true)) continue;
      log(fmt::format("{}: ending", name));
    }
    fast.join();
    slow.join();
    work_.save();
    publisher_.wait_for_acknowledgements(1.0);
    summary();
  }

 private:
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
        report->guard.samples, report->published, report->guard.refused, report->guard.gaps, report->stages.windows,
        stages_.live().version, report->ring_dropped, us(latency, 0.5), us(latency, 0.99),
        1e-3 * static_cast<double>(shared_->latency.max_ns()), us(processing, 0.5), us(processing, 0.99)));
  }

  const io::DaemonConfig& config_;
  DaemonSource source_;
  io::DdsPublisher& publisher_;
  std::unique_ptr<pipeline::Shared> shared_;
  pipeline::Stages stages_;
  SlowWork work_;
  pipeline::SensorLoop<DaemonSource, io::DdsPublisher> sensor_;
  pipeline::CalibrationLoop<SlowWork> calibration_;
};

}  // namespace

int run_daemon(const io::DaemonConfig& config, const DaemonOptions& options) {
  const Signals signals;
  auto source = wait_for_source(config.source, signals);
  if (!source) return report(source.error());
  if (!*source) return 0;

  calib::OnlineCalibrator calibrator(config.calibration.online, io::factory_calibration(config.sensor));
  std::optional<io::StateStore> store;
  if (const std::string directory = state_directory(config.state); !directory.empty()) {
    store.emplace(directory, config.sensor.id, config.state.keep);
    if (const auto claimed = store->claim(); !claimed) return report(claimed.error());
    restore(calibrator, *store);
  }
  const auto publisher = io::DdsPublisher::create(config.dds);
  if (!publisher) return report(publisher.error());
  if (config.threads.lock_memory)
    if (const auto refused = pipeline::lock_memory()) log(*refused);
  if (config.threads.cpu_latency_us >= 0)
    if (const auto refused = pipeline::limit_cpu_latency(config.threads.cpu_latency_us)) log(*refused);
  log(fmt::format("sensor {}, source {} at {}, world {}, domain {}, transport {}", config.sensor.id, config.source.file,
                  config.source.speed > 0 ? fmt::format("{}x", config.source.speed) : "full speed",
                  config.output.world_frame == pipeline::WorldFrame::kEnu ? "ENU" : "NED", config.dds.domain,
                  config.dds.transport));
  while ((*publisher)->attitude_subscribers() < options.wait_for_subscribers)
    if (signals.poll() != nullptr) return 0;
  Running(config, std::move(**source), **publisher, calibrator, store ? &*store : nullptr).run(signals);
  return 0;
}

}  // namespace stillpoint::app
