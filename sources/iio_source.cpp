#include "sources/iio_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <list>
#include <mutex>
#include <optional>
#include <thread>

#include "pipeline/clock.h"
#include "sources/iio_device.h"
#include "sources/inbox.h"
#include "sources/reopening.h"
#include "sources/stamps.h"

namespace stillpoint::sources {
namespace {

constexpr std::int64_t kPause_ns = 20'000'000;
constexpr std::int64_t kSameClock_ns = 2'000'000'000;
constexpr double kStalePeriods = 3.0;
constexpr std::int64_t kFirstLook_ns = 250'000'000, kLooks_ns = 5'000'000'000;  ///< for devices that come later

/// The devices' clock on ours. All devices of a context share one clock.
class ClockBridge {
 public:
  /// `t_ns` is the time of the newest reading when it arrived.
  void learn(std::int64_t t_ns, std::int64_t arrival_ns) {
    const std::lock_guard lock(mutex_);
    if (offset_ns_) return;
    const double apart_ns = static_cast<double>(arrival_ns) - static_cast<double>(t_ns);
    offset_ns_ = std::abs(apart_ns) < kSameClock_ns ? 0 : arrival_ns - t_ns;
  }
  [[nodiscard]] std::int64_t ours(std::int64_t t_ns) {
    const std::lock_guard lock(mutex_);
    return t_ns + offset_ns_.value_or(0);
  }

 private:
  std::mutex mutex_;
  std::optional<std::int64_t> offset_ns_;
};

/// One device and its thread. `start_ns`: when it was asked to begin.
class Worker {
 public:
  Worker(IioDevice device, std::int64_t start_ns, const io::IioParams& params, ClockBridge& clock, Inbox& inbox)
      : device_(std::move(device)),
        clock_(clock),
        inbox_(inbox),
        period_ns_(1e9 / (device_.streams() ? std::max(1.0, device_.rate_hz()) : params.poll_hz)),
        stamps_(1e9 / period_ns_),
        start_ns_(start_ns),
        thread_([this] { run(); }) {}
  ~Worker() {
    stop_ = true;
    device_.cancel();
    thread_.join();
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  /// Why it ended; 0 while it runs.
  [[nodiscard]] int ended() const noexcept { return ended_.load(); }
  [[nodiscard]] bool has_given() const noexcept { return given_.load(); }
  [[nodiscard]] std::string id() const { return device_.id(); }

 private:
  void run() {
    std::vector<Reading> block;
    block.reserve(1024);
    std::int64_t due_ns = monotonic_ns();
    int code = 0;
    while (code >= 0 && !stop_) {
      if (!device_.streams()) pipeline::sleep_until_ns(due_ns += static_cast<std::int64_t>(period_ns_));
      const std::int64_t asked_ns = monotonic_ns();
      block.clear();
      code = device_.read([&block](const Reading& reading) { block.push_back(reading); });
      if (code >= 0 && !block.empty()) hand_on(block, asked_ns, monotonic_ns());
    }
    ended_ = code < 0 ? code : -ECANCELED;
  }

  void hand_on(std::vector<Reading>& block, std::int64_t asked_ns, std::int64_t arrival_ns) {
    if (block.back().has_time) clock_.learn(block.back().sample.t_ns, arrival_ns);
    for (Reading& reading : block) {
      std::int64_t& t_ns = reading.sample.t_ns;
      if (reading.has_time)
        t_ns = clock_.ours(t_ns);
      else if (!device_.streams())
        t_ns = asked_ns + (arrival_ns - asked_ns) / 2;
      else if (!stamps_.stamp(reading, arrival_ns, 1))
        continue;
      // What lay in the kernel's buffer from an earlier run is no reading of this one.
      if (static_cast<double>(t_ns - start_ns_) < -kStalePeriods * period_ns_) continue;
      inbox_.put(reading, arrival_ns);
      given_ = true;
    }
  }

  IioDevice device_;
  ClockBridge& clock_;
  Inbox& inbox_;
  double period_ns_;
  Stamps stamps_;
  std::int64_t start_ns_;
  std::atomic<bool> stop_{false};
  std::atomic<int> ended_{0};
  std::atomic<bool> given_{false};
  std::thread thread_;
};

bool is_wanted(const IioDevice& device, const std::vector<std::string>& names) {
  return names.empty() || std::find(names.begin(), names.end(), device.name()) != names.end();
}

/// The devices that are read. A driver makes one after the other: who looks once sees some of them.
class Served {
 public:
  Served(const io::IioParams& params, Inbox& inbox) : params_(params), inbox_(inbox) {}

  /// Begins to read what is wanted and was not there before. In words what stands in the way; empty: nothing.
  std::string look() {
    auto context = open_iio(params_.uri);
    if (!context) return context.error().message;
    std::string polled, unread;
    std::vector<std::string> others;
    bool any = false;
    for (IioDevice& device : IioDevice::all(**context)) {
      if (!is_wanted(device, params_.devices)) others.push_back(device.name());
      if (!is_wanted(device, params_.devices) || is_served(device)) continue;
      if (!device.unscaled().empty()) {
        unread = fmt::format("IIO {}: {} does not tell the scale and offset of {}, and no reading has a unit without",
                             params_.uri, device.name(), device.unscaled());
        continue;
      }
      const std::int64_t start_ns = monotonic_ns();
      if (const std::string why = device.start(params_); !why.empty()) polled = why + "; polled";
      workers_.emplace_back(std::move(device), start_ns, params_, clock_, inbox_);
      any = true;
    }
    if (any) contexts_.push_back(std::move(*context));
    if (!unread.empty()) return unread;
    if (!workers_.empty()) return polled;
    return fmt::format("IIO {}: no motion sensor{}; `stillpoint devices` lists what is there", params_.uri,
                       others.empty() ? "" : fmt::format(" of that name, but {}", fmt::join(others, ", ")));
  }
  [[nodiscard]] bool none() const noexcept { return workers_.empty(); }
  /// Whether nothing more can come: every name has its device.
  [[nodiscard]] bool complete() const noexcept {
    return !params_.devices.empty() && workers_.size() >= params_.devices.size();
  }
  [[nodiscard]] bool has_given() const noexcept {
    return std::any_of(workers_.begin(), workers_.end(), [](const Worker& w) { return w.has_given(); });
  }
  /// Why a device is read no more; 0: all are.
  [[nodiscard]] int ended() const noexcept {
    for (const Worker& worker : workers_)
      if (const int code = worker.ended(); code != 0) return code;
    return 0;
  }

 private:
  [[nodiscard]] bool is_served(const IioDevice& device) const {
    return std::any_of(workers_.begin(), workers_.end(), [&](const Worker& w) { return w.id() == device.id(); });
  }

  const io::IioParams& params_;
  Inbox& inbox_;
  ClockBridge clock_;
  std::vector<IioContext> contexts_;
  std::list<Worker> workers_;  // end before their contexts do
};

}  // namespace

struct IioSource::Impl {
  io::IioParams params;
  Reopening reopening;
  Inbox inbox;
  ReportCell report = std::make_shared<SnapshotCell<SourceReport>>();
  SourceReport counts;  // of the sensor thread
  std::int64_t told_ns = 0;
  bool was_there = false;
  SnapshotCell<ShortText> error;
  std::atomic<std::uint64_t> opened{0}, failures{0};
  std::atomic<bool> running{false}, stop{false};
  std::thread supervisor;

  Impl(const io::IioParams& p, double at_most_s) : params(p), reopening(at_most_s) {
    supervisor = std::thread([this] { supervise(); });
  }
  ~Impl() {
    stop = true;
    supervisor.join();
  }

  void supervise() {
    while (!stop) {
      const std::string why = run_until_lost();
      error.store(ShortText(why));
      running = false;
      ++failures;
      reopening.failed(monotonic_ns());
      while (!stop && !reopening.due(monotonic_ns())) pipeline::sleep_until_ns(monotonic_ns() + kPause_ns);
    }
  }

  /// In words why it ended.
  std::string run_until_lost() {
    Served served(params, inbox);
    std::string why = served.look();
    if (served.none()) return why;
    if (!why.empty()) error.store(ShortText(why));
    ++opened;
    running = true;
    std::int64_t next_look_ns = monotonic_ns() + kFirstLook_ns, look_after_ns = kFirstLook_ns;
    while (!stop) {
      if (const int code = served.ended(); code != 0) {
        if (served.has_given()) reopening.works();
        return fmt::format("IIO {}: {}", params.uri, std::strerror(-code));
      }
      if (!served.complete() && monotonic_ns() >= next_look_ns) {
        if (const std::string more = served.look(); !more.empty()) error.store(ShortText(more));
        look_after_ns = std::min(2 * look_after_ns, kLooks_ns);
        next_look_ns = monotonic_ns() + look_after_ns;
      }
      pipeline::sleep_until_ns(monotonic_ns() + kPause_ns);
    }
    return "ended";
  }

  void tell(LinkState link) noexcept {
    counts.link = link;
    counts.opened = opened;
    counts.failures = failures;
    counts.lost = inbox.lost;
    if (const auto text = error.try_load()) counts.error = *text;
    report->store(counts);
    told_ns = monotonic_ns();
  }

  bool take(pipeline::Arrival& out) noexcept {
    Inbox::Item item;
    if (!inbox.take(item)) return false;
    out.sample = item.reading.sample;
    out.arrival_ns = item.arrival_ns;
    ++counts.readings;
    was_there = true;
    if (item.arrival_ns - told_ns > kPause_ns || counts.link != LinkState::kThere) tell(LinkState::kThere);
    return true;
  }
};

IioSource::IioSource(const io::IioParams& params, double reopen_at_most_s)
    : impl_(std::make_unique<Impl>(params, reopen_at_most_s)) {}
IioSource::~IioSource() = default;
IioSource::IioSource(IioSource&&) noexcept = default;
IioSource& IioSource::operator=(IioSource&&) noexcept = default;

ReportCell IioSource::report() const noexcept { return impl_->report; }

pipeline::SourceState IioSource::next(pipeline::Arrival& out) noexcept {
  using pipeline::SourceState;
  if (impl_->take(out)) return SourceState::kSample;
  impl_->inbox.wait();
  if (impl_->take(out)) return SourceState::kSample;
  const bool gone = impl_->was_there && !impl_->running;
  impl_->tell(impl_->running ? impl_->counts.link : impl_->was_there ? LinkState::kGone : LinkState::kNeverThere);
  return gone ? SourceState::kGone : SourceState::kNothing;
}

}  // namespace stillpoint::sources
