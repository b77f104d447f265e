#include "apps/stillpoint/page_json.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/stillpoint/daemon_session.h"
#include "apps/stillpoint/live_words.h"
#include "apps/stillpoint/status_view.h"

namespace stillpoint::app {
namespace {

/// "live", "stale" or "waiting", and for the last two a sentence that says why.
std::pair<std::string, std::string> freshness(const WatchState& s, const io::DdsParams& dds, int publishers) {
  if (s.received == 0) return {"waiting", nothing_arrives(dds, dds.attitude_topic, publishers > 0)};
  const bool is_silent = s.diagnostics && s.diagnostics->status == AttitudeStatus::kStale;
  if (s.age_s <= 1.0 && s.attitude->status != AttitudeStatus::kStale) return {"live", ""};
  const std::string age = fmt::format("no attitude for {:.0f} s; ", s.age_s);
  if (publishers == 0) return {"stale", age + "the daemon has gone, or can no longer be reached"};
  if (is_silent) return {"stale", age + "the daemon runs, but its source is silent: " + s.diagnostics->source};
  return {"stale", age + "the daemon is there, but sends nothing"};
}

/// Four bins an octave, from the first that holds something to the last.
nlohmann::json histogram(const LatencyCounts& counts) {
  constexpr std::size_t kMerged = 4;
  auto edges = nlohmann::json::array();
  auto bins = nlohmann::json::array();
  std::size_t first = 0;
  std::size_t end = counts.size();
  while (first < end && counts[first] == 0) ++first;
  while (end > first && counts[end - 1] == 0) --end;
  for (std::size_t i = first - first % kMerged; i < end; i += kMerged) {
    std::uint64_t n = 0;
    for (std::size_t k = i; k < i + kMerged; ++k) n += counts[k];
    edges.push_back(1e-3 * static_cast<double>(latency_bucket_lower_ns(i)));
    bins.push_back(n);
    if (i + kMerged >= end) edges.push_back(1e-3 * static_cast<double>(latency_bucket_lower_ns(i + kMerged)));
  }
  return {{"edges_us", edges}, {"counts", bins}};
}

nlohmann::json rests_json(const PageModel& model) {
  auto list = nlohmann::json::array();
  for (const SeenRest& r : model.rests())
    list.push_back(
        {{"start_s", r.start_s}, {"seconds", r.seconds}, {"up_body", numbers(r.up_body)}, {"going_on", r.going_on}});
  return list;
}

/// In words, what has not been seen: sides never laid on, else how many parts.
std::string missing_directions(const std::array<double, kDirections>& rested_s) {
  constexpr std::array kSides{"front up", "back up", "left side up", "right side up", "top up", "upside down"};
  std::string sides;
  std::size_t parts = 0;
  for (std::size_t side = 0; side < kSides.size(); ++side) {
    std::size_t seen = 0;
    for (std::size_t k = 4 * side; k < 4 * side + 4; ++k) seen += rested_s[k] > 0 ? 1U : 0U;
    parts += 4 - seen;
    if (seen == 0) sides += (sides.empty() ? "" : ", ") + std::string(kSides[side]);
  }
  if (!sides.empty()) return "no rest yet with " + sides;
  return parts == 0 ? "" : fmt::format("{} of {} directions have seen no rest yet", parts, kDirections);
}

nlohmann::json coverage_json(const PageModel& model) {
  const auto rested_s = model.rested_s();
  const auto seen = std::count_if(rested_s.begin(), rested_s.end(), [](double s) { return s > 0; });
  return {{"rested_s", numbers(rested_s)},
          {"share", static_cast<double>(seen) / static_cast<double>(kDirections)},
          {"missing", missing_directions(rested_s)}};
}

}  // namespace

nlohmann::json page_json(const WatchState& state, const PageModel& model, const io::DdsParams& dds, int publishers,
                         double t_s) {
  const auto [freshness_word, why] = freshness(state, dds, publishers);
  nlohmann::json out{{"schema", "stillpoint.page/1"}, {"t_s", t_s},
                     {"freshness", freshness_word},   {"why", why},
                     {"watch", json_view(state)},     {"status", nullptr},
                     {"rests", rests_json(model)},    {"coverage", coverage_json(model)}};
  if (state.diagnostics && state.calibration) out["status"] = status_json(state);
  out["latency"] = {{"here", histogram(state.latency_counts)}, {"daemon", nullptr}};
  if (state.diagnostics) out["latency"]["daemon"] = histogram(state.diagnostics->latency_counts);
  return out;
}

nlohmann::json history_json(const PageModel& model) {
  const auto curve = model.curve();
  auto t = nlohmann::json::array();
  auto rpy = nlohmann::json::array();
  auto sigma = nlohmann::json::array();
  auto at_rest = nlohmann::json::array();
  for (const CurvePoint& p : curve) {
    t.push_back(p.t_s);
    rpy.push_back(numbers(p.rpy_rad));
    sigma.push_back(numbers(p.sigma_rad));
    at_rest.push_back(p.at_rest);
  }
  return {{"schema", "stillpoint.page.history/1"},
          {"t_s", t},
          {"roll_pitch_yaw_rad", rpy},
          {"sigma_rpy_rad", sigma},
          {"at_rest", at_rest}};
}

}  // namespace stillpoint::app
