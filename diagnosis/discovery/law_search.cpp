#include "diagnosis/discovery/law_search.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/discovery/drivers.h"
#include "diagnosis/discovery/extensions.h"
#include "diagnosis/discovery/open_numbers.h"
#include "diagnosis/discovery/table_term.h"
#include "diagnosis/discovery/thinned.h"
#include "diagnosis/reference/golden_section.h"
#include "diagnosis/reference/judge.h"

namespace stillpoint::diag {
namespace {

constexpr double kRows = 6000.0, kFewRows = 2500.0;  // looked at, of the first level and of the wider one
constexpr std::size_t kShort = 5;                    // of each noise, to be judged
constexpr std::size_t kShortToSee = 2;               // the same, to see whether there is anything to look for
constexpr std::size_t kFinalists = 4;                // times those whose number is sought more closely before
constexpr int kHalvings = 3;                         // of the grid's step, then
constexpr std::size_t kShortFurther = 2, kBeam = 3;  // judged of each noise a step further; texts that are taken there
constexpr std::size_t kMostSteps = 4;
constexpr double kWorthExtending = 0.3;  // of the best one's net gain
constexpr double kShareOfAStep = 0.01;   // of the gain: what is more complicated has to explain more than that
constexpr std::size_t kRefined = 3;      // of those, whose number is sought between the points of its grid
constexpr double kNatsACoefficient = 2.0;
constexpr double kNatsAShape = 3.0;  // the choice of an open number
constexpr int kSections = 10;

struct Look {
  std::size_t idea = 0;
  double shape = 0.0, gain = -1.0, net = -1.0;
};

}  // namespace

struct LawSearch::Parts {
  const Signals& s;
  Sensor sensor;
  std::shared_ptr<const laws::Columns> shared;
  const laws::Columns& full;
  Rows slow, few;
  laws::Signature signature;
  std::vector<Idea> ideas, wider, of_lines, events;

  Parts(const Signals& signals, Sensor k, std::span<const double> lines_hz, std::span<const double> moments_s)
      : s(signals),
        sensor(k),
        shared(std::make_shared<const laws::Columns>(drivers_of_rows(s))),
        full(*shared),
        slow(s, full, kRows),
        few(s, full, kFewRows),
        signature(signature_of(full)),
        ideas(first_ideas(sensor, slow.drivers)),
        wider(wider_ideas(slow.drivers)),
        of_lines(line_ideas(full, lines_hz)),
        events(event_ideas(sensor, moments_s)) {}

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
  [[nodiscard]] std::vector<Look> look(const Idea& idea, std::size_t index, const laws::Columns& drivers,
                                       std::span<const TermScan> scans) const {
    std::vector<Look> best(scans.size(), Look{index});
    for (const double shape : idea.shapes) {
      std::vector<double> gain(scans.size(), 0.0);
      double price = idea.shapes.size() > 1 ? kNatsAShape : 0.0;
      bool good = true;
      for (std::size_t part = 0; part < idea.texts.size() && good; ++part) {
        const auto v = value(idea.text(part, shape), drivers);
        good = v.has_value();
        if (!good) break;
        const Columns columns = columns_of(idea, v->x);
        for (std::size_t i = 0; i < scans.size(); ++i) gain[i] += scans[i].gain(columns);
        price += kNatsABit * v->bits + kNatsACoefficient * static_cast<double>(columns.size());
      }
      for (std::size_t i = 0; i < scans.size() && good; ++i)
        if (gain[i] - price > best[i].net) best[i] = {index, shape, gain[i], gain[i] - price};
    }
    return best;
  }

  /// Its numbers between the points of its grid, next to where it says most: what is right but for a coarse number
  /// must not lose to what is not.
  void look_closer(const Idea& idea, std::vector<Look>& looks, const laws::Columns& drivers,
                   std::span<const TermScan> scans) const {
    const auto most = [](const std::vector<Look>& all) {
      return *std::max_element(all.begin(), all.end(), [](const Look& a, const Look& b) { return a.net < b.net; });
    };
    double at = most(looks).shape;
    const auto there = std::find(idea.shapes.begin(), idea.shapes.end(), at);
    double low = there == idea.shapes.begin() ? at : *std::prev(there);
    double high = std::next(there) == idea.shapes.end() ? at : *std::next(there);
    Idea closer = idea;
    for (int i = 0; i < kHalvings && low < high; ++i) {
      closer.shapes = {0.5 * (low + at), 0.5 * (at + high)};
      const std::vector<Look> seen = look(closer, looks.front().idea, drivers, scans);
      for (std::size_t k = 0; k < looks.size(); ++k)
        if (seen[k].net > looks[k].net) looks[k] = seen[k];
      const double best = most(looks).shape;
      low = best < at ? low : best > at ? at : closer.shapes[0];
      high = best > at ? high : best < at ? at : closer.shapes[1];
      at = best;
    }
  }

  [[nodiscard]] std::optional<Term> term(const Idea& idea, double shape, const laws::Columns& drivers) const {
    Term out{idea, shape, 0.0, {}};
    Found& f = out.found;
    for (std::size_t part = 0; part < idea.texts.size(); ++part) {
      const auto v = value(idea.text(part, shape), drivers);
      if (!v) return std::nullopt;
      out.bits += v->bits;
      f.columns = joined(std::move(f.columns), columns_of(idea, v->x));
    }
    const std::string text = idea.text(0, shape);
    f.id = "unknown:" + (idea.points.empty() ? text : table_text(text));
    f.kind = Kind::kUnknown;
    f.shape = shape;
    f.names.assign(f.columns.size(), "k");
    return out;
  }

  [[nodiscard]] std::vector<Look> best(const std::vector<Idea>& all, std::size_t from, std::size_t count,
                                       const Rows& rows, std::span<const TermScan> noises) const;

  [[nodiscard]] double net_of(const Term& t) const {
    const double kept =
        1.0 - kShareOfAStep * static_cast<double>(t.idea.steps) - (t.idea.points.empty() ? 0.0 : kShareOfATable);
    return kept * t.found.gain_nats - charge(t.found.columns.size(), {}) - kNatsABit * t.bits -
           kNatsAShape * static_cast<double>(open_numbers(t.idea.text(0, t.shape)).size());
  }
};

LawSearch::LawSearch(const Signals& s, Sensor sensor, std::span<const double> lines_hz,
                     std::span<const double> moments_s)
    : parts_(std::make_unique<Parts>(s, sensor, lines_hz, moments_s)) {}
LawSearch::~LawSearch() = default;
const std::shared_ptr<const laws::Columns>& LawSearch::drivers() const { return parts_->shared; }

namespace {

void keep_best(std::vector<Look>& all, std::size_t count) {
  std::sort(all.begin(), all.end(), [](const Look& a, const Look& b) { return a.net > b.net; });
  if (all.size() > count) all.resize(count);
  std::erase_if(all, [](const Look& l) { return l.net <= 0; });
}

}  // namespace

/// The best so many of the ideas under each noise, each once.
std::vector<Look> LawSearch::Parts::best(const std::vector<Idea>& all, std::size_t from, std::size_t count,
                                         const Rows& rows, std::span<const TermScan> noises) const {
  std::vector<std::vector<Look>> looks;
  for (std::size_t i = from; i < all.size(); ++i) looks.push_back(look(all[i], i, rows.drivers, noises));
  const auto best_under = [&looks](std::size_t noise, std::size_t most) {
    std::vector<Look> list;
    for (const auto& of_idea : looks) list.push_back(of_idea[noise]);
    keep_best(list, most);
    return list;
  };
  std::set<std::size_t> finalists;
  for (std::size_t k = 0; k < noises.size(); ++k)
    for (const Look& l : best_under(k, kFinalists * count)) finalists.insert(l.idea);
  for (const std::size_t i : finalists)
    if (all[i].shapes.size() > 1) look_closer(all[i], looks[i - from], rows.drivers, noises);
  std::vector<Look> out;
  for (std::size_t k = 0; k < noises.size(); ++k) {
    const std::vector<Look> list = best_under(k, count);
    for (const Look& l : list) {
      const auto same = [&l](const Look& o) { return o.idea == l.idea && o.shape == l.shape; };
      if (std::none_of(out.begin(), out.end(), same)) out.push_back(l);
    }
  }
  return out;
}

double LawSearch::most(const SensorSearch& base) {
  const Parts& p = *parts_;
  const Thin thin(p.s, base, p.few.factor, true);
  const double without = fit_profile(thin.null, thin.explained).log_likelihood;
  double out = 0.0;
  for (const auto* ideas : {&p.ideas, &p.wider, &p.events})
    for (const Look& l : p.best(*ideas, 0, kShortToSee, p.few, thin.without_null()))
      if (const auto t = p.term((*ideas)[l.idea], l.shape, p.few.drivers))
        out = std::max(out, fit_profile(thin.null, joined(thin.explained, t->found.columns)).log_likelihood - without);
  return out;
}

/// One round: short lists, refined, then what the best could be a part of.
class LawSearch::Round {
 public:
  Round(const Parts& parts, const SensorSearch& base)
      : p_(parts), base_(base), judge_(base), thin_(parts.s, base, parts.slow.factor, judge_.walking()) {}

  std::vector<Term> of_all() {
    first_level();
    settle_numbers();  // a further factor would make up for a number that is off
    for (std::size_t step = 0; step < kMostSteps && further(); ++step) settle_numbers();
    while (settle_numbers()) continue;
    const std::size_t formulas = ideas_.size();
    for (Idea& idea : table_ideas(p_.slow.drivers)) ideas_.push_back(std::move(idea));
    shortlist(formulas, 1);
    return those_that_pay();
  }

  /// No step further: what settles is among them, and further factors would follow one motion.
  std::vector<Term> of_events() {
    for (const Look& l : p_.best(p_.events, 0, kShort, p_.slow, thin_.all)) judge(p_.events[l.idea], l.shape);
    return those_that_pay();
  }

 private:
  std::vector<Term> those_that_pay() {
    refine_best();
    std::erase_if(terms_, [](const Term& t) { return t.found.net_nats <= 0; });
    return std::move(terms_);
  }

  static std::string name_of(const Idea& idea, const std::string& text) {
    return text + (idea.matrix ? " matrix" : idea.points.empty() ? "" : " table");
  }

  void judge(const Idea& idea, double shape) {
    auto t = p_.term(idea, shape, p_.full);
    if (!t || !judged_.insert(name_of(idea, idea.text(0, shape))).second) return;
    judge_.weigh(t->found);
    t->found.net_nats = p_.net_of(*t);
    terms_.push_back(std::move(*t));
  }

  /// The best of the ideas from one on, under each noise, judged on all rows.
  void shortlist(std::size_t from, std::size_t count) {
    for (const Look& l : p_.best(ideas_, from, count, p_.slow, thin_.all)) judge(ideas_[l.idea], l.shape);
  }

  /// The wider ones on fewer rows: there are more of them, and none is as fast as a sensor.
  void first_level() {
    for (const Look& l : p_.best(p_.ideas, 0, kShort, p_.slow, thin_.all)) judge(p_.ideas[l.idea], l.shape);
    const Thin thin(p_.s, base_, p_.few.factor, judge_.walking());
    for (const Look& l : p_.best(p_.wider, 0, kShort, p_.few, thin.without_null())) judge(p_.wider[l.idea], l.shape);
    for (const Idea& idea : p_.of_lines) judge(idea, idea.shapes.front());  // which thinned rows may not hold
    refine_best();
  }

  /// One step from the best that were not taken further yet; false where that leads nowhere.
  bool further() {
    if (terms_.empty()) return false;
    const double before = terms_.front().found.net_nats;
    std::vector<std::pair<Idea, double>> taken;
    const auto take = [&](const Term& t) {
      if (extended_.insert(name_of(t.idea, t.idea.texts.front())).second) taken.emplace_back(t.idea, t.shape);
    };
    const auto worth_it = [&](const Term& t) { return t.found.net_nats >= kWorthExtending * before; };
    for (const Term& t : terms_)
      if (taken.size() < kBeam && worth_it(t)) take(t);
    // The best event as well: what settles after it follows a slow driver more closely than the event does.
    const auto event =
        std::find_if(terms_.begin(), terms_.end(), [](const Term& t) { return t.idea.shape_name == "at"; });
    if (event != terms_.end() && worth_it(*event)) take(*event);
    // A list for each: what stands beside the true law in this motion has as many neighbours, and they are as good.
    for (const auto& [idea, shape] : taken) {
      const std::size_t from = ideas_.size();
      for (Idea& next : extensions(idea, shape, p_.slow.drivers)) ideas_.push_back(std::move(next));
      shortlist(from, kShortFurther);
    }
    refine_best();
    return terms_.front().found.net_nats > before;
  }

  /// Every number of the best looked for anew beside the others; false where none of them moves.
  bool settle_numbers() {
    if (terms_.empty()) return false;
    const double before = terms_.front().found.net_nats;
    for (Idea& idea : reopened(terms_.front().idea, terms_.front().shape)) {
      ideas_.push_back(std::move(idea));
      shortlist(ideas_.size() - 1, 1);
      refine_best();
    }
    return terms_.front().found.net_nats > before + kNatsAShape;
  }

  /// The open number between the points of its grid, by golden section on the thinned rows.
  void refine(const Idea& idea, double coarse) {
    const auto& grid = idea.shapes;
    const auto there = p_.term(idea, coarse, p_.slow.drivers);
    if (idea.shape_name.empty() || grid.size() < 2 || !there) return;
    const auto at = std::lower_bound(grid.begin(), grid.end(), coarse);
    const double low = at == grid.begin() ? grid[0] - 0.4 * (grid[1] - grid[0]) : *std::prev(at);
    const double high = at == grid.end() || std::next(at) == grid.end() ? coarse * 1.5 : *std::next(at);
    const auto with = [this](const Term& t) { return joined(thin_.explained, t.found.columns); };
    const NoiseModel noise(thin_.target.layout, fit_profile(thin_.target, with(*there)).leftover);
    const auto likelihood = [&](double shape) {
      const auto t = p_.term(idea, shape, p_.slow.drivers);
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
    for (const auto& [idea, shape] : best)
      if (refined_.insert(name_of(idea, idea.texts.front())).second) refine(idea, shape);
    sort();
  }

  const Parts& p_;
  const SensorSearch& base_;
  Judge judge_;
  Thin thin_;
  std::vector<Idea> ideas_;  ///< of the steps
  std::vector<Term> terms_;
  std::set<std::string> judged_, extended_, refined_;  ///< by text and coupling
};

std::vector<Term> LawSearch::next(const SensorSearch& base) { return Round(*parts_, base).of_all(); }
std::vector<Term> LawSearch::next_event(const SensorSearch& base) { return Round(*parts_, base).of_events(); }

}  // namespace stillpoint::diag
