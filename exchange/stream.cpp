#include "exchange/stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "exchange/order.h"

namespace stillpoint::exchange {
namespace {

constexpr double kYear_s = 365.25 * 86400.0;

Result<void> expect_overlap(const std::vector<Stream>& streams, const std::string& name) {
  for (const Stream& a : streams)
    for (const Stream& b : streams)
      if (a.t_ns.front() > b.t_ns.back())
        return fail(ErrorKind::kBadData,
                    fmt::format("{}: {} begins {:.3f} s after {} has ended; are their clocks different ones?", name,
                                a.from, in_seconds(a.t_ns.front() - b.t_ns.back()), b.from));
  return {};
}

void place(const Stream& s, const std::vector<std::int64_t>& times, io::Recording& to) {
  const Vec3 missing = Vec3::Constant(io::kMissing);
  const auto each = [&](const auto& put) {
    std::size_t row = 0;
    for (std::size_t i = 0; i < s.t_ns.size(); ++i) {
      while (times[row] != s.t_ns[i]) ++row;
      put(row, s.values[i]);
    }
  };
  if (s.quantity == Quantity::kTemp) {
    to.temp_degC.resize(times.size(), io::kMissing);
    each([&](std::size_t row, const Vec3& v) { to.temp_degC[row] = v.x(); });
    return;
  }
  auto& column = s.quantity == Quantity::kAcc ? to.acc_mps2 : s.quantity == Quantity::kGyr ? to.gyr_radps : to.mag_uT;
  column.resize(times.size(), missing);
  each([&](std::size_t row, const Vec3& v) { column[row] = v; });
}

std::string described(const Stream& s) {
  const double span_s = in_seconds(s.t_ns.back() - s.t_ns.front());
  return fmt::format("{} from {}: {} readings, {:.1f} s, {:.1f} Hz", name(s.quantity), s.from, s.t_ns.size(), span_s,
                     span_s > 0 ? static_cast<double>(s.t_ns.size() - 1) / span_s : 0.0);
}

}  // namespace

const char* name(Quantity quantity) {
  constexpr const char* kNames[] = {"acc", "gyr", "mag", "temp"};
  return kNames[static_cast<int>(quantity)];
}

Result<Imported> merge(std::vector<Stream> streams, const std::string& file) {
  Imported out;
  bool inertial = false;
  std::vector<std::int64_t> times;
  std::erase_if(streams, [](const Stream& s) { return s.t_ns.empty(); });
  for (Stream& s : streams) {
    inertial = inertial || s.quantity == Quantity::kAcc || s.quantity == Quantity::kGyr;
    put_in_order(s, out.reasons);
    out.reasons.push_back(described(s));
    times.insert(times.end(), s.t_ns.begin(), s.t_ns.end());
  }
  if (!inertial)
    return fail(ErrorKind::kBadData, file +
                                         ": no accelerometer and no gyroscope in it; name their columns in a map "
                                         "(docs/import.md shows one)");
  if (auto overlap = expect_overlap(streams, file); !overlap) return tl::unexpected(overlap.error());
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (times.front() < times.back() - kLatest_ns)
    return fail(ErrorKind::kBadData,
                fmt::format("{}: its times span {:.0f} years; are they in the unit that was taken?", file,
                            1e-9 / kYear_s * static_cast<double>(times.back() - times.front())));
  for (const Stream& s : streams) place(s, times, out.recording);
  out.recording.header["start_time_ns"] = std::to_string(times.front());
  for (const std::int64_t t : times) out.recording.t_ns.push_back(t - times.front());
  return out;
}

}  // namespace stillpoint::exchange
