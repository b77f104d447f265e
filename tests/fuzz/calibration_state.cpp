/// What is kept of a calibration: what is taken of it comes back whole, and the calibration goes on from there with
/// finite numbers.
#include "io/calibration_state.h"

#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

namespace {

calib::Window rest(std::int64_t t_ns) {
  calib::Window w;
  w.t_start_ns = t_ns;
  w.t_end_ns = t_ns + 2'000'000'000;
  w.samples = 200;
  w.has = kAcc | kGyr | kTemp;
  w.acc_mps2 = {0.3, -0.1, 9.8};
  w.gyr_radps = {0.01, -0.006, 0.004};
  w.acc_cov = array(Mat3(1e-6 * Mat3::Identity()));
  w.gyr_cov = array(Mat3(1e-9 * Mat3::Identity()));
  w.turn_cov = array(Mat3(1e-8 * Mat3::Identity()));
  return w;
}

void expect_finite(const TriadCalibration& c) {
  fuzz::expect(vec(c.bias).allFinite() && vec(c.bias_per_K).allFinite() && vec(c.bias_per_K2).allFinite() &&
                   mat(c.matrix).allFinite(),
               "what is learnt is finite");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  calib::OnlineCalibrator taken({}, {}), again({}, {});
  if (!io::restore_calibration(fuzz::text(data, size), taken)) return 0;
  fuzz::taken();
  const std::string kept = io::calibration_text(taken);
  const auto remarks = io::restore_calibration(kept, again);
  fuzz::expect(remarks && remarks->empty(), "what was taken can be kept",
               !remarks           ? remarks.error().message
               : remarks->empty() ? std::string()
                                  : remarks->front());
  fuzz::expect(io::calibration_text(again) == kept, "it comes back to the last digit", kept);
  for (std::int64_t k = 1; k <= 3; ++k) taken.absorb(rest(k * 10'000'000'000));
  const auto learnt = taken.snapshot();
  for (const auto* triad : {&learnt.acc, &learnt.gyr, &learnt.mag}) expect_finite(*triad);
  return 0;
}
