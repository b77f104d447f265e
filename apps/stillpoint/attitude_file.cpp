#include "apps/stillpoint/attitude_file.h"

#include <array>
#include <charconv>

namespace stillpoint::app {
namespace {

constexpr std::size_t kChunk_bytes = 1 << 16;

/// Shortest text that reads back to the same bits. By hand, because formatting is a third of the time of an estimate.
void append_row(fmt::memory_buffer& out, const pipeline::Processed& processed) {
  const fusion::AttitudeEstimate& e = processed.attitude;
  std::array<char, 512> line;  // 15 fields of at most 25 characters
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
  *at++ = ',';
  *at++ = e.at_rest ? '1' : '0';
  for (const std::string_view word :
       {name(pipeline::to_message(processed).status), name(e.heading), health_of(processed.health)}) {
    *at++ = ',';
    at = std::copy(word.begin(), word.end(), at);
  }
  *at++ = '\n';
  out.append(line.data(), at);
}

}  // namespace

/// "ok", or the fault of the gravest state among the sensors that were not simply never there.
std::string_view health_of(const SensorsHealth& health) {
  const SensorHealth* gravest = &health.acc;
  for (const SensorHealth* sensor : {&health.gyr, &health.mag})
    if (sensor->state > gravest->state && !(sensor == &health.mag && sensor->state == Health::kAbsent))
      gravest = sensor;
  return gravest->state == Health::kOk ? name(Health::kOk) : name(gravest->fault);
}

Result<AttitudeFile> AttitudeFile::create(const std::string& path) {
  auto file = io::OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  AttitudeFile out(std::move(*file));
  fmt::format_to(std::back_inserter(out.text_),
                 "time_s,qw,qx,qy,qz,sigma_roll_rad,sigma_pitch_rad,sigma_yaw_rad,bias_x_radps,bias_y_radps,"
                 "bias_z_radps,at_rest,status,heading,health\n");
  return out;
}

Result<void> AttitudeFile::add(const pipeline::Processed& processed) {
  append_row(text_, processed);
  return text_.size() > kChunk_bytes ? write() : Result<void>{};
}

Result<void> AttitudeFile::write() {
  auto written = file_.write({text_.data(), text_.size()});
  text_.clear();
  return written;
}

Result<void> AttitudeFile::finish() {
  if (auto written = write(); !written) return written;
  return file_.flush();
}

}  // namespace stillpoint::app
