#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/given_effects.h"

namespace stillpoint::diag {
namespace {

constexpr double kStamps_s = 1e-3;   // to which the clocks of camera and sensor are commonly brought together
constexpr double kNothing_s = 1e-4;  // no rig is asked to be better

}  // namespace

void set_reference_on_time(Signals& s, const sim::ReferenceConfig& reference) {
  if (reference.latency_s == 0.0) return;
  static_cast<void>(subtract_effects(
      s, {{.id = "sys_offset", .parameters = {{"tau_s", {-reference.latency_s}}}, .axes = {}, .window_s = {}}}));
}

void leave_to_the_reference(const Signals& s, Answer& answer) {
  if (s.exact_reference || s.from_log) return;
  const auto offset = std::find_if(answer.effects.begin(), answer.effects.end(),
                                   [](const auto& e) { return e.id == "sys_offset" && !e.window_s; });
  if (offset == answer.effects.end()) return;
  const double latency_s = -offset->parameters.at("tau_s").front();
  if (std::abs(latency_s) >= kStamps_s) return;
  answer.effects.erase(offset);
  answer.reference_latency_s = latency_s;
  answer.diagnosis.notices.push_back(fmt::format(
      "reference: {} by {:.2g} ms beside the sensors; no other recording tells whose time stamps these are. "
      "The improved simulation has them as reference: {{latency_s: {:.3g}}}",
      latency_s > 0.0 ? "late" : "early", 1e3 * std::abs(latency_s), latency_s));
  if (std::abs(latency_s) < kNothing_s)
    std::erase_if(answer.diagnosis.findings, [](const Finding& f) { return f.effect == "sys_offset"; });
}

}  // namespace stillpoint::diag
