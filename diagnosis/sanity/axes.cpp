#include <fmt/format.h>

#include <algorithm>

#include "diagnosis/sanity/reference_checks.h"

namespace stillpoint::diag::detail {
namespace {

struct Turned {
  Sensor sensor;
  Mat3 turn;
  std::string words;
};

std::vector<Turned> turned_sensors(const Comparison& c, const Sanity& known, std::size_t& compared) {
  constexpr double kTogether = 0.7;
  std::vector<Turned> turned;
  for (const Sensor s : {kAcc, kGyr, kMag}) {
    if (known.unusable[s]) continue;
    const Relation r = c.relation(s);
    if (!r.spans_space() || r.coherence() < kTogether) continue;  // from one plane no map is determined
    ++compared;
    const Mat3 turn = r.turn();
    if (std::string words = axes_in_words(turn); !words.empty()) turned.push_back({s, turn, std::move(words)});
  }
  return turned;
}

}  // namespace

bool body_is_turned(const Comparison& c, Sanity& out) {
  std::size_t compared = 0;
  const auto turned = turned_sensors(c, out, compared);
  if (turned.size() < 2 || turned.size() < compared || turned[0].turn.determinant() < 0) return false;
  for (const Turned& t : turned)
    if (t.words != turned[0].words) return false;
  out.mistake(
      fmt::format("reference: its body is turned against the sensor's: all sensors agree with it about other "
                  "axes ({}); turn the readings or the quaternions",
                  turned[0].words));
  out.reference_unusable = true;
  return true;
}

void check_axes(const Comparison& c, Sanity& out) {
  std::size_t compared = 0;
  for (const Turned& t : turned_sensors(c, out, compared)) {
    const bool gravity = t.sensor == kAcc && t.turn.isApprox(-Mat3::Identity(), 0.5);
    out.set_aside(t.sensor, fmt::format("{}: agrees with the reference only with other axes ({}){}",
                                        kSensorName[t.sensor], t.words,
                                        gravity ? ": it gives gravity where specific force is expected"
                                        : t.turn.determinant() < 0.0 ? ": its axes are left-handed"
                                                                     : ""));
  }
}

}  // namespace stillpoint::diag::detail
