/// The hypotheses: what each effect of docs/effects.md predicts for one sensor's residual, as columns with units.
/// Each law is linear in its coefficients for a given `shape` (a time constant, a level); filters are refined apart
/// (timing.h).
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "diagnosis/reference/regression.h"

namespace stillpoint::diag {

enum class Kind {
  kNamed,          ///< an effect of the catalogue
  kUnknown,        ///< a product of drivers outside the catalogue
  kConfiguration,  ///< a wrong number in the simulation, not missing physics
  kTiming,         ///< a delay or filter: its linear form here only finds it, timing.h names it
};

/// Shape name of a law seen through an adaptive bias estimate: no effect of the catalogue has it.
inline constexpr const char* kTrackerShape = "tracker_tau";

/// Of the body, which the reference does not see vibrate.
inline constexpr const char* kBodyVibration = "body_vibration";

/// Of a reference, not of the simulation: its attitudes are smoothed.
inline constexpr const char* kSmoothedReference = "ref_smoothed";
inline constexpr const char* kTurnedAttitudes = "attitude_world";  ///< against the world of the positions

/// The one coefficient of a law that acts as a whole or not at all; with less of itself it stands for another law.
inline const std::vector<std::string> kWholeOrNothing{"share"};
[[nodiscard]] inline bool is_share_of_a_whole(double share) { return share > 0.3 && share < 1.25; }

enum class Extent { kAny, kStep, kWhole };  ///< may be local in time; must be (a constant would be the offset); never

struct Law {
  std::string id;
  Kind kind = Kind::kNamed;
  Extent extent = Extent::kAny;
  std::vector<double> shapes{0.0};
  std::string shape_name, shape_unit;  ///< empty: the law has no inner parameter
  std::string text;  ///< of a product: its law as a simulation takes it, "{}" for the shape; empty: its name
  std::map<std::string, double> fixed;  ///< keys of the catalogue that this form of the law implies
  std::function<Columns(double shape)> columns;
  std::vector<std::string> coefficients;  ///< names, one a column
  std::string unit, equation, driver;
  std::vector<std::string> units;  ///< of each coefficient, where they have not all the same
  std::string form_of;  ///< of a product: the law of the catalogue that has this very form for this sensor; empty: none
};

/// Every law of one sensor whose drivers the recording holds. The columns refer to `s`, which must outlive them.
[[nodiscard]] std::vector<Law> make_laws(const Signals& s, Sensor sensor);
/// Products of drivers outside the catalogue, about two hundred a sensor.
[[nodiscard]] std::vector<Law> make_unknown_laws(const Signals& s, Sensor sensor);
/// By their names: a product of some, not all, of another's factors; (V-V0) is one of f_x*(V-V0).
[[nodiscard]] bool is_part_of(const std::string& part, const std::string& whole);

}  // namespace stillpoint::diag
