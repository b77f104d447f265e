/// Agreement with recordings that another simulator made: our forward model, driven by their exact reference and their
/// configuration, must leave white noise of the stated size and nothing else.
#include <gmock/gmock.h>

#include <filesystem>
#include <numeric>

#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"
#include "tests/source_folder.h"

namespace stillpoint::sim {
namespace {

const std::string kFolder = in_source("../shared/blind_open");

struct Residual {
  std::array<std::vector<double>, 3> axis;
};

double rms(const std::vector<double>& x) {
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0) / static_cast<double>(x.size()));
}

double lag_one(const std::vector<double>& x) {
  double sum = 0.0;
  for (std::size_t i = 1; i < x.size(); ++i) sum += x[i] * x[i - 1];
  return sum / static_cast<double>(x.size()) / (rms(x) * rms(x));
}

double mean(const std::vector<double>& x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

/// Reading of the recording minus reading of our noiseless simulation.
Residual residual(const std::vector<SimulatedSample>& ours, const std::vector<Vec3>& theirs,
                  const Array3 RawSample::*slot) {
  Residual out;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const Vec3 d = theirs[i] - vec(ours[i].sample.*slot);
    for (std::size_t k = 0; k < 3; ++k) out.axis[k].push_back(d[static_cast<Eigen::Index>(k)]);
  }
  return out;
}

/// With n = 6000 samples the rms of white noise varies by 0.9 % (four of these are allowed), its lag-one correlation by
/// 0.013, its mean by 0.013 sd.
void expect_white(const Residual& r, double sd, const std::string& what) {
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(rms(r.axis[k]) / sd, 1.0, 0.037) << what << " axis " << k;
    EXPECT_NEAR(lag_one(r.axis[k]), 0.0, 0.055) << what << " axis " << k;
    EXPECT_NEAR(mean(r.axis[k]) / sd, 0.0, 0.055) << what << " axis " << k;
  }
}

class CleanCase : public ::testing::TestWithParam<std::string> {};

TEST_P(CleanCase, LeavesOnlyTheStatedWhiteNoise) {
  const std::string stem = kFolder + "/cases/" + GetParam();
  if (!std::filesystem::exists(stem + ".csv")) GTEST_SKIP() << "LOUD: SKIPPED: " << stem << ".csv is not here";
  auto config = io::read_simulation(stem + ".yaml");
  ASSERT_TRUE(config) << config.error().message;
  const auto recording = io::read_recording(stem + ".csv");
  ASSERT_TRUE(recording) << recording.error().message;
  auto motion = RecordedMotion::from(io::reference_track(*recording));
  ASSERT_TRUE(motion) << motion.error().message;
  const auto configured = *config;
  for (auto* triad : {&config->accelerometer, &config->gyroscope, &config->magnetometer}) (*triad)->noise_sd = 0.0;
  const auto ours = simulate(*config, std::move(*motion), 1);
  ASSERT_EQ(ours.size(), recording->size());
  expect_white(residual(ours, recording->acc_mps2, &RawSample::acc_mps2), configured.accelerometer->noise_sd, "acc");
  expect_white(residual(ours, recording->gyr_radps, &RawSample::gyr_radps), configured.gyroscope->noise_sd, "gyr");
  expect_white(residual(ours, recording->mag_uT, &RawSample::mag_uT), configured.magnetometer->noise_sd, "mag");
}

INSTANTIATE_TEST_SUITE_P(ExactReference, CleanCase, ::testing::Values("005", "006", "032", "035"));

}  // namespace
}  // namespace stillpoint::sim
