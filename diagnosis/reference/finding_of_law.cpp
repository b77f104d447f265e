#include "diagnosis/reference/finding_of_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/certainty.h"
#include "diagnosis/discovery/law_words.h"
#include "diagnosis/discovery/open_numbers.h"
#include "diagnosis/reference/clock_of_rows.h"
#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/curves.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/nameless.h"
#include "diagnosis/reference/unrecorded.h"
#include "diagnosis/reference/wider_law.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

constexpr std::size_t kMostEquivalent = 2;

void channels_of(const SensorSearch& search, std::size_t index, const Finished& finished, Finding& out) {
  const Found& f = search.found[index];
  const Eigen::Index first = first_column(search, index);
  for (int axis = 0; axis < 3; ++axis) {
    bool shown = false;
    for (std::size_t j = 0; j < f.columns.size(); ++j) {
      const Eigen::Index at = first + static_cast<Eigen::Index>(j);
      const bool significant = std::abs(finished.values[at]) > 3.0 * finished.sd[at];
      shown = shown || (f.columns[j].axis < 0 && significant) || (f.columns[j].axis == axis && significant);
    }
    if (shown)
      out.channels.push_back(
          fmt::format("{}_{}", kSensorName[search.sensor], kAxisName[static_cast<std::size_t>(axis)]));
  }
}

/// All nine entries, row by row; the last of the diagonal is minus the sum of the others.
void entries_of_gradient(const SensorSearch& search, std::size_t index, const Finished& finished, Finding& out) {
  const Eigen::Index first = first_column(search, index);
  const double x = finished.sd[first], y = finished.sd[first + 3];
  const Eigen::MatrixXd& c = finished.fit.covariance;
  const double together = c(first, first + 3) / std::sqrt(c(first, first) * c(first + 3, first + 3));
  const double half = 1.96 * std::sqrt(std::max(x * x + y * y + 2.0 * together * x * y, 0.0));
  constexpr std::array<int, 9> kColumn{0, 1, 2, 1, 3, 4, 2, 4, -1};
  const std::vector<std::string> names = entries("G");
  for (std::size_t j = 0; j < names.size(); ++j) {
    const double zz = -finished.values[first] - finished.values[first + 3];
    out.parameters.push_back(kColumn[j] < 0
                                 ? Parameter{names[j], zz, {zz - half, zz + half}, search.found[index].unit}
                                 : number_of(finished, first + kColumn[j], names[j], search.found[index].unit));
  }
}

void parameters_of(const SensorSearch& search, std::size_t index, const Finished& finished, Finding& out) {
  const Found& f = search.found[index];
  if (f.id == "mag_gradient") return entries_of_gradient(search, index, finished, out);
  const Eigen::Index first = first_column(search, index);
  for (std::size_t j = 0; j < f.names.size() && j < f.columns.size(); ++j)
    out.parameters.push_back(number_of(finished, first + static_cast<Eigen::Index>(j), f.names[j], f.units[j]));
  const auto inner = [&](const std::string& name, double value, double sd, const std::string& unit) {
    out.parameters.push_back({name, value, {value - 1.96 * sd, value + 1.96 * sd}, unit});
  };
  const std::map<std::string, double>& sd = finished.inner_sd[index];
  for (const InnerNumber& n : f.inner)
    if (sd.contains(n.name)) inner(n.name, n.value, sd.at(n.name), n.unit);
  if (f.shape_name.empty()) return;
  const auto free = sd.find(f.shape_name);
  if (free == sd.end() && f.shape_sd == 0.0 && is_unknown(f.id)) return;  // the formula has it, known or not
  inner(f.shape_name, f.shape, free == sd.end() ? f.shape_sd : free->second, f.shape_unit);
}

/// Names that come so close that this recording cannot exclude them, and the best that it can.
void rivals_of(const Found& f, Finding& out) {
  const auto ranked = std::find_if(f.rivals.begin(), f.rivals.end(), [&](const Ranked& r) { return r.id == f.id; });
  if (ranked == f.rivals.end()) return;
  if (f.kind == Kind::kUnknown)
    for (const Ranked& r : f.rivals) {
      const auto law = law_tree(r.id);
      if (!law) continue;
      const auto seen = [text = law_text(r.id)](const WeighedLaw& w) { return w.text == text; };  // in an earlier round
      if (std::none_of(out.weighed.begin(), out.weighed.end(), seen))
        out.weighed.push_back({law_text(r.id), laws::complexity_bits(*law), r.gain_nats, r.net_nats});
    }
  for (const Ranked& r : f.rivals) {
    if (form_of(r.id) == form_of(f.id) || r.id.ends_with("_world") ||
        std::find(out.equivalent.begin(), out.equivalent.end(), r.id) != out.equivalent.end())
      continue;
    const bool tie = r.net_nats > ranked->net_nats - tie_nats(f.window) && !is_unknown(r.id);
    if (tie && out.equivalent.size() < kMostEquivalent) {
      out.equivalent.push_back(r.id);
    } else if (!tie && out.runner_up_effect.empty()) {
      out.runner_up_effect = r.id;
      out.runner_up_why_rejected =
          fmt::format("explains {:.0f} nats less than {}", ranked->net_nats - r.net_nats, f.id);
    }
  }
}

std::string deciding_recording(const Finding& f) {
  const sim::EffectInfo* info = sim::find_effect(f.effect);
  if (const auto others = not_excluded(f); f.wider && others.empty())
    return fmt::format("to narrow the bounds: {}", info != nullptr ? info->told_apart_by : "more varied motion");
  if (!f.equivalent.empty()) {
    const sim::EffectInfo* other = sim::find_effect(f.equivalent.front());
    return fmt::format("{} or {}: told apart by: {}", f.effect, f.equivalent.front(),
                       info != nullptr    ? info->told_apart_by
                       : other != nullptr ? other->told_apart_by
                                          : "more varied motion");
  }
  return info == nullptr ? "vary each of the drivers alone" : fmt::format("to be sure: {}", info->told_apart_by);
}

}  // namespace

void describe_time(const Signals& s, const Window& window, Finding& out) {
  const double begin = begin_of_row_s(s, window.begin), end = begin_of_row_s(s, window.end);
  out.interval_s = window.local ? std::array{begin, end} : std::array{0.0, begin_of_row_s(s, s.n)};
  if (!window.local)
    out.regime = "all the time";
  else if (window.end >= s.n)
    out.regime = fmt::format("from {:.1f} s on", begin);
  else
    out.regime = fmt::format("between {:.1f} and {:.1f} s only", begin, end);
}

double chance_of(const SensorSearch& search, const Found& f) {
  const auto frequencies =
      static_cast<std::size_t>(is_line(f.id) || f.id == "mag_flip" ? search.target.layout.n / 2 : 1);
  const auto tried = static_cast<double>(std::max(search.laws.size() + search.unknown.size(), frequencies));
  return std::min(1.0, chi_square_tail(2.0 * f.gain_nats, static_cast<double>(f.columns.size())) * tried *
                           (f.window.local ? 500.0 : 1.0));
}

Finding finding_from(const Signals& s, const SensorSearch& search, std::size_t index, const Finished& finished,
                     HeldOut held_out) {
  const Found& f = search.found[index];
  Finding out;
  out.effect = f.id;
  out.equation = f.equation;
  out.driver = f.driver;
  describe_time(s, f.window, out);
  channels_of(search, index, finished, out);
  parameters_of(search, index, finished, out);
  out.held_out = std::move(held_out);
  out.p_value = chance_of(search, f);
  // A current nearby that was not recorded does what a piece of iron does.
  if (f.id == "mag_hard_step" && !s.current_A.size()) out.equivalent.emplace_back("mag_current");
  // Of a resonance above the band in which bodies move only the flank is seen: the sensor gains what a camera loses.
  // And a camera does not see how a body trembles.
  const bool fast = f.id.ends_with("_resonance") && f.timing.size() > 0 && f.timing[0] > kMotionBand_Hz;
  if ((fast || is_line(f.id)) && search.sensor != kMag && !s.exact_reference) out.equivalent.emplace_back("ref_error");
  rivals_of(f, out);
  out.wider = wider_law(search, index);
  out.figures = curves_of(s, search, index, finished);
  out.decided_by = f.id == kUnrecordedScalar ? "record " + missing_drivers(s, search.sensor) : deciding_recording(out);
  out.confidence = confidence_of(f.net_nats);
  return out;
}

}  // namespace stillpoint::diag
