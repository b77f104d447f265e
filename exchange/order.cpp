#include "exchange/order.h"
#include "core/median.h"

#include <fmt/format.h>

#include <algorithm>

namespace stillpoint::exchange {
namespace {

using Times = std::vector<std::int64_t>;

/// Of the steps that advance, the one in the middle; 0 where none does.
std::int64_t usual_step(const Times& t_ns) {
  Times steps;
  for (std::size_t i = 1; i < t_ns.size(); ++i)
    if (t_ns[i] > t_ns[i - 1]) steps.push_back(t_ns[i] - t_ns[i - 1]);
  return median(std::move(steps));
}

/// Gives how often the counter wrapped. A restart leaves a step over the wrap that is no usual one.
std::size_t unwrap(Times& t_ns, std::int64_t usual_ns) {
  constexpr std::int64_t kMostSteps = 5;                        // some readings may be lost there
  constexpr std::int64_t kLongest_ns = 10'000'000'000'000'000;  // 115 days: differences of any two times still fit
  std::size_t wraps = 0;
  std::int64_t passed_ns = 0;
  for (std::size_t i = 1, before = 0; i < t_ns.size(); before = i++) {
    const std::int64_t last_ns = t_ns[before] - passed_ns;
    for (const std::int64_t tick_ns : {1, 1000, 1'000'000}) {
      const std::int64_t period_ns = (std::int64_t{1} << 32) * tick_ns;
      const bool within = t_ns[i] >= 0 && t_ns[i] < last_ns && last_ns < period_ns;
      if (!within || (t_ns[i] + period_ns - last_ns) / kMostSteps > usual_ns) continue;
      if (passed_ns + period_ns > kLongest_ns) continue;
      passed_ns += period_ns;
      ++wraps;
      break;
    }
    t_ns[i] += passed_ns;
  }
  return wraps;
}

std::string counted(std::size_t n, std::string_view what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); }

/// Gives how many were dropped.
template <class Keep>
std::size_t keep_if(Stream& s, const Keep& keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s.t_ns.size(); ++i) {
    if (!keep(i, kept)) continue;
    s.t_ns[kept] = s.t_ns[i];
    s.values[kept++] = s.values[i];
  }
  const std::size_t dropped = s.t_ns.size() - kept;
  s.t_ns.resize(kept);
  s.values.resize(kept);
  return dropped;
}

}  // namespace

void put_in_order(Stream& s, std::vector<std::string>& why) {
  if (s.t_ns.empty()) return;
  const std::int64_t usual_ns = usual_step(s.t_ns);
  if (const auto wraps = unwrap(s.t_ns, usual_ns); wraps > 0)
    why.push_back(
        fmt::format("{}: its 32-bit counter wraps {}; it was taken to go on", s.from, counted(wraps, "time")));
  // Kept, a lone stamp ahead would cost every row after it.
  const auto alone_ahead = [&](std::size_t i, std::size_t kept) {
    constexpr std::int64_t kFar = 10, kFarAtTheEnd = 1000;  // nothing after the last one tells it from a pause
    if (usual_ns == 0) return false;
    const std::int64_t now = s.t_ns[i];
    if (i + 1 == s.t_ns.size()) return kept > 0 && (now - s.t_ns[kept - 1]) / kFarAtTheEnd > usual_ns;
    const std::int64_t next = s.t_ns[i + 1];
    const bool returns = now > next && (kept == 0 || next > s.t_ns[kept - 1]);
    return returns && (now - next) / kFar > usual_ns;
  };
  const std::size_t wild = keep_if(s, [&](std::size_t i, std::size_t kept) { return !alone_ahead(i, kept); });
  const std::size_t late =
      keep_if(s, [&](std::size_t i, std::size_t kept) { return kept == 0 || s.t_ns[i] > s.t_ns[kept - 1]; });
  if (wild > 0)
    why.push_back(fmt::format("{}: {} dropped, far ahead of all others in time", s.from, counted(wild, "row")));
  if (late > 0) why.push_back(fmt::format("{}: {} dropped, whose time does not advance", s.from, counted(late, "row")));
}

}  // namespace stillpoint::exchange
