/// Tables 3 and 4 and sections 3.4 to 3.6 of Gietzelt et al.
#include <chrono>
#include <cstdio>
#include <map>

#include "bench/calibration_tables.h"
#include "calib_online/offline/points_fit.h"
#include "calib_online/offline/rival_fits.h"

namespace stillpoint::bench {
namespace {

using calib::FitStatus;
using calib::Method;
using calib::Point;
using calib::PointsFit;

const std::vector<Method> kPaperMethods{Method::kLinMinVar, Method::kNonLinear,       Method::kLsqNonLinear,
                                        Method::kMgn,       Method::kMinVolEllipsoid, Method::kLinAuto};
const std::vector<const char*> kPaperNames{"LinMinVar", "NonLinear", "LsqNonLin", "Mgn", "MinVol", "LinAuto"};

/// Points on an ellipsoid; the jitter is uniform within +-jitter of the radius (the paper's +-1 % of raw counts would
/// be 14 times what its own results show).
std::vector<Point> cloud(Random& random, int n, const Vec3& centre, const Vec3& radii, double jitter,
                         const Mat3& skew = Mat3::Identity()) {
  std::vector<Point> out;
  for (int k = 0; k < n; ++k) {
    const Vec3 u = random.direction();
    out.push_back(
        {Vec3(centre + (1.0 + random.uniform(-jitter, jitter)) * (skew * radii.cwiseProduct(u))), std::nullopt});
  }
  return out;
}

calib::PointsOptions paper_options() {
  calib::PointsOptions o;
  o.initial_centre = Vec3(2300, 2300, 2300);
  o.initial_radius = 500.0;
  return o;
}

Vec3 diagonal_radii(const PointsFit& f) { return f.radii ? *f.radii : Vec3(f.matrix.diagonal().cwiseInverse()); }

void table3() {
  // The paper's training sets hold 1057 to 2287 points; worn directions, 12 bit.
  std::printf(
      "\nTable 3, execution time, 1500 points; ratio to LinAuto. Paper: MATLAB, 2 GHz Core 2; ours: this machine, one "
      "thread.\n");
  std::printf("%-12s %10s %10s %12s\n", "method", "paper", "ours", "ours, us");
  Random random(3);
  const auto points = cloud(random, 1500, Vec3(2300, 2310, 2290), Vec3(500, 505, 495), 0.01);
  const double paper[6] = {0.327, 0.504, 1.249, 0.198, 2.764, 0.037};
  std::vector<double> us;
  for (const Method m : kPaperMethods) {
    auto options = paper_options();
    if (m == Method::kMinVolEllipsoid) options.min_vol_tolerance = 1e-3;
    std::vector<double> runs;
    for (int k = 0; k < 10; ++k) {
      const auto start = std::chrono::steady_clock::now();
      const PointsFit fit = fit_points(m, points, options);
      runs.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count() +
                     0.0 * fit.residual_rms);
    }
    us.push_back(quantile(runs, 0.5));
  }
  for (std::size_t k = 0; k < 6; ++k)
    std::printf("%-12s %10.1f %10.1f %12.1f\n", kPaperNames[k], paper[k] / paper[5], us[k] / us.back(), us[k]);
  std::printf(
      "Includes reading the points into sums and the checks that all share; bench/calibration_bench has the solvers "
      "alone.\n");
}

/// The paper's MinVol: the program of its reference [14], which stops at 0.05 and has no away steps.
void print_unconverged_min_vol() {
  std::vector<double> radius[3];
  for (unsigned seed = 0; seed < 10; ++seed) {
    Random random(seed);
    std::vector<Vec3> x;
    for (int k = 0; k < 100; ++k) {
      // Directions by uniform angles crowd at the poles: with random directions the unconverged radii are even.
      const double a = random.uniform(0, 2 * 3.14159265358979), b = random.uniform(-1.5707963, 1.5707963);
      x.push_back((1.0 + random.uniform(-0.01, 0.01)) *
                  Vec3(std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b)));
    }
    const auto e = calib::min_vol_ellipsoid(x, 0.05, 100000, false);
    const Mat3 U = e.A.llt().matrixU();
    for (int k = 0; k < 3; ++k) radius[k].push_back(500.0 / U(k, k));
  }
  std::printf("%-12s %10s", "MinVol 0.05", "490/483/526");
  for (const auto& v : radius) std::printf("   %7.2f +- %5.2f", mean(v), sd(v));
  std::printf("  tolerance 0.05, uniform angles: the paper's figure is that of an unconverged iteration\n");
}

void table4(Figures& figures) {
  std::printf(
      "\nTable 4, s = 500, o = 2300, 100 points, jitter +-1 %% of the radius, 10 clouds a pass, seeds 0..9; mean +- "
      "sd\n");
  const double paper_s[6] = {499.81, 499.83, 499.77, 499.90, 490.45, 499.83};
  std::printf("%-12s %10s %18s %18s %18s %18s\n", "method", "s_x paper", "s_x", "s_y", "s_z", "o_x");
  for (std::size_t m = 0; m < 6; ++m) {
    std::vector<double> s[3], o;
    for (unsigned seed = 0; seed < 10; ++seed) {
      Random random(seed);
      const auto points = cloud(random, 100, Vec3::Constant(2300), Vec3::Constant(500), 0.01);
      const PointsFit f = fit_points(kPaperMethods[m], points, paper_options());
      if (f.status != FitStatus::kOk) continue;
      for (int k = 0; k < 3; ++k) s[k].push_back(diagonal_radii(f)[k]);
      o.push_back(f.offset.x());
    }
    std::printf("%-12s %10.2f", kPaperNames[m], paper_s[m]);
    for (const auto& v : s) std::printf("   %7.2f +- %5.2f", mean(v), sd(v));
    std::printf("   %7.2f +- %5.2f\n", mean(o), sd(o));
    figures[std::string("table4.s_x.") + kPaperNames[m]] = mean(s[0]);
  }
  print_unconverged_min_vol();
}

/// Errors of the norm in mg rms, one for each set of worn directions that could be fitted: over even directions and
/// over those worn.
struct GrowingErrors {
  std::vector<double> even, worn;
  int failures = 0;
};

GrowingErrors errors_of(Method method, int points_in_set, unsigned seeds) {
  GrowingErrors out;
  const Vec3 o(2320, 2315, 2290), s(505, 495, 500);
  auto options = paper_options();
  options.prior_relative_sd = 0.05;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    Random random(100 + seed);
    std::vector<Point> points;
    for (const Vec3& u : worn_directions(random, points_in_set))
      points.push_back({Vec3(o + (1 + random.uniform(-0.01, 0.01)) * s.cwiseProduct(u)), std::nullopt});
    const PointsFit f = fit_points(method, points, options);
    if (f.status != FitStatus::kOk) {
      ++out.failures;
      continue;
    }
    const auto error_mg = [&f](const Vec3& y) { return 1000 * ((f.matrix * (y - f.offset)).norm() - 1); };
    std::vector<double> even, worn;
    for (const Vec3& u : even_directions(300)) even.push_back(error_mg(o + s.cwiseProduct(u)));
    for (const auto& p : points) worn.push_back(error_mg(p.y));
    out.even.push_back(rms(even));
    out.worn.push_back(rms(worn));
  }
  return out;
}

std::string name_of(Method method) {
  for (const auto& known : calib::methods())
    if (known.method == method) return std::string(known.name);
  return {};
}

void section34() {
  std::printf(
      "\nSection 3.4, growing training set of worn directions, sensor 40/30/20 mg bias, 2 %% scale, 1 %% jitter; error "
      "of the norm over EVEN\n"
      "directions, mg rms, median of 20 seeds. Paper: LinAuto < 100 mg in set-up, < 16 mg after 270, judged on the "
      "worn directions themselves.\n");
  const std::vector<int> sizes{12, 40, 100, 270, 1000};
  std::printf("%-20s", "method");
  for (int n : sizes) std::printf(" %9d", n);
  std::printf("   worn directions themselves, 270\n");
  auto all = kPaperMethods;
  for (const Method ours : {Method::kLinAutoRepeated, Method::kAdjusted, Method::kMap}) all.push_back(ours);
  for (const Method m : all) {
    std::printf("%-20s", name_of(m).c_str());
    double on_worn = 0.0;
    for (int n : sizes) {
      const GrowingErrors e = errors_of(m, n, 20);
      if (n == 270) on_worn = quantile(e.worn, 0.5);
      if (e.failures > 10)
        std::printf("   %2d fail", e.failures);
      else
        std::printf(" %9.1f", quantile(e.even, 0.5));
    }
    std::printf("   %9.1f\n", on_worn);
  }
}

/// Largest relative error of LinAuto's radii over 200 seeds, %; 100 where it refuses.
std::vector<double> radius_errors_percent(int passes, int n, bool mirrored, const Vec3& radii) {
  std::vector<double> out;
  for (unsigned seed = 0; seed < 200; ++seed) {
    Random random(seed);
    calib::Moments m;
    for (int k = 0; k < n; ++k) {
      const Vec3 x = radii.cwiseProduct(random.direction()) / 2.0;
      m.add(x);
      if (mirrored) m.add(Vec3(-x));
    }
    const auto fit = lin_auto(m, passes);
    out.push_back(fit.status == FitStatus::kOk
                      ? 100 * (2.0 * fit.radii.cwiseQuotient(radii) - Vec3::Ones()).cwiseAbs().maxCoeff()
                      : 100.0);
  }
  return out;
}

void section35(Figures& figures) {
  std::printf(
      "\nSection 3.5, axes 1:2:3, 100 random points, no noise, 200 seeds: largest relative radius error. Paper: at "
      "most 1 %%.\n");
  std::printf("%-28s %10s %10s\n", "", "mean", "95 %");
  const auto line = [](const char* what, const std::vector<double>& e) {
    std::printf("%-28s %9.4f%% %9.4f%%\n", what, mean(e), quantile(e, 0.95));
  };
  const Vec3 radii(1, 2, 3);
  for (int passes : {1, 2, 3, 5, 8}) {
    const auto e = radius_errors_percent(passes, 100, false, radii);
    line((std::to_string(passes) + " pass" + (passes > 1 ? "es" : ", as printed")).c_str(), e);
    figures["3.5.percent_after_" + std::to_string(passes)] = mean(e);
  }
  line("1 pass, point-symmetric set", radius_errors_percent(1, 50, true, radii));
  line("1 pass, N = 10000", radius_errors_percent(1, 10000, false, radii));
  line("1 pass, axes 1:1.1:1.2", radius_errors_percent(1, 100, false, Vec3(1, 1.1, 1.2)));
  std::printf("The claim of 1 %% fails for random directions; repeating from the same sums repairs it.\n");
}

void section36(Figures& figures) {
  std::printf(
      "\nSection 3.6, axes off by up to 2 degrees, 100 points to fit and 100 to test, jitter 1 %%, 100 seeds: error of "
      "the norm, %%\n");
  std::printf("%-20s %8s %8s %8s\n", "method", "paper", "mean", "largest");
  const double paper[6] = {0.8, 0.8, 0.8, 0.45, 3.7, 0.8};
  for (std::size_t m = 0; m < 6; ++m) {
    std::vector<double> means, largest;
    for (unsigned seed = 0; seed < 100; ++seed) {
      Random random(seed);
      Mat3 skewed = Mat3::Identity();
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          if (r != c) skewed(r, c) = std::tan(random.uniform(-2, 2) * kRadPerDeg);
      const auto points = cloud(random, 100, Vec3::Constant(2300), Vec3::Constant(500), 0.01, skewed);
      const auto test = cloud(random, 100, Vec3::Constant(2300), Vec3::Constant(500), 0.01, skewed);
      const PointsFit f = fit_points(kPaperMethods[m], points, paper_options());
      if (f.status != FitStatus::kOk) continue;
      std::vector<double> e;
      for (const auto& p : test) e.push_back(100 * std::abs((f.matrix * (p.y - f.offset)).norm() - 1));
      means.push_back(mean(e));
      largest.push_back(*std::max_element(e.begin(), e.end()));
    }
    std::printf("%-20s %8.2f %8.2f %8.2f\n", kPaperNames[m], paper[m], mean(means), mean(largest));
    figures[std::string("3.6.percent.") + kPaperNames[m]] = mean(means);
  }
  std::printf("The paper's values are mean errors (Mgn's is the jitter itself), not the maxima it says.\n");
}

}  // namespace

Figures gietzelt_tables() {
  Figures figures;
  std::printf("== Gietzelt et al. ==\n");
  table3();
  table4(figures);
  section34();
  section35(figures);
  section36(figures);
  return figures;
}

}  // namespace stillpoint::bench
