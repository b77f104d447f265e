/// What a diagnosis says: the contract of docs/formats.md (`stillpoint.diagnosis/1`) as a struct, and the series behind
/// each statement for the report.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stillpoint::diag {

enum class Verdict {
  kNoMismatch,
  kWrongNumbers,    ///< of the simulation (bias, matrix, noise, field); no physics is missing
  kSurplusPhysics,  ///< the simulation has physics that the sensor has not
  kExplained,
  kPartlyExplained,
  kUnexplained,
  kInsufficientData
};

struct Parameter {
  std::string name;
  double value = 0.0;
  std::array<double, 2> ci95{};
  std::string unit;
};

struct HeldOut {
  double rms_before = 0.0, rms_after = 0.0, noise_floor = 0.0;
  std::string unit;
  double gain_nats = 0.0;                ///< log-likelihood gain on data not used for the fit
  double told_by_others_nats = 0.0;      ///< of it; not what a block may have by leaving a coefficient open
  double removable_share_removed = 0.0;  ///< 1: all of the error that is not noise is gone
  std::array<double, 2> share_ci95{};    ///< of it, from block to block
  std::string on;                        ///< what was held out; empty: nothing was
  int blocks_better = 0, blocks = 0;
};

/// The residual of a finding's channel against one quantity.
struct AgainstQuantity {
  std::string label;
  std::vector<double> x, before, after;
};

/// Curves of one finding, thinned for plotting.
struct FindingFigures {
  std::vector<double> t_s;
  std::vector<double> residual_before, residual_after;  ///< one channel, the strongest
  std::vector<bool> held_out;                           ///< per point
  std::vector<double> frequency_hz, psd_before, psd_after, psd_noise;
  std::vector<double> driver, residual_at_driver, law_at_driver;
  std::string driver_label;
  std::vector<AgainstQuantity> against_each;  ///< of a discovered law: what it is made of, then what else is recorded
  std::vector<double> autocorrelation_before, autocorrelation_after;  ///< lags 0.. of the whitened residual
  double autocorrelation_band = 0.0;                                  ///< 95 % band of white noise
  std::string channel, unit;
};

/// A law that was looked at when a discovered one was chosen.
struct WeighedLaw {
  std::string text;
  double bits = 0.0;                       ///< length of the text
  double gain_nats = 0.0, net_nats = 0.0;  ///< net: less what length and coefficients cost
};

/// A law of which the stated one is a part: how large its further terms may be.
struct WiderLaw {
  std::string effect;
  std::vector<Parameter> further;
};

struct Finding {
  std::string effect;                   ///< ID of the catalogue, or "unknown:" and the product of drivers
  std::vector<std::string> equivalent;  ///< IDs that this recording cannot tell apart from it
  std::vector<std::string> channels;
  std::array<double, 2> interval_s{};
  std::string regime;
  std::string equation;
  std::string driver;
  std::vector<Parameter> parameters;
  std::optional<WiderLaw> wider;
  HeldOut held_out;
  std::optional<double> p_value;  ///< corrected for all that was looked at; absent: not computed
  std::string runner_up_effect, runner_up_why_rejected;
  std::string decided_by;
  std::optional<double> confidence;  ///< share of answers with such evidence that are true; absent: not computed
  std::vector<WeighedLaw> weighed;   ///< of a discovered law, best first, itself among them
  FindingFigures figures;
};

/// Of what cannot be told apart from it, what does not contain it.
[[nodiscard]] inline std::vector<std::string> not_excluded(const Finding& f) {
  std::vector<std::string> out = f.equivalent;
  if (f.wider) std::erase(out, f.wider->effect);
  return out;
}

/// Physics outside the catalogue: a law of its own, or a product of drivers that has no name.
[[nodiscard]] inline bool is_unknown(std::string_view effect) { return effect.starts_with("unknown"); }
/// Of a sensor, or of the clock of all.
[[nodiscard]] inline bool is_delay(std::string_view effect) {
  return effect.ends_with("_delay") || effect == "sys_offset";
}
[[nodiscard]] inline bool is_filter(std::string_view effect) {
  return effect.ends_with("_lpf") || effect.ends_with("_resonance");
}
[[nodiscard]] inline bool is_unknown(const Finding& f) { return is_unknown(f.effect); }

struct ConfigurationFault {
  std::string sensor;  ///< acc, gyr, mag
  std::string what;
  std::vector<Parameter> values{};  ///< what the numbers of the simulation should be
};

struct NoiseFault {
  std::string channel;
  double configured = 0.0, measured = 0.0;
};

struct ChannelResidual {
  std::string channel;
  double rms_before = 0.0, rms_after = 0.0;
  bool white = false;
  double smallest_seen = 0.0;  ///< smallest constant-driver effect that would have been found, unit of the channel
  std::string unit;
};

/// What the simulation has and the recording has not, or has less of.
struct Surplus {
  std::string effect;
  double in_simulation = 0.0, in_recording = 0.0;  ///< share of its configured size
  std::array<double, 2> ci95{};                    ///< of in_recording
};

/// How the improved simulation does on a recording that it was not made from.
struct Validation {
  std::string file, sensor;
  double share = 0.0;  ///< of the removable residual power that is gone; not finite: nothing there to remove
  std::array<double, 2> ci95{};
  double rms_before = 0.0, rms_after = 0.0;
  std::string unit;
};

struct RankedHypothesis {
  std::string effect;
  double gain_nats = 0.0;
};

struct Diagnosis {
  Verdict verdict = Verdict::kInsufficientData;
  std::string summary;
  std::vector<Finding> findings;
  std::vector<ConfigurationFault> configuration;
  std::vector<NoiseFault> noise;
  std::vector<std::string> unaccounted;  ///< what is left far over the noise and is no finding, in words
  std::vector<Surplus> surplus;
  std::vector<Validation> validation;
  std::vector<ChannelResidual> residual;
  std::vector<RankedHypothesis> ranking;
  double abstention_nats = 0.0;                ///< below this gain no name is stated
  std::vector<std::string> heat_channels;      ///< rows of the heat map
  std::vector<double> heat_t_s;                ///< columns: block centres
  std::vector<std::vector<double>> heat_nats;  ///< whitened misfit of the baseline per channel and block
  std::vector<std::string> notices;            ///< input that looks wrong, what to record, what was muted
};

}  // namespace stillpoint::diag
