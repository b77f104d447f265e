/// What the search without a reference found, in words, units and figures.
#pragma once
#include "diagnosis/no_reference/search.h"
#include "diagnosis/result.h"

namespace stillpoint::diag::detail {

/// `sd`: deviations of the law's values.
[[nodiscard]] Finding describe(const SelfConsistency& model, const Candidate& candidate, const Eigen::VectorXd& sd,
                               const std::vector<Candidate>& ranking);
/// A slow offset that no law of the recording's drivers describes.
[[nodiscard]] Finding describe_drift(const SelfConsistency& model, Sensor sensor, double score);
/// Something is there, and no law of the list is it.
[[nodiscard]] Finding describe_unknown(const SelfConsistency& model, Sensor sensor, const Candidate& closest);

/// Heat map and table of the channels that have a witness; `before`: residuals of gyroscope and magnetometer at first.
void fill_channels(const SelfConsistency& model, const std::array<SelfConsistency::Series, 2>& before, Diagnosis& d);

}  // namespace stillpoint::diag::detail
