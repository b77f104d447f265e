/// `stillpoint estimate`: the daemon's stages over a recording, on one thread, bit-identical from run to run.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/json_text.h"
#include "core/units.h"
#include "io/config.h"
#include "io/recording.h"
#include "io/text_file.h"
#include "pipeline/stages.h"

namespace stillpoint::app {
namespace {

struct Arguments {
  std::string config, recording, output;
  bool skip_malformed = false;
  JsonOption json;
};

std::string_view word(fusion::AttitudeStatus status) {
  switch (status) {
    case fusion::AttitudeStatus::kWaiting:
      return "initializing";
    case fusion::AttitudeStatus::kOk:
      return "ok";
    case fusion::AttitudeStatus::kDegraded:
      return "degraded";
    case fusion::AttitudeStatus::kRefused:
      break;
  }
  return "refused";
}

/// Shortest text that reads back to the same bits. By hand, because formatting is a third of the time of an estimate.
void append_row(fmt::memory_buffer& out, const fusion::AttitudeEstimate& e) {
  std::array<char, 512> line;  // 13 fields of at most 25 characters
  char* at = line.data();
  char* const end = at + line.size();
  if (e.t_ns < 0) *at++ = '-';
  const std::int64_t t_ns = std::abs(e.t_ns);
  at = std::to_chars(at, end, t_ns / 1'000'000'000).ptr;
  // Nine digits with leading zeros: those of 10^9 + x without the leading one.
  char* const point = at;
  at = std::to_chars(at, end, 1'000'000'000 + t_ns % 1'000'000'000).ptr;
  *point = '.';
  const auto add = [&](double x) {
    *at++ = ',';
    at = std::to_chars(at, end, x).ptr;
  };
  for (const double x : e.q_world_body) add(x);
  for (const double x : {e.sigma_roll_rad, e.sigma_pitch_rad, e.sigma_yaw_rad}) add(x);
  for (const double x : e.gyro_bias_radps) add(x);
  const std::string_view status = word(e.status);
  *at++ = ',';
  *at++ = e.at_rest ? '1' : '0';
  *at++ = ',';
  at = std::copy(status.begin(), status.end(), at);
  *at++ = '\n';
  out.append(line.data(), at);
}

struct Summary {
  std::size_t rows = 0;
  fusion::AttitudeEstimate last;
};

Result<Summary> estimate(const io::Recording& recording, pipeline::Stages& stages, pipeline::DirectLink& link,
                         const std::string& path) {
  auto file = io::OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  constexpr std::size_t kChunk_bytes = 1 << 16;
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text),
                 "time_s,qw,qx,qy,qz,sigma_roll_rad,sigma_pitch_rad,sigma_yaw_rad,bias_x_radps,bias_y_radps,"
                 "bias_z_radps,at_rest,status\n");
  const auto write = [&] {
    auto written = file->write({text.data(), text.size()});
    text.clear();
    return written;
  };
  Summary summary;
  pipeline::Processed out;
  for (std::size_t row = 0; row < recording.size(); ++row) {
    if (stages.process(recording.sample(row), out, link) == pipeline::StageStatus::kDrop) continue;
    append_row(text, out.attitude);
    ++summary.rows;
    if (text.size() > kChunk_bytes)
      if (auto written = write(); !written) return tl::unexpected(written.error());
  }
  if (auto written = write(); !written) return tl::unexpected(written.error());
  if (auto written = file->flush(); !written) return tl::unexpected(written.error());
  summary.last = out.attitude;
  return summary;
}

nlohmann::json triad_json(const TriadCalibration& c) {
  return {{"bias", c.bias},          {"bias_per_K", c.bias_per_K}, {"temp_ref_degC", c.temp_ref_degC},
          {"matrix", c.matrix},      {"windows", c.windows},       {"norm_sd", c.norm_sd},
          {"status", name(c.status)}};
}

nlohmann::json to_json(const Summary& summary, const pipeline::Stages& stages, const io::Recording& recording) {
  const auto& guard = stages.guard().counts();
  const auto& live = stages.live();
  return {{"schema", "stillpoint.estimate/1"},
          {"rows", summary.rows},
          {"samples", recording.size()},
          {"dropped_rows", recording.issues.dropped_rows()},
          {"refused", guard.refused},
          {"gaps", guard.gaps},
          {"clipped", guard.clipped},
          {"not_finite", guard.not_finite + recording.issues.not_finite.count},
          {"rest_windows", stages.counts().windows},
          {"calibration",
           {{"version", live.version},
            {"acc", triad_json(live.acc)},
            {"gyr", triad_json(live.gyr)},
            {"mag", triad_json(live.mag)}}}};
}

void print_text(const Summary& summary, const pipeline::Stages& stages, const io::Recording& recording,
                const Arguments& a) {
  std::string text;
  const auto to = std::back_inserter(text);
  for (const auto& line : io::describe(recording.issues)) fmt::format_to(to, "{}: {}\n", a.recording, line);
  const auto& live = stages.live();
  fmt::format_to(to, "{}: {} rows\n", a.output, summary.rows);
  fmt::format_to(to, "rest windows {}, calibration version {}; gaps {}, refused {}\n", stages.counts().windows,
                 live.version, stages.guard().counts().gaps, stages.guard().counts().refused);
  const auto& b = live.gyr.bias;
  fmt::format_to(to, "gyroscope bias {:.4f} {:.4f} {:.4f} deg/s, {}\n", b[0] * kDegPerRad, b[1] * kDegPerRad,
                 b[2] * kDegPerRad, name(live.gyr.status));
  fmt::format_to(to, "accelerometer bias {:.4f} {:.4f} {:.4f} m/s^2, {}\n", live.acc.bias[0], live.acc.bias[1],
                 live.acc.bias[2], name(live.acc.status));
  const auto& e = summary.last;
  fmt::format_to(to, "standard deviation at the end: roll {:.3f}, pitch {:.3f}, yaw {:.3f} deg\n",
                 e.sigma_roll_rad * kDegPerRad, e.sigma_pitch_rad * kDegPerRad, e.sigma_yaw_rad * kDegPerRad);
  std::fputs(text.c_str(), a.output == "-" ? stderr : stdout);
}

int run_estimate(const Arguments& a) {
  const std::string json = a.json.file();
  if (const auto taken = is_standard_output({json, a.output}); !taken) return report(taken.error());
  const auto config = io::read_config(a.config);
  if (!config) return report(config.error());
  const auto recording =
      io::read_recording(a.recording, a.skip_malformed ? io::OnMalformedRow::kCount : io::OnMalformedRow::kFail);
  if (!recording) return report(recording.error());
  const CalibrationSnapshot factory = io::factory_calibration(config->sensor);
  calib::OnlineCalibrator calibrator(config->calibration.online, factory);
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages(io::stages_params(*config), calibrator.snapshot());
  const auto summary = estimate(*recording, stages, link, a.output);
  if (!summary) return report(summary.error());
  if (json != "-") print_text(*summary, stages, *recording, a);
  if (json.empty()) return 0;
  const auto written = io::write_text_file(json, json_text(to_json(*summary, stages, *recording)));
  return written ? 0 : report(written.error());
}

}  // namespace

void add_estimate(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("estimate", "The daemon's stages over a recording: attitude at every sample");
  static Arguments a;
  add_file(*command, "--config", a.config, "the daemon's configuration; its source is not used")->required();
  add_file(*command, "--recording", a.recording, "recording (.csv)")->required();
  add_file(*command, "--output", a.output, "attitude (.csv); - is standard output")->required();
  command->add_flag("--skip-malformed", a.skip_malformed, "count malformed rows instead of failing");
  a.json.add(*command, "write what was found");
  command->callback([&run] { run = [] { return run_estimate(a); }; });
}

}  // namespace stillpoint::app
