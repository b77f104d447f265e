/// What a diagnosis says: the contract of docs/formats.md (`stillpoint.diagnosis/1`) as a struct, and the series behind
/// each statement for the report.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace stillpoint::diag {

enum class Verdict { kNoMismatch, kExplained, kPartlyExplained, kUnexplained, kInsufficientData };

struct Parameter {
  std::string name;
  double value = 0.0;
  std::array<double, 2> ci95{};
  std::string unit;
};

struct HeldOut {
  double rms_before = 0.0, rms_after = 0.0, noise_floor = 0.0;
  std::string unit;
  double gain_nats = 0.0;                ///< whitened log-likelihood gain on data not used for the fit
  double removable_share_removed = 0.0;  ///< 1: all of the error that is not noise is gone
  int blocks_better = 0, blocks = 0;
};

/// Curves of one finding, thinned for plotting.
struct FindingFigures {
  std::vector<double> t_s;
  std::vector<double> residual_before, residual_after;  ///< one channel, the strongest
  std::vector<bool> held_out;                           ///< per point
  std::vector<double> frequency_hz, psd_before, psd_after, psd_noise;
  std::vector<double> driver, residual_at_driver, law_at_driver;
  std::string driver_label;
  std::vector<double> autocorrelation_before, autocorrelation_after;  ///< lags 0.. of the whitened residual
  double autocorrelation_band = 0.0;                                  ///< 95 % band of white noise
  std::string channel, unit;
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
  HeldOut held_out;
  double p_value = 1.0;
  std::string runner_up_effect, runner_up_why_rejected;
  std::string decided_by;
  double confidence = 0.0;
  FindingFigures figures;
};

struct ConfigurationFault {
  std::string sensor;  ///< acc, gyr, mag
  std::string what;
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
  std::vector<ChannelResidual> residual;
  std::vector<RankedHypothesis> ranking;
  double abstention_nats = 0.0;                ///< below this gain no name is stated
  std::vector<std::string> heat_channels;      ///< rows of the heat map
  std::vector<double> heat_t_s;                ///< columns: block centres
  std::vector<std::vector<double>> heat_nats;  ///< whitened misfit of the baseline per channel and block
  std::vector<std::string> notices;            ///< input that looks wrong, what to record, what was muted
};

}  // namespace stillpoint::diag
