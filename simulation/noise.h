/// Noise of one triad with the terms of an Allan deviation plot: white or band-limited noise, bias instability, random
/// walk. After IEEE Std 952-1997, annex C.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "simulation/config.h"
#include "simulation/random.h"

namespace stillpoint::sim {

/// x_(k+1) = keep x_k + drive w_k with white w of unit variance, x_0 of standard deviation `start`: what every coloured
/// noise here is made of.
struct GaussMarkov {
  double keep, drive, start;
};

/// The noise of one axis: white of standard deviation `white`, and these processes added to it, one step a row.
struct NoiseModel {
  double white = 0.0;
  std::vector<GaussMarkov> processes;
};

/// What TriadNoise draws, as a model to whiten with.
[[nodiscard]] NoiseModel noise_model(const TriadConfig& config, int axis, double step_s);

/// 1/f noise as a sum of Gauss-Markov processes of equal variance, their time constants evenly spaced in logarithm
/// (van der Ziel's construction). With the ratio r between neighbours each has the variance ln(r) B^2 / pi, which gives
/// the one-sided spectrum B^2 / (pi f) and the Allan deviation sqrt(2 ln 2 / pi) B = 0.664 B between one sample and 3
/// h.
class FlickerNoise {
 public:
  FlickerNoise(const Vec3& b, double step_s, std::uint64_t seed, const std::string& source);
  Vec3 next() noexcept;

 private:
  struct Process {
    GaussMarkov law;
    Vec3 state;
  };
  Stream random_;
  Vec3 b_;
  std::vector<Process> processes_;
};

/// Random walk from zero, q per sqrt(s).
class RandomWalk {
 public:
  RandomWalk(const Vec3& q, double step_s, std::uint64_t seed, const std::string& source);
  Vec3 next() noexcept;

 private:
  Stream random_;
  Vec3 step_;
  Vec3 state_ = Vec3::Zero();
};

/// Noise of the given standard deviation through two equal first-order low-passes of the band given; stationary from
/// the start.
class BandNoise {
 public:
  BandNoise(double sd, double band_hz, double step_s, std::uint64_t seed, const std::string& source);
  Vec3 next() noexcept;

 private:
  Stream random_;
  double keep_, scale_;
  Vec3 first_ = Vec3::Zero(), second_ = Vec3::Zero();
};

/// What the configuration of one triad says about its noise.
class TriadNoise {
 public:
  TriadNoise(const TriadConfig& config, double step_s, std::uint64_t seed, const std::string& sensor);
  Vec3 next() noexcept;

 private:
  Stream random_;
  Vec3 sd_;
  double keep_ = 0.0;  ///< 0: white
  Vec3 state_ = Vec3::Zero();
  std::vector<FlickerNoise> instability_;
  std::vector<RandomWalk> walk_;
};

}  // namespace stillpoint::sim
