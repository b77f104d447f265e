/// The tables of the proof.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "diagnosis/prove/prove.h"

#include "core/median.h"

namespace stillpoint::diag {
namespace {

using Scores = std::vector<CaseScore>;
using Test = std::function<bool(const CaseScore&)>;

struct Rate {
  std::size_t hits = 0, n = 0;
};

Rate rate(const Scores& scores, const Test& counts, const Test& hit) {
  Rate r;
  for (const auto& s : scores)
    if (counts(s)) ++r.n, r.hits += hit(s);
  return r;
}

std::string in_words(const Rate& r) {
  const auto ci = wilson95(r.hits, r.n);
  return r.n == 0
             ? "none drawn"
             : fmt::format("{:4} of {:4}  {:5.1f} %  ({:.1f} to {:.1f})", r.hits, r.n,
                           100.0 * static_cast<double>(r.hits) / static_cast<double>(r.n), 100 * ci[0], 100 * ci[1]);
}

bool clean(const CaseScore& s) { return s.truth.kind == "clean"; }
bool alarm(const CaseScore& s) { return !s.said.empty() || s.outcome == "unknown"; }
bool one_effect(const CaseScore& s) {
  return s.truth.kind == "single" || s.truth.kind == "window" || s.truth.kind == "confound" ||
         s.truth.kind == "cfgerr" || s.truth.kind == "oneaxis";
}
bool right(const CaseScore& s) { return s.outcome == "right"; }

struct Line {
  std::string what;
  Rate rate;
};

std::vector<Line> rates(const Scores& scores) {
  const auto kind = [](std::string k) { return [k = std::move(k)](const CaseScore& s) { return s.truth.kind == k; }; };
  const auto named = [](const CaseScore& s) { return !s.said.empty() && s.truth.kind != "deleted"; };
  const auto reference = [](Test t, std::string r) {
    return [t = std::move(t), r = std::move(r)](const CaseScore& s) { return t(s) && s.truth.reference == r; };
  };
  return {{"false alarms on clean recordings", rate(scores, clean, alarm)},
          {"one effect, named right, exact reference", rate(scores, reference(one_effect, "exact"), right)},
          {"one effect, named right, mocap reference", rate(scores, reference(one_effect, "mocap"), right)},
          {"local in time, named right", rate(scores, kind("window"), right)},
          {"confounded driver, named right", rate(scores, kind("confound"), right)},
          {"two effects, both named", rate(scores, kind("pair"), [](const CaseScore& s) { return s.both; })},
          {"outside the library, called unknown",
           rate(scores, kind("novel"), [](const CaseScore& s) { return s.outcome == "unknown"; })},
          {"driver removed, nothing blamed",
           rate(
               scores, [](const CaseScore& s) { return s.truth.kind == "notemp" || s.truth.kind == "noaux"; },
               [](const CaseScore& s) { return s.untrue == 0; })},
          {"absorbed by an estimator, right or unknown",
           rate(scores, kind("absorb"), [](const CaseScore& s) { return s.untrue == 0 && !s.said.empty(); })},
          {"law deleted from the library, another law stated",
           rate(scores, kind("deleted"),
                [](const CaseScore& s) { return !s.said.empty() && !s.said.front().starts_with("unknown"); })},
          {"no reference, named right", rate(scores, kind("noref"), right)},
          {"first finding untrue, of answers that name",
           rate(scores, named, [](const CaseScore& s) { return s.outcome == "wrong"; })},
          {"any finding untrue, of answers that name",
           rate(scores, named, [](const CaseScore& s) { return s.untrue > 0; })},
          {"solver failed", rate(
                                scores, [](const CaseScore&) { return true; },
                                [](const CaseScore& s) { return s.outcome == "failed"; })}};
}

std::string outcomes(const Scores& scores) {
  static const std::vector<std::string> columns{"right", "family", "unknown", "config", "missed", "wrong", "failed"};
  std::set<std::pair<std::string, std::string>> kinds;
  for (const auto& s : scores) kinds.insert({s.truth.kind, s.truth.reference});
  std::string text = fmt::format("{:9} {:6} {:>5}", "kind", "ref", "n");
  for (const auto& c : columns) text += fmt::format(" {:>7}", c);
  for (const auto& [kind, reference] : kinds) {
    const auto here = [&kind = kind, &reference = reference](const CaseScore& s) {
      return s.truth.kind == kind && s.truth.reference == reference;
    };
    text += fmt::format("\n{:9} {:6} {:5}", kind, reference, std::count_if(scores.begin(), scores.end(), here));
    for (const auto& c : columns)
      text += fmt::format(" {:7}", std::count_if(scores.begin(), scores.end(),
                                                 [&](const CaseScore& s) { return here(s) && s.outcome == c; }));
  }
  return text + "\n";
}

std::string by_noise(const Scores& scores) {
  std::set<std::pair<std::string, std::string>> kinds;
  for (const auto& s : scores)
    if (clean(s)) kinds.insert({s.truth.noise, s.truth.reference});
  std::string text;
  for (const auto& [noise, reference] : kinds)
    text += fmt::format("  {:9} {:6} {}\n", noise, reference,
                        in_words(rate(
                            scores,
                            [&, &noise = noise, &reference = reference](const CaseScore& s) {
                              return clean(s) && s.truth.noise == noise && s.truth.reference == reference;
                            },
                            alarm)));
  return text;
}

std::string by_strength(const Scores& scores) {
  static const std::vector<double> edges{0, 10, 20, 40, 80, 160, HUGE_VAL};
  std::string text;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const auto r = rate(
        scores,
        [&](const CaseScore& s) {
          return one_effect(s) && s.truth.d_prime > edges[i] && s.truth.d_prime <= edges[i + 1];
        },
        right);
    if (r.n > 0) text += fmt::format("  d' {:>4} to {:<5} {}\n", edges[i], edges[i + 1], in_words(r));
  }
  return text;
}

std::string confusion(const Scores& scores) {
  std::map<std::pair<std::string, std::string>, int> count;
  for (const auto& s : scores) {
    if (s.truth.effects.size() != 1 || s.outcome == "right") continue;
    ++count[{s.truth.effects.begin()->first, s.said.empty() ? "(" + s.outcome + ")" : s.said.front()}];
  }
  std::string text;
  for (const auto& [pair, n] : count) text += fmt::format("  {:16} -> {:28} {}\n", pair.first, pair.second, n);
  return text.empty() ? "  none\n" : text;
}

std::string misses(const Scores& scores) {
  std::string text;
  for (const auto& s : scores) {
    const bool miss = s.untrue > 0 || s.outcome == "wrong" || s.outcome == "failed" ||
                      (clean(s) ? alarm(s) : s.outcome == "missed" || s.outcome == "config");
    if (!miss) continue;
    std::string truth, said;
    for (const auto& [id, parameters] : s.truth.effects) truth += " " + id;
    for (const auto& x : s.said) said += " " + x;
    text += fmt::format("  {} {} {} d' {:.0f}: true{}; said{}\n", s.id, s.truth.kind, s.truth.reference,
                        s.truth.d_prime, truth.empty() ? " nothing" : truth, said.empty() ? " nothing" : said);
  }
  return text.empty() ? "  none\n" : text;
}

struct Sums {
  Rate coverage;
  std::map<std::string, Rate> coverage_by_effect;
  std::vector<double> removed, overlap;
};
Sums sums(const Scores& scores) {
  Sums s;
  for (const auto& c : scores) {
    for (const auto& [effect, here] : c.coverage)
      for (Rate* r : {&s.coverage, &s.coverage_by_effect[effect]}) r->hits += here.inside, r->n += here.stated;
    if (c.removed) s.removed.push_back(*c.removed);
    if (c.truth.kind == "window" && c.outcome == "right") s.overlap.push_back(c.overlap);
  }
  return s;
}

}  // namespace

std::string tables(const Scores& scores) {
  std::string text =
      fmt::format("{} cases, none dropped; intervals are 95 % (Wilson)\n\n", scores.size()) + outcomes(scores) + "\n";
  for (const auto& line : rates(scores)) text += fmt::format("{:46} {}\n", line.what, in_words(line.rate));
  const Sums s = sums(scores);
  text += fmt::format("{:46} {}\n", "true numbers inside their 95 % interval", in_words(s.coverage));
  if (!s.removed.empty())
    text += fmt::format("{:46} median {:.1f} %, least {:.1f} % ({} findings)\n", "removable error removed, held out",
                        100 * median(s.removed), 100 * *std::min_element(s.removed.begin(), s.removed.end()),
                        s.removed.size());
  if (!s.overlap.empty())
    text += fmt::format("{:46} median {:.2f} ({} windows)\n", "overlap with the true window", median(s.overlap),
                        s.overlap.size());
  text += "\nFalse alarms by noise and reference\n" + by_noise(scores);
  text += "\nOne effect named right, by size (d': norm of the effect over the noise, H and B projected out)\n" +
          by_strength(scores);
  text += "\nTrue numbers inside their 95 % interval, by effect\n";
  for (const auto& [effect, coverage] : s.coverage_by_effect)
    if (coverage.n > 0) text += fmt::format("  {:16} {}\n", effect, in_words(coverage));
  text += "\nConfusion (true -> first finding, where it was not right)\n" + confusion(scores);
  text += "\nEvery case with an untrue name, a false alarm or a miss\n" + misses(scores);
  return text;
}

nlohmann::json summary(const Scores& scores) {
  nlohmann::json j{{"cases", scores.size()}};
  for (const auto& line : rates(scores))
    j["rates"][line.what] = {
        {"hits", line.rate.hits}, {"n", line.rate.n}, {"ci95", wilson95(line.rate.hits, line.rate.n)}};
  const Sums s = sums(scores);
  j["rates"]["coverage"] = {
      {"hits", s.coverage.hits}, {"n", s.coverage.n}, {"ci95", wilson95(s.coverage.hits, s.coverage.n)}};
  return j;
}

}  // namespace stillpoint::diag
