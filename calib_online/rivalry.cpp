#include "calib_online/rivalry.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace stillpoint::calib {
namespace {

constexpr double kApart = 0.92;         // cosine of 23 degrees
constexpr double kAtFirst = -2.0;       // log odds of a rival that was just opened
constexpr double kMostOfOne = 4.0;      // of one attitude for the rival, nats
constexpr double kMostAgainst = -4.0;   // the same against it, where it predicts as sharply
constexpr double kVagueAgainst = -2.0;  // where it does not yet
constexpr double kVague = 9.0;          // times the other's variance
constexpr double kWon = 6.0, kLost = -7.0, kFormerLost = -12.0;
constexpr double kRefused = 9.0;  // chi-square: the published one does not explain this attitude

}  // namespace

bool Attitudes::add(const Vec3& up_body) noexcept {
  for (std::uint32_t k = 0; k < count; ++k)
    if (vec(up[k]).dot(up_body) > kApart) return false;
  if (count == kMost) return false;
  up[count++] = array(up_body);
  return true;
}

void Rivalry::open(const Vec3& up_body) noexcept {
  s_ = State{};
  s_.open = 1;
  s_.log_odds = kAtFirst;
  s_.voted.add(up_body);
}

double Rivalry::vote(const Fit& published, const Fit& rival) noexcept {
  const double vote = 0.5 * (published.chi2 + published.log_variance - rival.chi2 - rival.log_variance);
  const bool vague = rival.variance > kVague * published.variance;
  if (published.chi2 < kRefused) return std::clamp(vote, vague ? kVagueAgainst : kMostAgainst, kMostOfOne);
  // Refused by the published one is not yet explained by the rival: only a prediction sharper than the error counts.
  const bool sharp = rival.variance < 0.25 * published.chi2 * published.variance;
  return std::clamp(vote, kMostAgainst, sharp ? kMostOfOne : 0.0);
}

void Rivalry::add_vote(double vote, const Vec3& up_body) noexcept {
  s_.log_odds = std::clamp(s_.log_odds + vote, -15.0, 15.0);
  s_.voted.add(up_body);
}

Rivalry::Verdict Rivalry::verdict(std::uint32_t attitudes_needed) const noexcept {
  if (s_.open == 0) return Verdict::kOpen;
  if (s_.log_odds > kWon && s_.voted.count >= attitudes_needed) return Verdict::kRivalWins;
  if (s_.log_odds < (s_.former != 0 ? kFormerLost : kLost)) return Verdict::kPublishedStays;
  return Verdict::kOpen;
}

void Rivalry::exchanged() noexcept {
  s_.log_odds = -s_.log_odds;
  s_.former = 1;
}

double Rivalry::weight(double pending) const noexcept {
  if (s_.open == 0) return 0.0;
  const double p = 1.0 / (1.0 + std::exp(-s_.log_odds - pending));
  return p < 0.02 ? 0.0 : p;
}

}  // namespace stillpoint::calib
