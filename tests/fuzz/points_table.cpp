/// Tables of points, and what the methods of `calibrate` make of them: a status with its reason, or finite numbers.
#include "apps/stillpoint/points_table.h"
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMostPoints = 60;  // the slowest method takes its time
  fuzz::Choices input(data, size);
  const auto& method = calib::methods()[input.byte() % calib::methods().size()];
  const auto table = app::parse_points(std::string(input.rest()), "f.csv");
  if (!table) {
    fuzz::expect(table.error().message.starts_with("f.csv:"), "a fault names its file", table.error().message);
    return 0;
  }
  if (!table->faults.empty() || table->points.size() > kMostPoints) return 0;
  calib::PointsOptions options;
  options.max_iterations = 50;
  const calib::PointsFit fit = calib::fit_points(method.method, table->points, options);
  if (fit.status != calib::FitStatus::kOk) {
    fuzz::expect(!fit.reason.empty(), "a status has its reason", method.name);
    return 0;
  }
  fuzz::taken();
  fuzz::expect(fit.offset.allFinite() && fit.matrix.allFinite(), "a calibration is finite", method.name);
  return 0;
}
