/// Forward selection of the physics in one sensor's residual: scan, short list, refinement with the noise estimated
/// beside each candidate, and a charge for every freedom the search has used.
#pragma once
#include <map>
#include <optional>

#include "diagnosis/reference/laws.h"
#include "diagnosis/reference/scan.h"
#include "diagnosis/reference/timing.h"

namespace stillpoint::diag {

struct Ranked {
  std::string id;
  Window window;
  double gain_nats = 0.0, net_nats = 0.0;
};

/// A number inside of a law that it is as free in as in its coefficients: a time constant, a moment, a threshold.
struct InnerNumber {
  std::string name, unit;
  double value = 0.0;
  std::function<Columns(double)> columns;  ///< of the law with another one
};

/// One effect as found, refined and fitted.
struct Found {
  std::string id;
  Kind kind = Kind::kNamed;
  Window window;
  double shape = 0.0, shape_sd = 0.0;   ///< sd: where the shape was fitted apart
  std::map<std::string, double> fixed;  ///< numbers that belong to the effect and have no column, by key
  std::string shape_name, shape_unit, unit, equation, driver;
  std::string form_of;  ///< as in Law: a form that is known, but not by a name of this library
  std::function<Columns(double shape)> at_shape;  ///< columns of a law with a time constant; empty: it has none
  std::vector<std::string> names, units;          ///< of the coefficients
  Columns columns;                                ///< linear part: the law's columns, or the tangent of a timing law
  Series3 offset;                                 ///< timing: the predicted residual at `timing`; empty: none
  std::vector<InnerNumber> inner;                 ///< of a discovered law
  Eigen::VectorXd timing;                         ///< parameters of a timing law
  std::function<bool(const Eigen::VectorXd&)> possible;  ///< parameters of a timing law that a sensor can have
  double gain_nats = 0.0;                                ///< log-likelihood over the model without it
  double net_nats = 0.0;                                 ///< the gain minus what the freedom of the search is worth
  std::vector<Ranked> rivals;                            ///< of the round that chose it, best first, itself among them
};

/// Everything about one sensor while the search runs.
struct SensorSearch {
  Sensor sensor = kAcc;
  Target target;  ///< residual: timing offsets already subtracted; without a walk
  std::vector<Law> laws, unknown;
  std::vector<std::string> deleted;  ///< names that are not in the library this time
  bool delays_in_windows = true;     ///< false: the latency of all sensors varies, which is no delay of this one
  std::vector<Found> found;
  std::vector<Ranked> ranking;      ///< of the first round
  std::vector<double> moments_s{};  ///< where windows that gained begin or end, to the sample
  double first_gain = 0.0;
  WalkBasis walk;
  Series t_s;
  bool walk_is_given = false;  ///< the simulation has a slow random process of its own here: no discovery, no charge
  [[nodiscard]] Target beside_walk() const;
  [[nodiscard]] Columns explained() const;
  [[nodiscard]] bool has_unknown() const;
  /// By index of a candidate: the catalogue's laws, then the products outside of it.
  [[nodiscard]] const Law& law(std::size_t index) const {
    return index < laws.size() ? laws[index] : unknown[index - laws.size()];
  }
};

/// What a name has to gain beyond the freedom of the search before it is stated; beside something - an effect found
/// before, a drift - that leaves over what is no noise; and a law of the catalogue in a window, where slow noise passes
/// for an offset.
inline constexpr double kLeastNet = 1.5, kLeastNetBeside = 3.0, kLeastNetLocal = 8.0;

/// Of the largest gain in the sensor: the remainder of a large effect must not get a name of its own.
inline constexpr double kLeastShareOfFirst = 0.02;

/// Closer than this the recording cannot tell two explanations apart; where each has its own best window, twice that.
[[nodiscard]] inline double tie_nats(const Window& window) { return window.local ? 10.0 : 5.0; }

/// The freedom of the search in nats: coefficients, the choice among laws, a window in time.
[[nodiscard]] double charge(std::size_t coefficients, const Window& window);

/// `without`: names that are not in the library this time. Of the products, those that are a law of the library under
/// another name are left out.
[[nodiscard]] SensorSearch start_search(const Signals& s, Sensor sensor, const std::vector<std::string>& without = {});

/// The best next effect, or none when nothing is worth its charge.
[[nodiscard]] std::optional<Found> next_effect(const Signals& s, SensorSearch& search);

/// Adds it to the model, then drops any earlier effect that it makes superfluous.
void accept(SensorSearch& search, Found found);
/// What the first `count` effects gain beside all others; the first that is not worth its charge is dropped.
void weigh_again(SensorSearch& search, std::size_t count);
/// A linear law beside all that was found and a walk; its coefficients are the last ones. `beside` is this fit below.
[[nodiscard]] Fit fit_beside(const SensorSearch& search, const Found& law);
/// What a linear law does with the coefficients that it has there (n x 3).
[[nodiscard]] Series3 effect_of(const Found& law, const Fit& beside);
/// Nats that the coefficients of a linear law are worth by the scatter of what each second says of them; the law's gain
/// where too few seconds speak.
[[nodiscard]] double robust_nats(const SensorSearch& search, const Found& law, const Fit& beside);
/// What bias and matrix leave of an effect, in the rows that count; 0 in the others.
[[nodiscard]] Series3 beyond_matrix(const SensorSearch& search, const Series3& effect);
/// Whether what bias and matrix leave of a law is more than a trace of it. On a turntable `up` hardly varies: a
/// coefficient of 50 uT fits 0.03 uT of a camera's noise, and every other motion would be made worse by all of it.
[[nodiscard]] bool varies(const SensorSearch& search, const Found& law, const Fit& beside);

/// The model without effect `index`: what it explained is residual again.
void take_out(SensorSearch& search, std::size_t index);

/// Log-likelihood gained by subtracting `offset`, the noise given.
[[nodiscard]] double gain_of_offset(const SensorSearch& search, const Series3& offset);

}  // namespace stillpoint::diag
