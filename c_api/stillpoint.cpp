#include "c_api/stillpoint.h"

#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <numbers>
#include <optional>
#include <span>

#include "c_api/settings.h"
#include "pipeline/calibration_link.h"

using namespace stillpoint;

namespace {

/// One run from one calibration on. Built in place: the link points to the calibrator beside it.
struct Engine {
  Engine(const c_api::Settings& settings, const CalibrationSnapshot& factory)
      : calibrator(settings.calibrator, factory), link(calibrator), stages(settings.stages, factory) {}
  calib::OnlineCalibrator calibrator;
  pipeline::DirectLink link;
  pipeline::Stages stages;
};

bool known_sensor(int sensor) {
  return sensor == STILLPOINT_ACC || sensor == STILLPOINT_GYR || sensor == STILLPOINT_MAG;
}

template <class Snapshot>
auto& triad_of(Snapshot& snapshot, int sensor) {
  return sensor == STILLPOINT_ACC ? snapshot.acc : sensor == STILLPOINT_GYR ? snapshot.gyr : snapshot.mag;
}

template <std::size_t N>
void copy(const std::array<double, N>& from, double (&to)[N]) {
  std::copy(from.begin(), from.end(), to);
}
template <std::size_t N>
std::array<double, N> array_of(const double (&from)[N]) {
  std::array<double, N> to;
  std::copy(from, from + N, to.begin());
  return to;
}

/// As much of `from` as a caller of this size knows of.
template <class T>
int hand_out(const T& from, T* out, std::size_t size) {
  if (out == nullptr || size == 0) return STILLPOINT_BAD_CALL;
  std::memcpy(out, &from, std::min(size, sizeof(T)));
  return STILLPOINT_DONE;
}

std::optional<TriadCalibration> triad_from(const stillpoint_calibration& c) {
  TriadCalibration t;
  t.matrix = array_of(c.matrix);
  t.bias = array_of(c.bias);
  t.bias_per_K = array_of(c.bias_per_K);
  t.bias_per_K2 = array_of(c.bias_per_K2);
  t.temp_ref_degC = c.temp_ref_degC;
  t.temp_min_degC = c.temp_min_degC;
  t.temp_max_degC = c.temp_max_degC;
  t.bias_covariance = array_of(c.bias_covariance);
  t.norm_sd = c.norm_sd;
  bool finite = std::isfinite(t.norm_sd) && t.temp_min_degC <= t.temp_max_degC && std::isfinite(t.temp_ref_degC);
  for (const double x : t.matrix) finite = finite && std::isfinite(x);
  for (const double x : t.bias_covariance) finite = finite && std::isfinite(x);
  for (const Array3* a : {&t.bias, &t.bias_per_K, &t.bias_per_K2})
    for (const double x : *a) finite = finite && std::isfinite(x);
  if (!finite || !(mat(t.matrix).determinant() > 0.0)) return std::nullopt;
  return t;
}

/// Puts a message where the caller wants it, cut to the room there.
void tell(const std::string& message, char* error, std::size_t size) {
  if (error == nullptr || size == 0) return;
  const std::size_t n = std::min(message.size(), size - 1);
  std::memcpy(error, message.data(), n);
  error[n] = '\0';
}

}  // namespace

struct stillpoint_imu {
  explicit stillpoint_imu(const c_api::Settings& with) : settings(with) { restart(); }
  void restart() {
    engine.emplace(settings, factory);
    last = {};
    constexpr double kIgnorance_rad = std::numbers::pi;
    last.orientation_covariance_rad2 = array(Mat3(kIgnorance_rad * kIgnorance_rad * Mat3::Identity()));
    last.sigma_rpy_rad = {kIgnorance_rad, kIgnorance_rad, kIgnorance_rad};
  }

  c_api::Settings settings;
  CalibrationSnapshot factory;
  std::optional<Engine> engine;
  pipeline::Processed processed;
  AttitudeMessage last;
  std::uint64_t readings = 0;
};

extern "C" {

int stillpoint_api_version(void) { return STILLPOINT_API_VERSION; }

stillpoint_imu* stillpoint_create(const stillpoint_setting* settings, size_t count, char* error, size_t error_size) {
  tell("", error, error_size);
  try {
    c_api::Settings chosen;
    for (std::size_t i = 0; settings != nullptr && i < count; ++i) {
      const std::string fault =
          settings[i].name == nullptr ? "a setting without a name" : set(chosen, settings[i].name, settings[i].value);
      if (!fault.empty()) return tell(fault, error, error_size), nullptr;
    }
    if (const std::string fault = check(chosen); !fault.empty()) return tell(fault, error, error_size), nullptr;
    return new stillpoint_imu(chosen);
  } catch (const std::bad_alloc&) {
    return tell("no memory", error, error_size), nullptr;
  }
}

void stillpoint_destroy(stillpoint_imu* s) { delete s; }

int stillpoint_push(stillpoint_imu* s, const stillpoint_reading* reading) {
  if (s == nullptr || reading == nullptr) return STILLPOINT_BAD_CALL;
  RawSample raw;
  raw.t_ns = reading->t_ns;
  raw.sequence = s->readings++;
  raw.acc_mps2 = array_of(reading->acc_mps2);
  raw.gyr_radps = array_of(reading->gyr_radps);
  raw.mag_uT = array_of(reading->mag_uT);
  raw.temp_degC = reading->temp_degC;
  raw.has = static_cast<std::uint8_t>(reading->has & (kAcc | kGyr | kMag | kTemp));
  Engine& engine = *s->engine;
  const auto refused = [&engine] { return engine.stages.guard().counts().unused(); };
  const std::uint64_t before = refused();
  if (engine.stages.process(raw, s->processed, engine.link) == pipeline::StageStatus::kDrop)
    return raw.holds(kGyr) || refused() != before ? STILLPOINT_REFUSED : STILLPOINT_DONE;
  s->last = pipeline::to_message(s->processed);
  return STILLPOINT_DONE;
}

int stillpoint_get_attitude(const stillpoint_imu* s, int64_t now_ns, stillpoint_attitude* out, size_t size) {
  if (s == nullptr) return STILLPOINT_BAD_CALL;
  const AttitudeMessage& m = s->last;
  stillpoint_attitude a{};
  a.t_ns = m.t_ns;
  const auto& q = m.q_world_body_xyzw;
  copy(std::array<double, 4>{q[3], q[0], q[1], q[2]}, a.q_world_body_wxyz);
  copy(m.orientation_covariance_rad2, a.orientation_covariance_rad2);
  copy(m.sigma_rpy_rad, a.sigma_rpy_rad);
  copy(m.rate_radps, a.rate_radps);
  copy(m.gyro_bias_radps, a.gyro_bias_radps);
  a.calibration_version = m.calibration_version;
  a.at_rest = m.at_rest ? 1 : 0;
  a.status = static_cast<std::uint32_t>(m.status);
  a.heading = static_cast<std::uint32_t>(m.heading_reference);
  const double age_s = 1e-9 * (static_cast<double>(now_ns) - static_cast<double>(m.t_ns));
  if (m.status != AttitudeStatus::kInitializing && age_s > s->settings.stale_after_s) a.status = STILLPOINT_STALE;
  return hand_out(a, out, size);
}

int stillpoint_get_calibration(const stillpoint_imu* s, int sensor, stillpoint_calibration* out, size_t size) {
  if (s == nullptr || !known_sensor(sensor)) return STILLPOINT_BAD_CALL;
  const TriadCalibration& t = triad_of(s->engine->stages.live(), sensor);
  stillpoint_calibration c{};
  copy(t.matrix, c.matrix);
  copy(t.bias, c.bias);
  copy(t.bias_per_K, c.bias_per_K);
  copy(t.bias_per_K2, c.bias_per_K2);
  c.temp_ref_degC = t.temp_ref_degC;
  c.temp_min_degC = t.temp_min_degC;
  c.temp_max_degC = t.temp_max_degC;
  copy(t.bias_covariance, c.bias_covariance);
  c.norm_sd = t.norm_sd;
  c.windows = t.windows;
  c.status = static_cast<std::uint32_t>(t.status);
  return hand_out(c, out, size);
}

int stillpoint_set_calibration(stillpoint_imu* s, int sensor, const stillpoint_calibration* calibration, size_t size) {
  if (s == nullptr || !known_sensor(sensor) || calibration == nullptr || size < sizeof *calibration)
    return STILLPOINT_BAD_CALL;
  const auto triad = triad_from(*calibration);
  if (!triad) return STILLPOINT_BAD_CALL;
  triad_of(s->factory, sensor) = *triad;
  s->restart();
  return STILLPOINT_DONE;
}

size_t stillpoint_state_size(void) { return sizeof(calib::OnlineCalibrator::State); }

int stillpoint_save_state(const stillpoint_imu* s, void* out, size_t size) {
  if (s == nullptr || out == nullptr || size != stillpoint_state_size()) return STILLPOINT_BAD_CALL;
  const auto state = s->engine->calibrator.state();
  std::memcpy(out, &state, sizeof state);
  return STILLPOINT_DONE;
}

int stillpoint_restore_state(stillpoint_imu* s, const void* state, size_t size) {
  if (s == nullptr || state == nullptr || size != stillpoint_state_size()) return STILLPOINT_BAD_CALL;
  calib::OnlineCalibrator calibrator(s->settings.calibrator, s->factory);
  if (!calibrator.restore(std::span(static_cast<const std::byte*>(state), size))) return STILLPOINT_BAD_CALL;
  s->restart();
  s->engine->calibrator = calibrator;
  s->engine->stages = pipeline::Stages(s->settings.stages, calibrator.snapshot());
  return STILLPOINT_DONE;
}

}  // extern "C"
