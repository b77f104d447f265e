#include "apps/stillpoint/known_turns.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "io/quote.h"

namespace stillpoint::app {
namespace {

constexpr double kHand_deg = 1.5;      // how well a hand comes back to where it began
constexpr double kTurntable = 0.003;   // of the rate, of one that is driven by a belt or a quartz
constexpr double kLargestShare = 0.1;  // a deviation of more says hardly anything of a scale
constexpr double kContradicts = 25.0;  // chi-square of one number
constexpr double kMost_deg = 1e7;
constexpr double kDegPerS_per_rpm = 6.0;

std::optional<double> number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// The three or four numbers of an option; empty where they are none.
std::vector<double> numbers(std::string_view text) {
  std::vector<double> out;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(':', from), text.size());
    const auto value = number(text.substr(from, end - from));
    if (!value) return {};
    out.push_back(*value);
    from = end + 1;
  }
  return out.size() == 3 || out.size() == 4 ? out : std::vector<double>();
}

Result<calib::StatedTurn> stated(const std::string& text, double begin_s, double end_s, double angle_deg,
                                 double sd_deg) {
  const auto wrong = [&text](const std::string& why) {
    return fail(ErrorKind::kUsage, fmt::format("{}: {}", io::quote(text), why));
  };
  if (begin_s < 0.0 || begin_s >= end_s) return wrong("it has to begin at 0 s or later and to end after that");
  if (angle_deg == 0.0) return wrong("a turn of nothing says nothing of the gyroscope's scale");
  if (std::abs(angle_deg) > kMost_deg) return wrong(fmt::format("more than {:g} deg", kMost_deg));
  if (!(sd_deg > 0.0 && sd_deg <= kLargestShare * std::abs(angle_deg)))
    return wrong("the deviation has to be above zero and at most a tenth of what is stated");
  return calib::StatedTurn{begin_s, end_s, std::abs(angle_deg) * kRadPerDeg, sd_deg * kRadPerDeg};
}

}  // namespace

Result<calib::StatedTurn> parse_turn(const std::string& text) {
  const auto n = numbers(text);
  if (n.empty())
    return fail(ErrorKind::kUsage,
                fmt::format("{} is no turn; write {}, such as 66:70.5:360", io::quote(text), kTurnType));
  return stated(text, n[0], n[1], n[2], n.size() > 3 ? n[3] : kHand_deg);
}

Result<calib::StatedTurn> parse_rate(const std::string& text) {
  const std::size_t rpm = text.find("rpm");
  const auto n = numbers(rpm == std::string::npos ? text : std::string(text).erase(rpm, 3));
  const std::size_t end = rpm == std::string::npos ? 0 : rpm + 3;
  if (n.empty() || (end != 0 && end != text.size() && text[end] != ':'))
    return fail(ErrorKind::kUsage, fmt::format("{} is no rate; write {}, such as 20:80:200 or 20:80:33.333rpm",
                                               io::quote(text), kRateType));
  const double seconds = n[1] - n[0], unit = rpm == std::string::npos ? 1.0 : kDegPerS_per_rpm;
  const double sd = n.size() > 3 ? n[3] : kTurntable * std::abs(n[2]);
  auto turn = stated(text, n[0], n[1], n[2] * unit * seconds, sd * unit * seconds);
  if (turn) turn->steady = true;
  return turn;
}

Result<std::vector<KnownTurnReport>> measure(const std::vector<std::string>& turns,
                                             const std::vector<std::string>& rates, const io::Recording& recording,
                                             const GyrAt& gyr_at) {
  std::vector<KnownTurnReport> out;
  const auto add = [&](const std::string& option, const Result<calib::StatedTurn>& stated) -> Result<void> {
    if (!stated) return tl::unexpected(stated.error());
    double temp_sum = 0.0, temps = 0.0;
    for (std::size_t k = 0; k < recording.temp_degC.size(); ++k) {
      const double t_s = recording.t_s(k) - recording.t_s(0);
      if (t_s < stated->begin_s || t_s > stated->end_s || !std::isfinite(recording.temp_degC[k])) continue;
      temp_sum += recording.temp_degC[k];
      temps += 1.0;
    }
    const TriadCalibration gyr = gyr_at(stated->end_s);
    const auto turn = calib::known_turn(*stated, recording.t_ns, recording.gyr_radps,
                                        gyr.bias_at(temps > 0.0 ? temp_sum / temps : gyr.temp_ref_degC),
                                        Mat3(mat(gyr.bias_covariance)));
    if (!turn) return fail(turn.error().kind, option + ": " + turn.error().message);
    out.push_back({option, *stated, *turn, {}, {}});
    return {};
  };
  for (const std::string& text : turns)
    if (const auto added = add("--turn " + text, parse_turn(text)); !added) return tl::unexpected(added.error());
  for (const std::string& text : rates)
    if (const auto added = add("--rate " + text, parse_rate(text)); !added) return tl::unexpected(added.error());
  return out;
}

std::string describe(const KnownTurnReport& t) {
  return fmt::format("stated {:.6g} +- {:.3g} {}, read {:.2f} before, {:.2f} after ({:+.1f} sd){}",
                     t.in_unit(t.turn.angle_rad), t.in_unit(t.stated.sd_rad), t.unit(), t.in_unit(t.before.angle_rad),
                     t.in_unit(t.after.angle_rad), t.residual_sd(), t.turn.used ? "" : ", not used");
}

std::vector<std::string> remarks(const std::vector<KnownTurnReport>& turns) {
  std::vector<std::string> out;
  for (const KnownTurnReport& t : turns) {
    const double stated_rad = t.turn.angle_rad;
    constexpr auto kMaybe = "the axis may have moved, or the angle, the span or the sensor's range be another";
    if (!t.turn.used)
      out.push_back(
          fmt::format("{}: {}: what is known of the gyroscope contradicts it; {}", t.option, describe(t), kMaybe));
    else if (t.after.chi2(stated_rad) > kContradicts)
      out.push_back(fmt::format("{}: {}: other turns contradict it; {}", t.option, describe(t), kMaybe));
    else if (t.before.chi2(stated_rad) > kContradicts)
      out.push_back(fmt::format("{}: {}: the scale is {:+.0f} % off what it was taken for; if that cannot be, {}",
                                t.option, describe(t), 100.0 * (stated_rad / t.before.angle_rad - 1.0), kMaybe));
  }
  return out;
}

nlohmann::ordered_json to_json(const std::vector<KnownTurnReport>& turns) {
  auto out = nlohmann::ordered_json::array();
  for (const KnownTurnReport& t : turns)
    out.push_back({{"begin_s", t.stated.begin_s},
                   {"end_s", t.stated.end_s},
                   {"unit", t.unit()},
                   {"stated", t.in_unit(t.turn.angle_rad)},
                   {"stated_sd", t.in_unit(t.stated.sd_rad)},
                   {"before", t.in_unit(t.before.angle_rad)},
                   {"after", t.in_unit(t.after.angle_rad)},
                   {"residual_sd", t.residual_sd()},
                   {"used", t.turn.used}});
  return out;
}

}  // namespace stillpoint::app
