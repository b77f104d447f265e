#include "diagnosis/reference/judge.h"

#include <algorithm>

namespace stillpoint::diag {
namespace {

constexpr double kWalkWorthwhile = 2.0;
constexpr double kNatsForTheProduct = 1.5;  // there are four times as many products as laws

}  // namespace

Judge::Judge(const SensorSearch& search)
    : plain_(search.target), beside_walk_(search.beside_walk()), explained_(search.explained()) {
  null_ = fit_profile(plain_, explained_).log_likelihood;
  const double with_walk = fit_profile(beside_walk_, explained_).log_likelihood;
  walking_ = with_walk > null_ + kWalkWorthwhile;
  if (search.walk_is_given) walk_freedom_ = 0.0;
  null_ = std::max(null_, with_walk - walk_freedom_);
}

void Judge::weigh(Found& f) const {
  const bool shifted = f.offset.size() > 0;
  const Columns columns = shifted ? explained_ : joined(explained_, f.columns);
  const auto likelihood = [&](Target t) {
    if (shifted) t.residual -= f.offset;
    return fit_profile(t, columns).log_likelihood;
  };
  double best = likelihood(plain_);
  if (walking_) best = std::max(best, likelihood(beside_walk_) - walk_freedom_);
  f.gain_nats = best - null_;
  f.net_nats = f.gain_nats - charge(f.names.size(), f.window);
  if (f.kind == Kind::kUnknown && f.form_of.empty()) f.net_nats -= kNatsForTheProduct;
}

}  // namespace stillpoint::diag
