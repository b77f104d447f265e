#include "bench/drill_faults.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"

namespace stillpoint::bench {
namespace {

using Random = std::mt19937;
using Triad = Array3 RawSample::*;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double seconds(const Rows& rows, const RawSample& row) { return in_seconds(row.t_ns - rows.front().t_ns); }

std::int64_t ns(double s) { return static_cast<std::int64_t>(1e9 * s); }

bool coin(Random& random) { return (random() & 1U) != 0; }

/// `change(row, before, axis, random)` for each row of the interval; `before` is the last sound row, `axis` the same
/// for all.
template <class Change>
auto rowwise(Change change) {
  return [change](Rows& rows, const Interval& when, Random& random) {
    RawSample before;
    const std::size_t axis = random() % 3;
    for (RawSample& row : rows) {
      const double t_s = seconds(rows, row);
      if (t_s < when.from_s) before = row;
      if (when.holds(t_s)) change(row, before, axis, random);
    }
  };
}

auto stuck(std::vector<Triad> triads) {
  return rowwise([triads](RawSample& row, const RawSample& before, std::size_t, Random&) {
    for (const Triad triad : triads) row.*triad = before.*triad;
  });
}

auto stuck_axis(Triad triad) {
  return rowwise([triad](RawSample& row, const RawSample& before, std::size_t axis, Random&) {
    (row.*triad)[axis] = (before.*triad)[axis];
  });
}

auto zero(Triad triad) {
  return rowwise([triad](RawSample& row, const RawSample&, std::size_t, Random&) { row.*triad = {}; });
}

auto flipped(Triad triad) {
  return rowwise([triad](RawSample& row, const RawSample&, std::size_t axis, Random&) { (row.*triad)[axis] *= -1.0; });
}

auto swapped(Triad triad) {
  return rowwise([triad](RawSample& row, const RawSample&, std::size_t axis, Random&) {
    std::swap((row.*triad)[axis], (row.*triad)[(axis + 1) % 3]);
  });
}

auto scaled(Triad triad, double factor) {
  return rowwise([triad, factor](RawSample& row, const RawSample&, std::size_t, Random&) {
    for (double& x : row.*triad) x *= factor;
  });
}

auto offset(Triad triad, double by) {
  return rowwise(
      [triad, by](RawSample& row, const RawSample&, std::size_t axis, Random&) { (row.*triad)[axis] += by; });
}

auto noisy(Triad triad, double sd) {
  return rowwise([triad, sd](RawSample& row, const RawSample&, std::size_t, Random& random) {
    std::normal_distribution<double> normal(0.0, sd);
    for (double& x : row.*triad) x += normal(random);
  });
}

auto clipped(Triad triad, double limit) {
  return rowwise([triad, limit](RawSample& row, const RawSample&, std::size_t, Random&) {
    for (double& x : row.*triad) x = std::clamp(x, -limit, limit);
  });
}

/// One sample a second reads an absurd value.
auto spikes(Triad triad, double size) {
  return rowwise([triad, size](RawSample& row, const RawSample&, std::size_t axis, Random& random) {
    if (random() % 100 == 0) (row.*triad)[axis] = coin(random) ? size : -size;
  });
}

auto not_finite(Triad triad) {
  return rowwise([triad](RawSample& row, const RawSample&, std::size_t axis, Random&) { (row.*triad)[axis] = kNaN; });
}

auto silent(std::uint8_t parts) {
  return rowwise([parts](RawSample& row, const RawSample&, std::size_t, Random&) {
    row.has = static_cast<std::uint8_t>(row.has & ~parts);
  });
}

/// The readings of so long ago, with the time of now.
auto delayed(Triad triad, double by_s) {
  return [triad, by_s](Rows& rows, const Interval& when, Random&) {
    const Rows sound = rows;
    std::size_t from = 0;
    for (RawSample& row : rows) {
      const double t_s = seconds(sound, row);
      if (!when.holds(t_s)) continue;
      while (sound[from + 1].t_ns <= row.t_ns - ns(by_s)) ++from;
      row.*triad = sound[from].*triad;
    }
  };
}

/// Rows are lost with this probability each.
auto dropped(double probability) {
  return [probability](Rows& rows, const Interval& when, Random& random) {
    std::uniform_real_distribution<double> uniform;
    const std::int64_t zero_ns = rows.front().t_ns;
    std::erase_if(rows, [&](const RawSample& row) {
      const double t_s = in_seconds(row.t_ns - zero_ns);
      return when.holds(t_s) && uniform(random) < probability;
    });
  };
}

auto gap(double length_s) {
  return [length_s](Rows& rows, const Interval& when, Random& random) {
    dropped(1.0)(rows, {when.from_s, when.from_s + length_s}, random);
  };
}

auto clock_step(double by_s) {
  return [by_s](Rows& rows, const Interval& when, Random&) {
    const std::int64_t zero_ns = rows.front().t_ns;
    for (RawSample& row : rows)
      if (in_seconds(row.t_ns - zero_ns) >= when.from_s) row.t_ns += ns(by_s);
  };
}

/// Every tenth row comes twice.
void duplicated(Rows& rows, const Interval& when, Random&) {
  Rows out;
  out.reserve(rows.size() + rows.size() / 10);
  for (const RawSample& row : rows) {
    out.push_back(row);
    if (when.holds(seconds(rows, row)) && out.size() % 10 == 0) out.push_back(row);
  }
  rows = std::move(out);
}

/// Every tenth row changes places with the one before it.
void reordered(Rows& rows, const Interval& when, Random&) {
  const Rows sound = rows;
  for (std::size_t k = 1; k < rows.size(); k += 10)
    if (when.holds(seconds(sound, sound[k]))) std::swap(rows[k - 1], rows[k]);
}

/// The sensor renews its readings four times more rarely than it is asked.
auto held() {
  return [](Rows& rows, const Interval& when, Random&) {
    const Rows sound = rows;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (!when.holds(seconds(sound, sound[k]))) continue;
      const RawSample& old = sound[k - k % 4];
      rows[k].acc_mps2 = old.acc_mps2;
      rows[k].gyr_radps = old.gyr_radps;
      rows[k].mag_uT = old.mag_uT;
    }
  };
}

}  // namespace

std::vector<DrillFault> drill_faults() {
  const Triad acc = &RawSample::acc_mps2, gyr = &RawSample::gyr_radps, mag = &RawSample::mag_uT;
  return {
      {"acc stuck", kAcc, 2.0, stuck({acc})},
      {"gyr stuck", kGyr, 2.0, stuck({gyr})},
      {"mag stuck", kMag, 10.0, stuck({mag})},
      {"all stuck (hung bus)", kGyr, 2.0, stuck({acc, gyr, mag})},
      {"acc one axis stuck", kAcc, 5.0, stuck_axis(acc)},
      {"gyr one axis stuck", kGyr, 5.0, stuck_axis(gyr)},
      {"mag one axis stuck", kMag, 10.0, stuck_axis(mag)},
      {"acc zero", kAcc, 2.0, zero(acc)},
      {"gyr zero", kGyr, 2.0, zero(gyr)},
      {"mag zero", kMag, 2.0, zero(mag)},
      {"acc silent", kAcc, 1.0, silent(kAcc)},
      {"gyr silent", kGyr, 1.0, silent(kGyr)},
      {"mag silent", kMag, 2.0, silent(kMag)},
      {"acc sign of one axis", kAcc, 10.0, flipped(acc)},
      {"gyr sign of one axis", kGyr, 10.0, flipped(gyr)},
      {"mag sign of one axis", kMag, 10.0, flipped(mag)},
      {"acc axes swapped", kAcc, 10.0, swapped(acc)},
      {"gyr axes swapped", kGyr, 10.0, swapped(gyr)},
      {"mag axes swapped", kMag, 10.0, swapped(mag)},
      {"acc scale x 2", kAcc, 10.0, scaled(acc, 2.0)},
      {"gyr scale x 2", kGyr, 10.0, scaled(gyr, 2.0)},
      {"mag scale x 2", kMag, 5.0, scaled(mag, 2.0)},
      {"acc in g", kAcc, 12.0, scaled(acc, 1.0 / kStandardGravity_mps2)},
      {"gyr in deg/s", kGyr, 12.0, scaled(gyr, kDegPerRad)},
      {"acc offset 2 m/s2", kAcc, 20.0, offset(acc, 2.0)},
      {"gyr offset 1 deg/s", kGyr, 30.0, offset(gyr, kRadPerDeg)},
      {"gyr offset 10 deg/s", kGyr, 10.0, offset(gyr, 10.0 * kRadPerDeg)},
      {"mag offset 40 uT", kMag, 5.0, offset(mag, 40.0)},
      {"acc noise x 30", kAcc, 10.0, noisy(acc, 0.9)},
      {"gyr noise x 30", kGyr, 10.0, noisy(gyr, 0.06)},
      {"mag noise x 30", kMag, 10.0, noisy(mag, 12.0)},
      {"acc clipped at 12 m/s2", kAcc, 10.0, clipped(acc, 12.0)},
      {"gyr clipped at 60 deg/s", kGyr, 10.0, clipped(gyr, 60.0 * kRadPerDeg)},
      {"acc spikes of 1000 m/s2", kAcc, 0.0, spikes(acc, 1000.0)},
      {"gyr spikes of 300 rad/s", kGyr, 0.0, spikes(gyr, 300.0)},
      {"mag spikes of 5000 uT", kMag, 0.0, spikes(mag, 5000.0)},
      {"acc NaN", kAcc, 1.0, not_finite(acc)},
      {"gyr NaN", kGyr, 1.0, not_finite(gyr)},
      {"acc 0.2 s late", kAcc, 0.0, delayed(acc, 0.2)},
      {"mag 0.2 s late", kMag, 0.0, delayed(mag, 0.2)},
      {"a third of the rows lost", kGyr, 1.0, dropped(0.33)},
      {"gap of 0.3 s", kGyr, 1.0, gap(0.3)},
      {"gap of 3 s", kGyr, 3.5, gap(3.0)},
      {"rows twice", kGyr, 0.0, duplicated},
      {"rows out of order", kGyr, 0.0, reordered},
      {"readings held four rows", kGyr, 0.0, held()},
      {"clock 1 s forward", kGyr, 1.5, clock_step(1.0)},
      {"clock 1 s back", kGyr, 1.5, clock_step(-1.0)},
  };
}

}  // namespace stillpoint::bench
