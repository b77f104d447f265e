/// Cost of one rest window, absorbed and solved, by method, and of the methods of Gietzelt's comparison on the same
/// points.
#include <benchmark/benchmark.h>

#include "bench/calibration_tables.h"
#include "calib_online/gyro_matrix.h"
#include "calib_online/map_fit.h"
#include "calib_online/offline/ellipsoid_fit.h"
#include "calib_online/offline/rival_fits.h"
#include "calib_online/offline/two_step.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"

namespace stillpoint::bench {
namespace {

std::vector<Vec3> points(int n) {
  Random random(1);
  std::vector<Vec3> out;
  for (int k = 0; k < n; ++k)
    out.push_back(Vec3(1.0, 1.01, 0.99).cwiseProduct(random.direction()) + Vec3(0.02, -0.01, 0.03) +
                  random.normal3(0.003));
  return out;
}

calib::Moments sums(const std::vector<Vec3>& x) {
  calib::Moments m;
  for (const Vec3& v : x) m.add(v);
  return m;
}

template <class Solve>
void one_window(benchmark::State& state, Solve solve) {
  const auto x = points(1000);
  calib::Moments m = sums(x);
  std::size_t k = 0;
  for (auto _ : state) {
    m.add(x[k++ % x.size()]);
    auto fit = solve(m);
    benchmark::DoNotOptimize(fit);
  }
}

void BM_WindowLinAuto(benchmark::State& s) {
  one_window(s, [](const calib::Moments& m) { return calib::lin_auto(m); });
}
void BM_WindowMap(benchmark::State& s) {
  one_window(s, [](const calib::Moments& m) { return calib::map_fit(m, 0.003, {}); });
}
void BM_WindowMgn(benchmark::State& s) {
  one_window(s, [](const calib::Moments& m) { return calib::general_fit(m); });
}
BENCHMARK(BM_WindowLinAuto);
BENCHMARK(BM_WindowMap);
BENCHMARK(BM_WindowMgn);

void BM_WindowZhangClosedForm(benchmark::State& state) {
  Random random(2);
  calib::TwoStepSums s;
  std::vector<std::pair<Vec3, Mat3>> in;
  for (int k = 0; k < 64; ++k) {
    const Mat3 R = random.rotation().toRotationMatrix();
    in.emplace_back(R * Vec3(2, 5, 8) + random.normal3(0.01), R);
  }
  std::size_t k = 0;
  for (auto _ : state) {
    s.add(in[k % 64].first, in[k % 64].second);
    auto fit = calib::two_step_closed(s, 9.8, Mat3::Identity());
    benchmark::DoNotOptimize(fit);
    ++k;
  }
}
BENCHMARK(BM_WindowZhangClosedForm);

/// The whole of the calibrator: accelerometer filter, gyro bias, gyro matrix, publication.
void BM_WindowOnlineCalibrator(benchmark::State& state) {
  Random random(3);
  std::vector<calib::Window> windows;
  for (int k = 0; k < 256; ++k) {
    calib::Window w;
    w.t_end_ns = (k + 1) * 10'000'000'000;
    w.has = kAcc | kGyr | kTemp;
    w.acc_mps2 = array(Vec3(9.8 * random.direction() + random.normal3(0.01)));
    w.gyr_radps = array(random.normal3(1e-4));
    w.acc_cov = w.gyr_cov = w.turn_cov = array(Mat3(1e-6 * Mat3::Identity()));
    w.temp_degC = random.uniform(0, 50);
    windows.push_back(w);
  }
  calib::OnlineCalibrator calibrator({}, CalibrationSnapshot{});
  std::size_t k = 0;
  for (auto _ : state) {
    calib::Window w = windows[k % 256];
    w.t_end_ns = static_cast<std::int64_t>(k + 1) * 10'000'000'000;
    benchmark::DoNotOptimize(calibrator.absorb(w));
    ++k;
  }
}
BENCHMARK(BM_WindowOnlineCalibrator);

/// One sample on the sensor thread.
void BM_RestDetectorSample(benchmark::State& state) {
  Random random(4);
  std::vector<RawSample> in(1024);
  for (auto& s : in) {
    s.has = kAcc | kGyr | kMag | kTemp;
    s.acc_mps2 = array(Vec3(Vec3(0, 0, 9.8) + random.normal3(0.02)));
    s.gyr_radps = array(random.normal3(0.001));
    s.mag_uT = array(Vec3(Vec3(0, 20, -43) + random.normal3(0.3)));
  }
  calib::RestDetector detector;
  const CalibrationSnapshot calibration;
  std::int64_t t_ns = 0;
  std::size_t k = 0;
  for (auto _ : state) {
    RawSample s = in[k++ % in.size()];
    s.t_ns = t_ns += 10'000'000;
    benchmark::DoNotOptimize(detector.push(s, calibration));
  }
}
BENCHMARK(BM_RestDetectorSample);

// The paper's methods as batches over the same 1500 points, in one run, so that the ratios hold on any machine.
const std::vector<Vec3>& paper_points() {
  static const auto x = points(1500);
  return x;
}
void BM_BatchLinAuto(benchmark::State& s) {
  for (auto _ : s) {
    auto fit = calib::lin_auto(sums(paper_points()));
    benchmark::DoNotOptimize(fit);
  }
}
void BM_BatchMgn(benchmark::State& s) {
  for (auto _ : s) {
    auto fit = calib::general_fit(sums(paper_points()));
    benchmark::DoNotOptimize(fit);
  }
}
void BM_BatchLinMinVar(benchmark::State& s) {
  for (auto _ : s) {
    auto fit = calib::lin_min_var(paper_points(), {}, 1.0, 0.02, 100);
    benchmark::DoNotOptimize(fit);
  }
}
void BM_BatchNonLinear(benchmark::State& s) {
  for (auto _ : s) {
    auto fit = calib::non_linear(paper_points(), {}, 100);
    benchmark::DoNotOptimize(fit);
  }
}
void BM_BatchLsqNonLinear(benchmark::State& s) {
  for (auto _ : s) {
    auto fit = calib::lsq_non_linear(paper_points(), calib::campolo_initial(paper_points()), 100);
    benchmark::DoNotOptimize(fit);
  }
}
void BM_BatchMinVol(benchmark::State& s) {
  for (auto _ : s) {
    auto fit = calib::min_vol_ellipsoid(paper_points(), 1e-3, 100000);
    benchmark::DoNotOptimize(fit);
  }
}
BENCHMARK(BM_BatchLinAuto);
BENCHMARK(BM_BatchMgn);
BENCHMARK(BM_BatchLinMinVar);
BENCHMARK(BM_BatchNonLinear);
BENCHMARK(BM_BatchLsqNonLinear);
BENCHMARK(BM_BatchMinVol);

}  // namespace
}  // namespace stillpoint::bench

BENCHMARK_MAIN();
