#include "diagnosis/reference/adequacy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/columns.h"

namespace stillpoint::diag {
namespace {

constexpr double kPlainOffsetNats = 6.0;
constexpr double kPartShare = 1e-4;  // of a product's gain: what a factor has to explain to be named
constexpr double kArmsAgree = 0.95;  // three arms of the size effect that agree are one lever arm
constexpr double kStepInBody = 0.4;  // of a soft step's gain
constexpr double kSetUpShare = 0.5;  // of a product's net gain
constexpr double kRowsLost = 0.95;   // a delay from one row on: rows are missing there
constexpr double kAdequateNats = 3.0, kAdequateShare = 0.02;
constexpr double kFreeNats = 3.0, kFreeShare = 0.003;
constexpr int kDegree = 4;  // of a free function: bends once more than any law of the catalogue

/// A law is adequate as long as nothing outside the catalogue explains more than this beyond it: what is outside
/// contains the forms of the laws as well, so a law that is right is beaten by no more than chance, and by what its
/// driver is known to. In a window, where its best edges are found for every form anew, chance does more.
double adequate_within(const Found& law) {
  const double twice = law.window.local ? 2.0 : 1.0;
  return std::max(twice * kAdequateNats, twice * kAdequateShare * law.gain_nats);
}

/// What the recording cannot tell from `law`: as good as it but for chance.
bool ties_with(const Found& other, const Found& law) {
  return other.net_nats > law.net_nats - std::max(tie_nats(law.window), adequate_within(law));
}

/// Sum of the squares of what a fit leaves over, per axis.
Eigen::Array3d power_left(const Target& t, const Columns& columns) {
  return (fit_profile(t, columns).leftover.array().square().colwise() * t.layout.counts).colwise().sum();
}

Eigen::Array3d power_left_beside(const SensorSearch& search, const Found& law) {
  Target t = search.target;
  if (law.offset.size()) t.residual -= law.offset;
  return power_left(t, law.offset.size() ? search.explained() : joined(search.explained(), law.columns));
}

/// The recorded or measured quantity that a law is a function of, times a vector where it has one.
struct Driver {
  std::string name;
  Series3 x;       ///< the argument, per axis
  Series3 factor;  ///< what the function is multiplied with; empty: nothing
  bool operator==(const Driver& other) const { return name == other.name; }
};

std::optional<Driver> driver_of(const Signals& s, Sensor sensor, const std::string& id) {
  const auto is = [&id](std::initializer_list<const char*> ends) {
    return std::any_of(ends.begin(), ends.end(), [&id](const char* end) { return id.ends_with(end); });
  };
  const auto alike = [](const std::string& name, const Series& x) {
    return Driver{fmt::format("h({})", name), x.replicate(1, 3), {}};
  };
  static constexpr std::array<const char*, kSensors> kVector{"f", "w", "m"};
  const std::string vector = kVector[sensor];
  if (is({"_temp_lin", "_temp_quad", "_temp_lag"})) return alike("T-T0", s.temperature_K);
  if (is({"_temp_scale"})) {
    Driver d = alike("T-T0", s.temperature_K);
    d.name += "*" + vector;
    d.factor = s.vector[sensor];
    return d;
  }
  if (is({"_volt"})) return alike("V-V0", s.voltage_V.array() - s.voltage_V.mean());
  if (is({"_current"})) return alike("I", s.current_A);
  if (is({"_quad", "_cubic", "_asym", "_sat"})) return Driver{fmt::format("h({}_i)", vector), s.vector[sensor], {}};
  return std::nullopt;
}

/// Legendre polynomials of the driver on its range, each axis with coefficients of its own. The constant, and the line
/// where it is a wrong matrix, are fitted beside every hypothesis.
Found free_function(const Driver& d, Sensor sensor, const Found& law) {
  Found f;
  f.id = "unknown:" + d.name;
  f.kind = Kind::kUnknown;
  f.window = law.window;
  f.unit = d.factor.size() ? "1" : kSensorUnit[sensor];
  f.equation = "delta = " + d.name + ", h a smooth function of its own for each axis";
  f.driver = law.driver;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = d.x.col(axis).minCoeff(), high = d.x.col(axis).maxCoeff();
    const Series x = (2.0 * (d.x.col(axis).array() - low) / std::max(high - low, 1e-12) - 1.0).matrix();
    const Series scale = d.factor.size() ? Series(d.factor.col(axis)) : Series(Series::Ones(x.size()));
    Series before = Series::Ones(x.size()), p = x;
    for (int degree = 1; degree <= kDegree; ++degree) {
      f.names.push_back(fmt::format("h{}_{}", degree, kAxisName[static_cast<std::size_t>(axis)]));
      f.columns.push_back({axis, p.cwiseProduct(scale)});
      const Series next =
          ((2.0 * degree + 1.0) * x.cwiseProduct(p) - static_cast<double>(degree) * before) / (degree + 1.0);
      before = std::exchange(p, next);
    }
  }
  f.columns = in_window(std::move(f.columns), f.window);
  f.units.assign(f.names.size(), f.unit);
  return f;
}

/// A law of temperature, supply or current: in a window in which its column hardly changes, it is no more than an
/// offset.
bool follows_a_column(const std::string& id) {
  return id.ends_with("_temp_lin") || id.ends_with("_volt") || id.ends_with("_current");
}

/// What an offset is in the magnetometer: iron on the body, or a field that changed.
bool is_plain_step(const std::string& id) { return id == "mag_hard_step" || id == "mag_field_step"; }

/// The first of the sorted ones that holds; null: none.
template <class Holds>
const Found* first_of(const std::vector<Found>& sorted, const Holds& holds) {
  const auto at = std::find_if(sorted.begin(), sorted.end(), holds);
  return at == sorted.end() ? nullptr : &*at;
}

/// The best that is not beaten by what needs less belief.
Found most_believable(const std::vector<Found>& sorted, bool current_recorded) {
  const Found& best = sorted.front();
  const auto first = [&sorted](const auto& holds) { return first_of(sorted, holds); };
  if (best.kind == Kind::kUnknown) {
    // That the reference's world leans, the given field is wrong or the body vibrates is believed before a product is
    // that explains not much more; what is left of the product is found beside it.
    const Found* set_up = first([](const Found& f) { return f.kind == Kind::kConfiguration; });
    if (set_up != nullptr && set_up->net_nats > kSetUpShare * best.net_nats) return *set_up;
    const Found* named = first([](const Found& f) { return f.kind != Kind::kUnknown; });
    if (named == nullptr || best.net_nats >= named->net_nats + adequate_within(*named)) {
      // A factor that hardly varies here, such as gravity on a turntable, is nothing that was seen to matter.
      const Found* part = first([&best](const Found& f) {
        return is_part_of(f.id, best.id) &&
               f.net_nats > best.net_nats - std::max(tie_nats(best.window), kPartShare * best.gain_nats);
      });
      return part != nullptr ? *part : best;
    }
    return named->window.local && best.id == kPlainOffset ? best : *named;
  }
  if (best.kind == Kind::kNamed && best.window.local && !best.id.ends_with("_step")) {
    const Found* offset = first([](const Found& f) { return f.id == kPlainOffset || is_plain_step(f.id); });
    if (offset != nullptr && offset->net_nats > best.net_nats - kPlainOffsetNats) return *offset;
  }
  const auto instead = [&](const char* id, double share) {
    const Found* other = first([&](const Found& f) { return f.id == id; });
    return other != nullptr && other->gain_nats > share * best.gain_nats ? *other : best;
  };
  if (best.id.ends_with("_lpf")) {  // as a delay the other sensors can tell whether it is the clock of all
    const Found* delay = first([](const Found& f) { return f.id.ends_with("_delay"); });
    if (delay != nullptr && delay->net_nats > best.net_nats - tie_nats(best.window)) return *delay;
  }
  if (best.id.ends_with("_delay") && best.window.local) return instead("sys_gap", kRowsLost);
  if (best.id == "acc_size") return instead("acc_lever", kArmsAgree);
  if (best.id == "mag_soft_step" && !current_recorded) return instead("mag_hard_step", kStepInBody);
  return best;
}

}  // namespace

std::optional<Found> best_explanation(const std::vector<Found>& sorted, bool current_recorded) {
  if (sorted.empty()) return std::nullopt;
  Found best = most_believable(sorted, current_recorded);
  if (best.kind == Kind::kUnknown) return best;
  const Found* nameless = first_of(sorted, [](const Found& f) { return !f.form_of.empty(); });
  return nameless != nullptr && ties_with(*nameless, best) ? *nameless : best;
}

Found adequate(const Signals& s, const SensorSearch& search, const Judge& judge, Found law) {
  if (law.kind != Kind::kNamed || law.shape_name == kTrackerShape) return law;
  const auto driver = driver_of(s, search.sensor, law.id);
  if (!driver) return law;
  Found free = free_function(*driver, search.sensor, law);
  // One noise for both, that of the freer: beside a law that misses something slow, an autoregression takes the miss
  // for its own memory.
  const Target& t = judge.walking() ? judge.beside_walk() : judge.without_walk();
  const Columns explained = search.explained();
  const Fit freest = fit_profile(t, joined(explained, free.columns));
  const NoiseModel noise(t.layout, freest.leftover);
  const auto net = [&](const Columns& columns) {
    return fit_with(t, joined(explained, columns), noise, freest.walk_q).log_likelihood - charge(columns.size(), {});
  };
  const double of_free = net(free.columns), gain = of_free - net({});
  const double needed = of_free - std::max(kFreeNats, kFreeShare * gain);
  if (law.window.local && follows_a_column(law.id)) {  // what a bent law does all the time, a straight one does there
    Found lasting;
    lasting.driver = law.driver;
    lasting = free_function(*driver, search.sensor, lasting);
    if (net(lasting.columns) > net(law.columns) + charge(0, {}) - charge(0, law.window)) {
      judge.weigh(lasting);
      lasting.rivals = std::move(law.rivals);
      return lasting;
    }
  }
  if (net(law.columns) >= needed) return law;
  for (const Law& other : search.laws) {  // two laws of one driver are names, their sum is none
    if (other.id == law.id || other.shape_name == kTrackerShape || driver_of(s, search.sensor, other.id) != driver)
      continue;
    for (const double shape : other.shapes)
      if (net(joined(law.columns, in_window(other.columns(shape), law.window))) >= needed) return law;
  }
  judge.weigh(free);
  free.rivals = std::move(law.rivals);
  return free;
}

bool leaves_less(const SensorSearch& search, const Found& law) {
  constexpr double kOfChance = 1.005;
  return power_left_beside(search, law).sum() < kOfChance * power_left(search.target, search.explained()).sum();
}

bool leaves_only_noise(const Signals& s, const SensorSearch& search, const Found& law) {
  constexpr double kOverNoise = 1.35;  // noises are configured to a fifth
  const double sd = s.noise_sd[search.sensor];
  if (!s.exact_reference || sd <= 0) return false;
  const double most = power_left_beside(search, law).maxCoeff() / std::max(search.target.layout.used(), 1.0);
  return std::sqrt(most) < kOverNoise * sd;
}

}  // namespace stillpoint::diag
