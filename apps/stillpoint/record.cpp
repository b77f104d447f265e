/// `stillpoint record`: writes what the sensor of a running daemon gives into a recording.
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/daemon_session.h"
#include "apps/stillpoint/dds_options.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "core/units.h"
#include "exchange/mcap_writer.h"
#include "io/dds_subscriber.h"
#include "io/recording_stream.h"

namespace stillpoint::app {
namespace {

struct RecordOptions {
  io::DdsParams dds;
  std::string output;
  double seconds = 0.0;  ///< 0: until interrupted
  double timeout_s = 10.0;
};

/// Readings on their way from the DDS thread to the file.
class Inbox {
 public:
  void put(const RawSample& sample) {
    const std::lock_guard lock(mutex_);
    samples_.push_back(sample);
  }
  void take_all(std::vector<RawSample>& out) {
    out.clear();
    const std::lock_guard lock(mutex_);
    std::swap(out, samples_);
  }

 private:
  std::mutex mutex_;
  std::vector<RawSample> samples_;
};

/// The recording in the form that its name asks for: .mcap, else CSV.
class Target {
 public:
  static Result<Target> create(const std::string& path, const std::map<std::string, std::string>& header) {
    Target target;
    if (path.ends_with(".mcap")) {
      auto made = exchange::McapWriter::create(path);
      if (!made) return tl::unexpected(made.error());
      target.mcap_.emplace(std::move(*made));
    } else {
      auto made = io::RecordingStream::create(path, header);
      if (!made) return tl::unexpected(made.error());
      target.csv_.emplace(std::move(*made));
    }
    return target;
  }
  Result<void> append(const RawSample& sample) { return mcap_ ? mcap_->append(sample) : csv_->append(sample); }
  /// An MCAP file is on its way to disk by chunks; a CSV row by row.
  Result<void> flush() { return mcap_ ? Result<void>{} : csv_->flush(); }
  Result<void> finish() { return mcap_ ? mcap_->finish() : csv_->flush(); }
  [[nodiscard]] std::uint64_t rows() const { return mcap_ ? mcap_->rows() : csv_->rows(); }

 private:
  std::optional<io::RecordingStream> csv_;
  std::optional<exchange::McapWriter> mcap_;
};

struct Written {
  std::uint64_t lost = 0;
  std::int64_t first_ns = 0;
  RawSample last;
};

Result<void> append_all(const std::vector<RawSample>& batch, Target& stream, Written& written) {
  for (const RawSample& sample : batch) {
    if (stream.rows() == 0)
      written.first_ns = sample.t_ns;
    else if (sample.sequence > written.last.sequence + 1)
      written.lost += sample.sequence - written.last.sequence - 1;
    if (auto done = stream.append(sample); !done) return done;
    written.last = sample;
  }
  return stream.flush();
}

void say_what_was_written(const RecordOptions& options, const Target& stream, const Written& written) {
  tell(fmt::format("{}: {} rows, {:.1f} s, {} lost on the way", options.output, stream.rows(),
                   in_seconds(written.last.t_ns - written.first_ns), written.lost));
}

int record(const RecordOptions& options) {
  if (const auto writable = io::expect_writable(options.output); !writable) return report(writable.error());
  Inbox inbox;
  const auto subscriber = io::DdsSubscriber::create(
      options.dds, {.raw = [&inbox](const RawSample& sample, std::int64_t) { inbox.put(sample); }});
  if (!subscriber) return report(subscriber.error());
  stop_on_signals();
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point t) {
    return std::chrono::duration<double>(Clock::now() - t).count();
  };
  const auto start = Clock::now();
  auto first_row = start;
  std::optional<Target> stream;  // made with the first reading: until then what lies there stays
  Written written;
  std::vector<RawSample> batch;
  bool more = true;
  while (more) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    more = !stop_asked() && (!stream ? seconds_since(start) < options.timeout_s
                                     : options.seconds <= 0 || seconds_since(first_row) < options.seconds);
    inbox.take_all(batch);
    if (batch.empty()) continue;
    if (!stream) {
      auto made = Target::create(options.output,
                                 {{"source", "stillpointd, topic " + options.dds.raw_topic}, {"world_frame", "ENU"}});
      if (!made) return report(made.error());
      stream.emplace(std::move(*made));
      first_row = Clock::now();
      more = !stop_asked();
    }
    if (auto done = append_all(batch, *stream, written); !done) return report(done.error());
  }
  if (!stream)
    return report({ErrorKind::kUnavailable,
                   nothing_arrives(options.dds, options.dds.raw_topic, (*subscriber)->publishers() > 0)});
  if (auto done = stream->finish(); !done) return report(done.error());
  say_what_was_written(options, *stream, written);
  return 0;
}

}  // namespace

void add_record(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("record", "Write what a running daemon's sensor gives into a recording");
  static RecordOptions options;
  add_dds_options(*command, options.dds);
  add_file(*command, "--output", options.output,
           "recording to write (.csv, or .mcap for ROS 2 tools); - is standard output")
      ->required();
  command->add_option("--seconds", options.seconds, "end after this time; otherwise on Ctrl-C")
      ->check(between(0.01, 1e9));
  command->add_option("--timeout", options.timeout_s, "how long to wait for the first reading, s")
      ->check(between(0.0, 1e9))
      ->capture_default_str();
  command->callback([&run] { run = [] { return record(options); }; });
}

}  // namespace stillpoint::app
