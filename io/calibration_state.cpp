#include "io/calibration_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

#include "calib_online/state_fields.h"
#include "core/fnv1a.h"

namespace stillpoint::io {
namespace {

using calib::FieldOfState;
using calib::StatePart;
using State = calib::OnlineCalibrator::State;
constexpr std::string_view kTitle = "stillpoint-calibration 5";

template <class T>
constexpr bool kIsNumber = std::is_arithmetic_v<std::decay_t<T>>;

/// A factory calibration's numbers by name.
using Values = std::vector<std::pair<std::string, std::vector<double>>>;
Values factory_values(const CalibrationSnapshot& factory) {
  Values out;
  const std::pair<const char*, const TriadCalibration*> triads[] = {
      {"acc", &factory.acc}, {"gyr", &factory.gyr}, {"mag", &factory.mag}};
  for (const auto& [sensor, t] : triads) {
    const auto add = [&out, sensor = sensor](const char* what, auto first, auto last) {
      out.emplace_back(fmt::format("factory.{}.{}", sensor, what), std::vector<double>(first, last));
    };
    add("matrix", t->matrix.begin(), t->matrix.end());
    add("bias", t->bias.begin(), t->bias.end());
    add("bias_per_K", t->bias_per_K.begin(), t->bias_per_K.end());
    add("bias_per_K2", t->bias_per_K2.begin(), t->bias_per_K2.end());
    add("temp_ref_degC", &t->temp_ref_degC, &t->temp_ref_degC + 1);
  }
  return out;
}

std::string header_text(const calib::OnlineCalibrator& c) {
  std::string text = fmt::format("temperature_model {}\n", c.params().temperature_model);
  for (const auto& [name, values] : factory_values(c.factory()))
    text += fmt::format("{} - {}\n", name, fmt::join(values, " "));
  return text;
}

/// The lines of a text by name; of one name as they come.
class Lines {
 public:
  explicit Lines(std::string_view text) {
    while (!text.empty()) {
      const std::string_view line = text.substr(0, text.find('\n'));
      text.remove_prefix(std::min(text.size(), line.size() + 1));
      const auto name_end = line.find(' ');
      if (name_end == std::string_view::npos) continue;
      lines_[std::string(line.substr(0, name_end))].push_back(line.substr(name_end + 1));
    }
  }
  /// The next line of this name, without it.
  std::string_view next(const std::string& name) {
    const auto found = lines_.find(name);
    std::size_t& taken = taken_[name];
    return found == lines_.end() || taken >= found->second.size() ? std::string_view() : found->second[taken++];
  }
  /// Its numbers, after the unit. Empty where one of them is none.
  std::vector<double> numbers(const std::string& name) {
    std::string_view line = next(name);
    line.remove_prefix(std::min(line.size(), line.find(' ')));
    std::vector<double> out;
    while (!line.empty()) {
      line.remove_prefix(1);
      double value = 0.0;
      const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
      if (error != std::errc()) return {};
      out.push_back(value);
      line.remove_prefix(static_cast<std::size_t>(end - line.data()));
      if (!line.empty() && line.front() != ' ') return {};
    }
    return out;
  }

 private:
  std::map<std::string, std::vector<std::string_view>> lines_;
  std::map<std::string, std::size_t> taken_;
};

/// Reads every field into `state`; the parts that one of them forbids, each with its reason.
std::map<StatePart, std::string> read_fields(Lines& lines, State& state) {
  std::map<StatePart, std::string> refused;
  calib::visit_state(state, [&](const FieldOfState& field, auto& member) {
    const std::vector<double> values = lines.numbers(std::string(field.name));
    std::size_t wanted = 1;
    if constexpr (!kIsNumber<decltype(member)>) wanted = member.size();
    std::string fault = values.size() != wanted
                            ? fmt::format("{}: {} numbers instead of {}", field.name, values.size(), wanted)
                            : fault_of(field, values);
    if (!fault.empty()) {
      refused.emplace(field.part, std::move(fault));
      return;
    }
    if constexpr (kIsNumber<decltype(member)>)
      member = static_cast<std::decay_t<decltype(member)>>(values[0]);
    else
      std::copy(values.begin(), values.end(), member.begin());
  });
  return refused;
}

void start_anew(State& state, StatePart part, const State& fresh) {
  if (part == StatePart::kAcc) state.acc = fresh.acc;
  if (part == StatePart::kGyr) state.gyr = fresh.gyr;
  if (part == StatePart::kGyrMatrix) state.gyr_matrix = fresh.gyr_matrix;
  if (part == StatePart::kMag) state.mag = fresh.mag;
  if (part == StatePart::kCommon) state.temperatures = fresh.temperatures;
}

/// The learnt bias is over the factory's: another factory bias is another learnt one.
void convert_gyr(State& state, const std::map<std::string, std::vector<double>>& before, const TriadCalibration& now) {
  const double s = calib::kTempScale_K;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double change[] = {before.at("factory.gyr.bias")[axis] - now.bias[axis],
                             s * (before.at("factory.gyr.bias_per_K")[axis] - now.bias_per_K[axis]),
                             s * s * (before.at("factory.gyr.bias_per_K2")[axis] - now.bias_per_K2[axis])};
    for (std::size_t k = 0; k < 3; ++k) {
      state.gyr.published.filter.x[4 * axis + k] += change[k];
      state.gyr.rival.filter.x[4 * axis + k] += change[k];
    }
  }
}

/// What another factory calibration or temperature model means for what was learnt over the old one.
std::vector<std::string> fit_to(const calib::OnlineCalibrator& c, Lines& lines, State& state, const State& fresh) {
  std::vector<std::string> remarks;
  std::map<std::string, std::vector<double>> before;
  std::map<std::string, std::string> changed;  // by sensor: what
  for (const auto& [name, values] : factory_values(c.factory())) {
    before[name] = lines.numbers(name);
    if (before[name] != values) changed[name.substr(8, 3)] = name.substr(12);
    before[name].resize(values.size());
  }
  const std::string model(lines.next("temperature_model"));
  if (model != c.params().temperature_model) {
    start_anew(state, StatePart::kAcc, fresh);
    remarks.push_back(fmt::format("temperature_model was '{}' and is '{}'; the accelerometer is learnt anew", model,
                                  c.params().temperature_model));
  } else if (changed.contains("acc")) {
    start_anew(state, StatePart::kAcc, fresh);
    remarks.push_back(fmt::format(
        "sensor.acc: another {} than what was learnt stands on; the accelerometer is learnt anew", changed["acc"]));
  }
  if (changed.contains("mag")) {
    start_anew(state, StatePart::kMag, fresh);
    remarks.push_back(fmt::format(
        "sensor.mag: another {} than what was learnt stands on; the magnetometer is learnt anew", changed["mag"]));
  }
  if (changed.contains("gyr") && before["factory.gyr.temp_ref_degC"][0] == c.factory().gyr.temp_ref_degC) {
    convert_gyr(state, before, c.factory().gyr);
    remarks.push_back(fmt::format("sensor.gyr: another {}; what was learnt is converted and goes on", changed["gyr"]));
  } else if (changed.contains("gyr")) {
    start_anew(state, StatePart::kGyr, fresh);
    remarks.emplace_back("sensor.gyr: another temp_ref_degC; the gyroscope's bias is learnt anew");
  }
  return remarks;
}

}  // namespace

std::string calibration_text(const calib::OnlineCalibrator& calibrator) {
  const std::string header = header_text(calibrator);
  std::string text = fmt::format("{}\nfingerprint {:016x}\n{}", kTitle, fnv1a(header), header);
  const State state = calibrator.state();
  calib::visit_state(state, [&text](const FieldOfState& field, const auto& member) {
    if constexpr (kIsNumber<decltype(member)>)
      text += fmt::format("{} {} {}\n", field.name, field.unit, member);
    else
      text += fmt::format("{} {} {}\n", field.name, field.unit, fmt::join(member, " "));
  });
  return text;
}

Result<std::vector<std::string>> restore_calibration(std::string_view text, calib::OnlineCalibrator& calibrator) {
  if (!text.starts_with(kTitle) || text.substr(kTitle.size(), 1) != "\n") {
    const bool ours = text.starts_with("stillpoint-calibration ");
    return fail(ErrorKind::kBadData,
                ours ? fmt::format("of another version: '{}', not '{}'",
                                   text.substr(0, std::min<std::size_t>(text.find('\n'), 40)), kTitle)
                     : "of a version before 5, whose numbers this one cannot read");
  }
  Lines lines(text);
  const State fresh = calibrator.state();
  State state = fresh;
  const auto refused = read_fields(lines, state);
  std::vector<std::string> remarks;
  for (const auto& [part, fault] : refused) {
    start_anew(state, part, fresh);
    remarks.push_back(fmt::format("{}; {} is learnt anew", fault, name(part)));
  }
  const std::string before(lines.next("fingerprint"));
  if (before != fmt::format("{:016x}", fnv1a(header_text(calibrator))))
    for (std::string& remark : fit_to(calibrator, lines, state, fresh)) remarks.push_back(std::move(remark));
  if (!calibrator.restore(state))
    return fail(ErrorKind::kBadData, "holds numbers that no calibration can have: " + calib::fault_of(state));
  return remarks;
}

}  // namespace stillpoint::io
