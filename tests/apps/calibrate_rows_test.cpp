/// `stillpoint calibrate --recording`: how the rows hold the sensors does not matter.
#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

class CalibrateRows : public ToolInFolder {
 protected:
  /// What the recording has taught: windows or turns of each quantity.
  std::map<std::string, int> taken_from(const std::string& recording) {
    EXPECT_EQ(tool("calibrate --recording " + recording + " --json out.json > out"), 0) << told_;
    std::map<std::string, int> taken;
    const auto answer = nlohmann::json::parse(read_file(folder_ / "out.json"));
    for (const auto& q : answer["quantities"])
      for (const char* evidence : {"windows", "turns", "turns of the field"})
        if (q.contains(evidence)) taken[q["name"]] = q[evidence].get<int>();
    return taken;
  }
};

/// As phone loggers write them: each sensor at a stamp of its own, the fields of the others empty.
std::string each_in_its_own_row(const std::string& shared) {
  std::istringstream in(shared);
  std::ostringstream out;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    std::vector<std::string> fields;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) fields.push_back(cell);
    if (fields.front() == "time_ns") {
      out << "time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps,mag_x_uT,mag_y_uT,mag_z_"
             "uT\n";
      continue;
    }
    for (std::size_t sensor = 0; sensor < 3; ++sensor) {
      out << std::stoll(fields[0]) + 2'000'000 * static_cast<long long>(sensor);
      for (std::size_t k = 0; k < 9; ++k) out << ',' << (k / 3 == sensor ? fields[1 + k] : "");
      out << '\n';
    }
  }
  return out.str();
}

TEST_F(CalibrateRows, SensorsInRowsOfTheirOwnTeachWhatSharedRowsTeach) {
  write_file(folder_ / "sim.yaml",
             "rate_hz: 100\naccelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\n"
             "magnetometer: {noise_uT: 0.3, bias: [20, -10, 5]}\nreference: {kind: none}\n"
             "motion: {kind: hand, duration_s: 200}\n");
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output shared.csv"), 0) << told_;
  write_file(folder_ / "apart.csv", each_in_its_own_row(read_file(folder_ / "shared.csv")));
  const auto shared = taken_from("shared.csv"), apart = taken_from("apart.csv");
  for (const auto& [name, taken] : shared) {
    const auto same = apart.find(name);
    ASSERT_NE(same, apart.end()) << name;
    EXPECT_NEAR(same->second, taken, 0.1 * taken + 2) << name;
  }
  EXPECT_GT(shared.at("gyroscope, matrix"), 5);
  EXPECT_GT(shared.at("magnetometer, iron and matrix"), 30);
}

}  // namespace
}  // namespace stillpoint::test
