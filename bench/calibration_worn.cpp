/// The MAP fit on the directions of a day of wear.
#include <cstdio>

#include "bench/calibration_tables.h"
#include "calib_online/map_fit.h"
#include "calib_online/offline/ellipsoid_fit.h"
#include "calib_online/offline/points_fit.h"

namespace stillpoint::bench {
namespace {

struct Truth {
  Mat3 K;
  Vec3 o;
};
/// A sensor drawn from the prior: 2 % scale, 1 % shear, 40 mg bias.
Truth draw(Random& random) {
  Truth t{Mat3::Identity(), random.normal3(0.04)};
  for (int i = 0; i < 3; ++i) t.K(i, i) += random.normal(0.02);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j) t.K(i, j) = t.K(j, i) = random.normal(0.01 / 2);
  return t;
}
double error_mg(const Truth& t, const calib::Ellipsoid& e) {
  std::vector<double> out;
  const Mat3 inv = t.K.inverse();
  for (const Vec3& u : even_directions(300)) out.push_back(1000 * ((e.K * (inv * u + t.o - e.centre)).norm() - 1));
  return rms(out);
}

/// Errors of three fits over seeds, mg; where a fit refuses, it has no error.
struct WornErrors {
  std::vector<double> map, predicted, lin_auto, mgn;
  int mgn_failed = 0;
};

WornErrors errors_on_worn(int windows, unsigned seeds) {
  WornErrors out;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    Random random(500 + seed);
    const Truth t = draw(random);
    const Mat3 inv = t.K.inverse();
    calib::Moments m;
    const double noise_sd = 0.006;
    for (const Vec3& u : worn_directions(random, windows)) m.add(Vec3(inv * u + t.o + random.normal3(noise_sd)));
    const Mat3 C = noise_sd * noise_sd * Mat3::Identity();
    const auto fit = calib::map_fit(m.adjusted(C), noise_sd, {0.02, 0.01, 0.04});
    out.map.push_back(error_mg(t, fit.ellipsoid));
    out.predicted.push_back(1000 * fit.norm_sd);
    const auto l = calib::lin_auto(m);
    if (l.status == calib::FitStatus::kOk)
      out.lin_auto.push_back(error_mg(t, {l.centre, Mat3(l.radii.cwiseInverse().asDiagonal())}));
    const auto g = calib::general_fit(m);
    if (g.status == calib::FitStatus::kOk)
      out.mgn.push_back(error_mg(t, g.ellipsoid));
    else
      ++out.mgn_failed;
  }
  return out;
}

}  // namespace

Figures worn_and_adjusted() {
  Figures figures;
  std::printf(
      "\n== Worn directions, MAP fit ==\nsensor drawn from the prior (2 %% scale, 1 %% shear, 40 mg bias), noise 0.6 "
      "%%, 40 seeds; mg rms over EVEN directions\n");
  std::printf("%8s %8s %10s %16s %10s %10s\n", "windows", "MAP", "predicted", "predicted/actual", "LinAuto", "Mgn");
  for (const int n : {12, 20, 150, 270, 1000}) {
    const WornErrors e = errors_on_worn(n, 40);
    const double map_mg = rms(e.map), over_actual = rms(e.predicted) / map_mg;
    std::printf("%8d %8.1f %10.1f %16.2f %10.1f %10.1f (%d fail)\n", n, map_mg, rms(e.predicted), over_actual,
                quantile(e.lin_auto, .5), quantile(e.mgn, .5), e.mgn_failed);
    figures["map_mg_" + std::to_string(n)] = map_mg;
    figures["map_predicted_over_actual_" + std::to_string(n)] = over_actual;
  }
  return figures;
}

}  // namespace stillpoint::bench
