#include "simulation/reference_noise.h"

#include <array>
#include <cmath>
#include <limits>

#include "core/units.h"

namespace stillpoint::sim {
namespace {

constexpr std::size_t kPiece = 128, kTones = kPiece / 2;
/// Motion is taken to be there where the spectrum stands this far above the noise; the mean of few pieces scatters.
constexpr double kClear = 1.5;

struct Tables {
  std::array<double, kPiece> window{}, cosine{}, sine{};
  Tables() {
    for (std::size_t i = 0; i < kPiece; ++i) {
      const double turn = kTwoPi * static_cast<double>(i) / kPiece;
      cosine[i] = std::cos(turn);
      sine[i] = std::sin(turn);
      window[i] = 0.5 - 0.5 * cosine[i];
    }
  }
};

/// Mean power by frequency of Hann-windowed pieces, half overlapping, each freed of the line through its ends' means.
class Spectrum {
 public:
  template <int Columns>
  void add(const CurveSamples<Columns>& s, std::size_t first, std::size_t last, double step_s) {
    for (std::size_t start = first; start + kPiece <= last + 1; start += kPiece / 2) {
      const double length_s = s.t_s[start + kPiece - 1] - s.t_s[start];
      if (length_s > (kPiece + 1) * step_s) continue;  // a gap
      for (int c = 0; c < Columns; ++c) add_piece([&](std::size_t i) { return s.value[start + i][c]; });
      ++pieces_;
    }
  }
  [[nodiscard]] std::size_t pieces() const { return pieces_; }
  [[nodiscard]] double power(std::size_t tone) const { return power_[tone] / static_cast<double>(pieces_); }

 private:
  template <class At>
  void add_piece(const At& at) {
    static const Tables tables;
    constexpr std::size_t kEnd = kPiece / 8;
    double before = 0.0, after = 0.0;
    for (std::size_t i = 0; i < kEnd; ++i) before += at(i) / kEnd, after += at(kPiece - 1 - i) / kEnd;
    std::array<double, kPiece> x{};
    for (std::size_t i = 0; i < kPiece; ++i) {
      const double share = (static_cast<double>(i) - 0.5 * (kEnd - 1)) / (kPiece - kEnd);
      x[i] = tables.window[i] * (at(i) - before - share * (after - before));
    }
    for (std::size_t k = 1; k < kTones; ++k) {
      double re = 0.0, im = 0.0;
      for (std::size_t i = 0; i < kPiece; ++i) {
        re += x[i] * tables.cosine[i * k % kPiece];
        im += x[i] * tables.sine[i * k % kPiece];
      }
      power_[k] += re * re + im * im;
    }
  }

  std::array<double, kTones> power_{};
  std::size_t pieces_ = 0;
};

}  // namespace

template <int Columns>
double penalty_against_noise(const CurveSamples<Columns>& s, const std::vector<Span>& rests, double step_s,
                             int derivative) {
  Spectrum rest, motion;
  std::size_t since = 0;
  for (const auto& [first, last] : rests) {
    rest.add(s, first, last, step_s);
    if (first > since) motion.add(s, since, first - 1, step_s);
    since = last + 1;
  }
  if (since < s.t_s.size()) motion.add(s, since, s.t_s.size() - 1, step_s);
  if (rest.pieces() < 2 || motion.pieces() == 0) return 0.0;
  double least = std::numeric_limits<double>::max(), chosen = 0.0;
  for (const double penalty : spline_penalties()) {
    double error = 0.0;
    for (std::size_t k = 1; k < kTones; ++k) {
      const double noise = rest.power(k), both = motion.power(k);
      const double signal = both > kClear * noise ? both - noise : 0.0;
      const double frequency = static_cast<double>(k) / kPiece, gain = spline_gain(frequency, penalty);
      error += std::pow(frequency, 2 * derivative) * (gain * gain * noise + (1.0 - gain) * (1.0 - gain) * signal);
    }
    if (error >= least) continue;
    least = error;
    chosen = penalty;
  }
  return chosen;
}

template double penalty_against_noise(const CurveSamples<3>&, const std::vector<Span>&, double, int);
template double penalty_against_noise(const CurveSamples<4>&, const std::vector<Span>&, double, int);

}  // namespace stillpoint::sim
