/// `stillpoint estimate`: the daemon's stages over recordings, bit-identical from run to run.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <optional>

#include "apps/stillpoint/at_once.h"
#include "apps/stillpoint/attitude_file.h"
#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/estimate_one.h"
#include "apps/stillpoint/estimate_page.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/shard.h"
#include "core/units.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

struct Arguments {
  std::string config, output, state, shard, report;
  std::vector<std::string> recordings;
  bool smooth = false, skip_malformed = false;
  std::size_t jobs = processors();
  JsonOption json;

  [[nodiscard]] EstimateRequest request(const std::string& recording, const std::string& to) const {
    return {recording, to, state, smooth, skip_malformed};
  }
};

Result<void> write_page(const std::string& path, const std::vector<EstimateRequest>& requests,
                        const std::vector<Result<Estimated>>& estimated) {
  return path.empty() ? Result<void>() : io::write_text_file(path, estimates_html(requests, estimated));
}

int one(const Arguments& a, const io::DaemonConfig& config, const std::string& json) {
  const EstimateRequest request = a.request(a.recordings.front(), a.output);
  const auto estimated = estimate_one(request, config);
  if (!estimated) return report(estimated.error());
  if (json != "-") std::fputs(to_text(*estimated, request).c_str(), a.output == "-" ? stderr : stdout);
  if (const auto done = write_page(a.report, {request}, {estimated}); !done) return report(done.error());
  if (json.empty()) return 0;
  const auto written = io::write_text_file(json, json_text(to_json(*estimated)));
  return written ? 0 : report(written.error());
}

/// FOLDER/walk.csv for logs/walk.csv. Two recordings of one name would overwrite each other (64).
Result<std::vector<EstimateRequest>> requests(const Arguments& a) {
  namespace fs = std::filesystem;
  std::error_code failed;
  fs::create_directories(a.output, failed);
  if (failed || !fs::is_directory(a.output))
    return fail(ErrorKind::kCannotCreate,
                a.output + ": no folder and none can be made; several recordings need a folder for --output");
  std::map<std::string, std::string> from;
  std::vector<EstimateRequest> out;
  for (const std::string& recording : a.recordings) {
    const std::string to = (fs::path(a.output) / fs::path(recording).stem()).string() + ".csv";
    const auto [same, fresh] = from.emplace(to, recording);
    if (!fresh)
      return fail(ErrorKind::kUsage,
                  fmt::format("{} and {} would both be written to {}; rename one", same->second, recording, to));
    out.push_back(a.request(recording, to));
  }
  return out;
}

/// Two of one name are refused by every shard, whichever of them holds the second.
Result<std::vector<EstimateRequest>> requests(const Arguments& a, const std::optional<Shard>& shard) {
  auto all = requests(a);
  return all && shard ? part_of(*shard, *all) : all;
}

void print_table(const std::vector<EstimateRequest>& requests, const std::vector<Result<Estimated>>& estimated) {
  std::size_t width = 9;
  for (const EstimateRequest& r : requests) width = std::max(width, r.recording.size());
  fmt::print("{:<{}} {:>8} {:>9} {:>8} {:>5} {:>5} {:>24} {:>14} health\n", "recording", width, "rows", "seconds",
             "degraded", "gaps", "rests", "gyr bias deg/s", "tilt, yaw sd");
  for (std::size_t i = 0; i < requests.size(); ++i) {
    fmt::print("{:<{}} ", requests[i].recording, width);
    if (!estimated[i]) {
      fmt::print("failed: {}\n", estimated[i].error().message);
      continue;
    }
    const Estimated& e = *estimated[i];
    const auto& b = e.calibration.gyr.bias;
    const double tilt_rad = std::max(e.last.sigma_roll_rad, e.last.sigma_pitch_rad);
    fmt::print("{:8} {:9.1f} {:7.1f}% {:5} {:5} {:>24} {:>14} {}\n", e.rows, e.duration_s,
               100.0 * static_cast<double>(e.degraded_rows) / static_cast<double>(std::max<std::size_t>(e.rows, 1)),
               e.guard.gaps, e.rest_windows,
               fmt::format("{:.3f} {:.3f} {:.3f}", b[0] * kDegPerRad, b[1] * kDegPerRad, b[2] * kDegPerRad),
               fmt::format("{:.2f} {:.2f}", tilt_rad * kDegPerRad, e.last.sigma_yaw_rad * kDegPerRad),
               health_of(e.health));
  }
}

/// Each recording by itself: one that fails is said in its line and costs the others nothing. Exit code: of the first
/// that failed.
int many(const Arguments& a, const std::optional<Shard>& shard, const io::DaemonConfig& config,
         const std::string& json) {
  const auto wanted = requests(a, shard);
  if (!wanted) return report(wanted.error());
  std::vector<Result<Estimated>> estimated(wanted->size(), Estimated{});
  std::atomic<std::size_t> done{0};
  at_once(wanted->size(), a.jobs, [&](std::size_t i) {
    estimated[i] = estimate_one((*wanted)[i], config);
    tell(fmt::format("{} of {}: {}", ++done, wanted->size(), (*wanted)[i].recording));
  });
  if (json != "-") print_table(*wanted, estimated);
  if (const auto page = write_page(a.report, *wanted, estimated); !page) return report(page.error());
  const auto failed = std::find_if(estimated.begin(), estimated.end(), [](const auto& e) { return !e; });
  const int code = failed == estimated.end() ? 0 : static_cast<int>(failed->error().kind);
  if (json.empty()) return code;
  nlohmann::json document{{"schema", "stillpoint.estimates/1"}, {"recordings", nlohmann::json::array()}};
  if (shard) document["shard"] = to_json(*shard, a.recordings);
  for (std::size_t i = 0; i < wanted->size(); ++i) {
    nlohmann::json entry =
        estimated[i] ? to_json(*estimated[i]) : nlohmann::json{{"error", estimated[i].error().message}};
    entry["recording"] = (*wanted)[i].recording;
    entry["output"] = (*wanted)[i].output;
    document["recordings"].push_back(std::move(entry));
  }
  const auto written = io::write_text_file(json, json_text(document));
  return written ? code : report(written.error());
}

int run_estimate(Arguments& a) {
  const std::string json = a.json.file();
  std::optional<Shard> shard;
  if (!a.shard.empty()) {
    const auto named = shard_named(a.shard);
    if (!named) return report(named.error());
    if (json.empty())
      return report(
          {ErrorKind::kUsage, "estimate: --shard needs --json FILE, this part's table, for stillpoint merge"});
    shard = *named;
    std::sort(a.recordings.begin(), a.recordings.end());
  }
  if (const auto taken = is_standard_output({json, a.output}); !taken) return report(taken.error());
  const auto config = io::read_config(a.config);
  if (!config) return report(config.error());
  return a.recordings.size() == 1 && !shard ? one(a, *config, json) : many(a, shard, *config, json);
}

}  // namespace

void add_estimate(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("estimate", "The daemon's stages over recordings: attitude at every sample");
  static Arguments a;
  add_file(*command, "--config", a.config, "the daemon's configuration; of its source the mount alone")->required();
  command->add_option("--recording", a.recordings, "recordings (.csv)")->type_name(kFileType)->required();
  add_file(*command, "--output", a.output, "attitude (.csv), - is standard output; for several recordings a folder")
      ->required();
  add_file(*command, "--state", a.state, "what the daemon or calibrate has kept of the sensor; default: nothing known");
  command->add_flag("--smooth", a.smooth,
                    "what came after a sample tells of it as well: the best attitude of a recording");
  command->add_option("--jobs", a.jobs, "recordings at once")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1024}))
      ->capture_default_str();
  command->add_option("--shard", a.shard, "I/N: only the I-th of N parts of the recordings, for array jobs");
  command->add_flag("--skip-malformed", a.skip_malformed, "count malformed rows instead of failing");
  add_file(*command, "--report", a.report,
           "curves of attitude and deviations, beside the reference where there is one, as a page (.html)");
  a.json.add(*command, "write what was found");
  command->callback([&run] { run = [] { return run_estimate(a); }; });
}

}  // namespace stillpoint::app
