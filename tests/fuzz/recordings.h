/// What every reader of recordings promises of what it hands on.
#pragma once
#include <algorithm>

#include "exchange/stream.h"
#include "io/recording.h"
#include "tests/fuzz/fuzz.h"

namespace stillpoint::fuzz {

inline void expect_sound(const io::Recording& r) {
  for (std::size_t row = 1; row < r.size(); ++row) expect(r.t_ns[row] > r.t_ns[row - 1], "times advance");
  const auto whole = [&r](const auto& column) { return column.empty() || column.size() == r.size(); };
  expect(whole(r.acc_mps2) && whole(r.gyr_radps) && whole(r.mag_uT) && whole(r.temp_degC) && whole(r.current_A) &&
             whole(r.supply_V) && whole(r.ref_q_world_body) && whole(r.ref_position_m) && whole(r.ref_moving),
         "a column has a value for each row");
  for (const auto& [name, values] : r.user_columns) expect(whole(values), "a column has a value for each row", name);
  for (std::size_t row = 0; row < r.size(); ++row) {
    const RawSample s = r.sample(row);
    for (const auto* reading : {&s.acc_mps2, &s.gyr_radps, &s.mag_uT})
      expect(vec(*reading).allFinite(), "what a sample holds is finite");
  }
}

/// The way from any foreign file to a recording.
inline void merge_soundly(const Result<std::vector<exchange::Stream>>& streams) {
  if (!streams)
    return expect(streams.error().message.starts_with("f."), "a fault names its file", streams.error().message);
  for (const auto& s : *streams) {
    expect(s.t_ns.size() == s.values.size(), "each reading has its time");
    for (const Vec3& v : s.values) expect(v.allFinite(), "a reading of a stream is finite");
  }
  const auto merged = exchange::merge(*streams, "f.log");
  if (!merged) return;
  taken();
  expect_sound(merged->recording);
}

}  // namespace stillpoint::fuzz
