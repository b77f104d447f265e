#include "diagnosis/discovery/law_search.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/discovery/drivers.h"
#include "diagnosis/discovery/term_scan.h"
#include "diagnosis/reference/driver_unit.h"
#include "diagnosis/reference/golden_section.h"
#include "diagnosis/reference/judge.h"

namespace stillpoint::diag {
namespace {

constexpr std::size_t kShort = 5;                       // of each noise, to be judged
constexpr std::size_t kShortSecond = 2, kExtended = 2;  // texts that are taken further, and what is judged of that
constexpr std::size_t kRefined = 3;  // of those, whose number is sought between the points of its grid
constexpr double kNatsAShape = 3.0;  // the choice of an open number
constexpr int kSections = 10;

struct Look {
  std::size_t idea = 0;
  double shape = 0.0, gain = -1.0, net = -1.0;
};

laws::Signature signature_of(const laws::Columns& drivers) {
  std::vector<std::string> users;
  for (const auto& [name, x] : drivers.values)
    if (name.find('_') != std::string::npos && name.find('(') == std::string::npos) users.push_back(name);
  return laws::drivers_with(users);
}

/// The rows of a search with what it has subtracted so far.
Signals with_residual(const Signals& s, const SensorSearch& base) {
  Signals out = s;
  out.residual[base.sensor] = base.target.residual;
  return out;
}

}  // namespace

struct LawSearch::Parts {
  const Signals& s;
  Sensor sensor;
  Eigen::Index factor;
  std::shared_ptr<const laws::Columns> shared;
  const laws::Columns& full;
  laws::Columns slow;
  laws::Signature signature;
  std::vector<Idea> ideas;

  Parts(const Signals& signals, Sensor k, double rows)
      : s(signals),
        sensor(k),
        factor(std::max<Eigen::Index>(1, std::lround(static_cast<double>(signals.n) / rows))),
        shared(std::make_shared<const laws::Columns>(drivers_of_rows(s))),
        full(*shared) {
    slow.t_s = means_of_rows(full.t_s, factor);
    for (const auto& [name, x] : full.values) slow.values[name] = means_of_rows(x, factor);
    signature = signature_of(full);
    ideas = first_ideas(sensor, slow);
  }

  struct Value {
    Eigen::MatrixXd x;
    double bits = 0.0;
    laws::Unit unit;
  };
  [[nodiscard]] std::optional<Value> value(const std::string& text, const laws::Columns& drivers) const {
    const auto tree = laws::parse(text, signature);
    if (!tree) return std::nullopt;
    Value out{laws::evaluate(*tree, drivers), laws::complexity_bits(*tree), tree->unit};
    if (!out.x.allFinite()) return std::nullopt;
    return out;
  }

  /// The best number of one idea under each scan.
  [[nodiscard]] std::vector<Look> look(const Idea& idea, std::size_t index,
                                       const std::vector<const TermScan*>& scans) const {
    std::vector<Look> best(scans.size(), Look{index});
    for (const double shape : idea.shapes) {
      std::vector<double> gain(scans.size(), 0.0);
      double price = idea.shapes.size() > 1 ? kNatsAShape : 0.0;
      bool good = true;
      for (std::size_t part = 0; part < idea.texts.size() && good; ++part) {
        const auto v = value(idea.text(part, shape), slow);
        good = v.has_value();
        if (!good) break;
        for (std::size_t i = 0; i < scans.size(); ++i) gain[i] += scans[i]->gain(v->x, idea.matrix);
        price += kNatsABit * v->bits + (idea.matrix ? 18.0 : 6.0);
      }
      for (std::size_t i = 0; i < scans.size() && good; ++i)
        if (gain[i] - price > best[i].net) best[i] = {index, shape, gain[i], gain[i] - price};
    }
    return best;
  }

  [[nodiscard]] std::optional<Term> term(const Idea& idea, double shape, const laws::Columns& drivers) const {
    Term out{idea, shape, 0.0, {}};
    Found& f = out.found;
    for (std::size_t part = 0; part < idea.texts.size(); ++part) {
      const auto v = value(idea.text(part, shape), drivers);
      if (!v) return std::nullopt;
      out.bits += v->bits;
      f.columns = joined(std::move(f.columns), columns_of_value(v->x, idea.matrix && v->x.cols() == 3));
    }
    f.id = "unknown:" + idea.text(0, shape);
    f.kind = Kind::kUnknown;
    f.shape = shape;
    f.names.assign(f.columns.size(), "k");
    return out;
  }

  [[nodiscard]] double net_of(const Term& t) const {
    return t.found.gain_nats - charge(t.found.columns.size(), {}) - kNatsABit * t.bits -
           (t.idea.shape_name.empty() ? 0.0 : kNatsAShape);
  }
};

LawSearch::LawSearch(const Signals& s, Sensor sensor, double rows) : parts_(std::make_unique<Parts>(s, sensor, rows)) {}
LawSearch::~LawSearch() = default;
const std::shared_ptr<const laws::Columns>& LawSearch::drivers() const { return parts_->shared; }

namespace {

/// The thinned side of a search, with the noises that candidates are looked at under: the one that the null model
/// leaves, beside its walk; one that has learnt colour from what a smooth model leaves; and a white one. Under the last
/// two a strong law does not hide as memory, under the first what fits only their error does not come first.
struct Thin {
  Signals s;
  Target target, white, null;
  Columns explained;
  std::vector<NoiseModel> noises;
  std::vector<TermScan> all;

  Thin(const Signals& full, const SensorSearch& base, Eigen::Index factor, bool walks)
      : s(factor > 1 ? thinned(with_residual(full, base), factor) : with_residual(full, base)) {
    target = make_target(s, base.sensor);
    for (const Column& c : base.explained()) explained.push_back({c.axis, means_of_rows(c.x, factor)});
    null = target;
    if (walks) null.walk = walk_basis(s);
    white = target;
    white.layout.order = 0;
    noises.reserve(3), all.reserve(3);
    noises.emplace_back(null.layout, fit_profile(null, explained).leftover);
    noises.push_back(scan_noise(target, explained, walk_basis(s)));
    const NoiseModel level(white.layout, white.residual);
    noises.emplace_back(white.layout, fit_with(white, explained, level, {}).leftover);
    all.emplace_back(null, explained, noises[0]);
    all.emplace_back(target, explained, noises[1]);
    all.emplace_back(white, explained, noises[2]);
  }
  Thin(const Thin&) = delete;
  Thin& operator=(const Thin&) = delete;
};

void keep_best(std::vector<Look>& all, std::size_t count) {
  std::sort(all.begin(), all.end(), [](const Look& a, const Look& b) { return a.net > b.net; });
  if (all.size() > count) all.resize(count);
  std::erase_if(all, [](const Look& l) { return l.net <= 0; });
}

}  // namespace

double LawSearch::most(const SensorSearch& base) {
  const Thin thin(parts_->s, base, parts_->factor, true);
  double out = 0.0;
  for (std::size_t i = 0; i < parts_->ideas.size(); ++i)
    out = std::max(out, parts_->look(parts_->ideas[i], i, {thin.all.data()}).front().gain);
  return out;
}

/// One round: short lists, refined, then what the best could be a part of.
class LawSearch::Round {
 public:
  Round(const Parts& parts, const SensorSearch& base)
      : p_(parts), judge_(base), thin_(parts.s, base, parts.factor, judge_.walking()), ideas_(parts.ideas) {}

  std::vector<Term> run() {
    shortlist(0, kShort);
    if (terms_.empty()) return {};
    refine_best();
    const std::size_t first_level = ideas_.size();
    for (std::size_t i = 0; i < std::min(kExtended, terms_.size()); ++i)
      for (Idea& idea : second_ideas(terms_[i].idea, terms_[i].shape, p_.slow)) ideas_.push_back(std::move(idea));
    shortlist(first_level, kShortSecond);
    refine_best();
    if (const auto moment = moment_of(terms_.front().idea, terms_.front().shape)) {
      ideas_.push_back(*moment);
      shortlist(ideas_.size() - 1, 1);
      refine_best();
    }
    std::erase_if(terms_, [](const Term& t) { return t.found.net_nats <= 0; });
    return std::move(terms_);
  }

 private:
  void judge(const Idea& idea, double shape) {
    auto t = p_.term(idea, shape, p_.full);
    if (!t) return;
    judge_.weigh(t->found);
    t->found.net_nats = p_.net_of(*t);
    terms_.push_back(std::move(*t));
  }

  /// The best of the ideas from one on, under each noise, judged on all rows.
  void shortlist(std::size_t from, std::size_t count) {
    std::vector<const TermScan*> scans;
    for (const TermScan& scan : thin_.all) scans.push_back(&scan);
    std::vector<std::vector<Look>> best(scans.size());
    for (std::size_t i = from; i < ideas_.size(); ++i) {
      const std::vector<Look> looks = p_.look(ideas_[i], i, scans);
      for (std::size_t k = 0; k < scans.size(); ++k) best[k].push_back(looks[k]);
    }
    std::vector<std::pair<std::size_t, double>> known;
    for (auto& list : best) {
      keep_best(list, count);
      for (const Look& l : list) {
        if (std::find(known.begin(), known.end(), std::pair{l.idea, l.shape}) != known.end()) continue;
        known.emplace_back(l.idea, l.shape);
        judge(ideas_[l.idea], l.shape);
      }
    }
  }

  /// The open number between the points of its grid, by golden section on the thinned rows.
  void refine(const Idea& idea, double coarse) {
    const auto& grid = idea.shapes;
    const auto there = p_.term(idea, coarse, p_.slow);
    if (idea.shape_name.empty() || grid.size() < 2 || !there) return;
    const auto at = std::lower_bound(grid.begin(), grid.end(), coarse);
    const double low = at == grid.begin() ? grid[0] - 0.4 * (grid[1] - grid[0]) : *std::prev(at);
    const double high = at == grid.end() || std::next(at) == grid.end() ? coarse * 1.5 : *std::next(at);
    const auto with = [this](const Term& t) { return joined(thin_.explained, t.found.columns); };
    const NoiseModel noise(thin_.target.layout, fit_profile(thin_.target, with(*there)).leftover);
    const auto likelihood = [&](double shape) {
      const auto t = p_.term(idea, shape, p_.slow);
      return t ? fit_with(thin_.target, with(*t), noise, {}).log_likelihood : -1e300;
    };
    judge(idea, highest_by_golden_section(std::min(low, high), std::max(low, high), kSections, likelihood));
  }

  void refine_best() {
    const auto sort = [this] {
      std::sort(terms_.begin(), terms_.end(),
                [](const Term& a, const Term& b) { return a.found.net_nats > b.found.net_nats; });
    };
    sort();
    std::vector<std::pair<Idea, double>> best;
    for (std::size_t i = 0; i < std::min(kRefined, terms_.size()); ++i)
      best.emplace_back(terms_[i].idea, terms_[i].shape);
    for (const auto& [idea, shape] : best) refine(idea, shape);
    sort();
  }

  const Parts& p_;
  Judge judge_;
  Thin thin_;
  std::vector<Idea> ideas_;
  std::vector<Term> terms_;
};

std::vector<Term> LawSearch::next(const SensorSearch& base) { return Round(*parts_, base).run(); }

std::vector<Found> effects_of(const Term& term, Sensor sensor, const std::shared_ptr<const laws::Columns>& drivers) {
  std::vector<Found> out;
  const laws::Signature signature = signature_of(*drivers);
  std::size_t next = 0;
  for (std::size_t part = 0; part < term.idea.texts.size(); ++part) {
    const std::string text = term.idea.text(part, term.shape);
    const auto tree = laws::parse(text, signature);
    if (!tree) continue;
    Found f = term.found;
    const std::size_t count = term.found.columns.size() / term.idea.texts.size();
    f.columns.assign(term.found.columns.begin() + static_cast<std::ptrdiff_t>(next),
                     term.found.columns.begin() + static_cast<std::ptrdiff_t>(next + count));
    next += count;
    f.id = "unknown:" + text;
    f.equation = "delta = k " + text;
    f.driver = text;
    f.names = count == 9
                  ? std::vector<std::string>{"k_xx", "k_xy", "k_xz", "k_yx", "k_yy", "k_yz", "k_zx", "k_zy", "k_zz"}
                  : std::vector<std::string>{"k_x", "k_y", "k_z"};
    const std::string of = laws::text(tree->unit);
    f.unit = of == "1" ? std::string(kSensorUnit[sensor]) : std::string(kSensorUnit[sensor]) + " per " + of;
    f.units.assign(count, f.unit);
    if (!term.idea.shape_name.empty()) {
      f.shape_name = term.idea.shape_name;
      f.shape_unit = term.idea.shape_unit;
      if (f.shape_name == "tau")
        f.at_shape = [idea = term.idea, part, drivers, signature](double shape) {
          const auto at = laws::parse(idea.text(part, shape), signature);
          return columns_of_value(laws::evaluate(*at, *drivers), idea.matrix);
        };
    }
    out.push_back(std::move(f));
  }
  return out;
}

}  // namespace stillpoint::diag
