#include <algorithm>

#include "bench/portfolio_sets.h"
#include "core/units.h"

namespace stillpoint::bench {
namespace {

constexpr std::size_t kGaps = 10;
constexpr std::int64_t kAfter_ns = 5'000'000'000;

/// The series without the rows of its gaps; where each ends.
struct Cut {
  Series series;
  std::vector<std::int64_t> ends_ns;
};

Cut cut(const Series& whole, double gap_s) {
  Cut out{whole, {}};
  const auto half_ns = static_cast<std::int64_t>(0.5 * gap_s * kNsPerSecond);
  const std::size_t length = whole.rows.size() / kGaps;
  for (std::size_t g = 0; g < kGaps; ++g) {
    // In the middle third of its tenth, so that what follows a gap is over before the next.
    const auto begin = whole.rows.begin() + static_cast<std::ptrdiff_t>(g * length + length / 3);
    const auto fastest = std::max_element(begin, begin + static_cast<std::ptrdiff_t>(length / 3),
                                          [](const RawSample& a, const RawSample& b) {
                                            return vec(a.gyr_radps).squaredNorm() < vec(b.gyr_radps).squaredNorm();
                                          });
    const std::int64_t middle_ns = fastest->t_ns;
    std::erase_if(out.series.rows, [=](const RawSample& s) { return std::abs(s.t_ns - middle_ns) < half_ns; });
    out.ends_ns.push_back(middle_ns + half_ns);
  }
  return out;
}

Tally alone(const Truth& truth, const pipeline::Processed& estimate) {
  Tally one;
  one.add({truth.t_ns, truth.q_world_body, true}, estimate);
  return one;
}

/// Walks through the truths after each gap.
class AfterGaps {
 public:
  AfterGaps(const std::vector<std::int64_t>& ends_ns, GapFigures& sum) : ends_ns_(ends_ns), sum_(sum) {}

  void operator()(const Truth& truth, const pipeline::Processed& estimate) {
    if (gap_ < ends_ns_.size() && truth.t_ns > ends_ns_[gap_] + kAfter_ns) {
      sum_.inclination_after_deg += alone(truth, estimate).inclination_deg();
      ++gap_;
      begun_ = false;
    }
    if (gap_ >= ends_ns_.size() || estimate.attitude.t_ns < ends_ns_[gap_]) return;
    if (!begun_) {
      const Tally now = alone(truth, estimate);
      sum_.inclination_then_deg += now.inclination_deg();
      sum_.total_then_deg += now.total_deg();
      ++sum_.gaps;
      begun_ = true;
    }
    tally_.add(truth, estimate);
  }
  [[nodiscard]] const Tally& tally() const { return tally_; }

 private:
  const std::vector<std::int64_t>& ends_ns_;
  GapFigures& sum_;
  Tally tally_;
  std::size_t gap_ = 0;
  bool begun_ = false;
};

}  // namespace

GapFigures gap_figures(const PortfolioSet& broad, const pipeline::StagesParams& params, double gap_s, Way way) {
  GapFigures sum;
  double judged = 0.0;
  for (const Series& whole : broad.series) {
    const Cut gaps = cut(whole, gap_s);
    AfterGaps after(gaps.ends_ns, sum);
    run_series(gaps.series, params, way, [&](const Truth& t, const pipeline::Processed& p) { after(t, p); });
    const auto n = static_cast<double>(after.tally().judged());
    sum.inside += n * std::min(after.tally().tilt_inside(), after.tally().heading_inside());
    sum.ok_outside += n * after.tally().ok_outside();
    judged += n;
  }
  const double n = std::max<double>(1.0, static_cast<double>(sum.gaps));
  sum.inclination_then_deg /= n;
  sum.total_then_deg /= n;
  sum.inclination_after_deg /= n;
  sum.inside /= std::max(judged, 1.0);
  sum.ok_outside /= std::max(judged, 1.0);
  return sum;
}

}  // namespace stillpoint::bench
