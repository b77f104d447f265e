/// What is said of every mistake in a recording, and of every oddity that is borne.
#include <gtest/gtest.h>

#include "io/recording.h"
#include "io/recording_columns.h"
#include "tests/golden.h"

namespace stillpoint::io {
namespace {

constexpr char kAcc3[] = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2\n";
constexpr char kMag3[] = "time_ms,mag_x_gauss,mag_y_gauss,mag_z_gauss,temp_degC\n";

/// The message, or what was read: rows, issues in words, the first and the last row.
std::string answer(const std::string& text, OnMalformedRow policy) {
  const auto r = parse_recording(text, "f.csv", policy);
  if (!r) return r.error().message + "\n";
  std::ostringstream out;
  out << r->size() << " rows, " << r->issues.dropped_rows() << " dropped, step " << r->median_step_s()
      << " s, in counts " << r->acc_in_counts << r->gyr_in_counts << r->mag_in_counts << "\n";
  for (const auto& line : describe(r->issues)) out << "  " << line << "\n";
  for (const auto& times : sensor_times(*r))
    out << "  " << times.name << " " << times.readings << " " << times.median_step_s << " " << times.longest_gap_s
        << " " << times.gaps << "\n";
  for (const std::size_t row : {std::size_t{0}, r->size() - 1}) {
    const RawSample s = r->sample(row);
    out << "  " << s.t_ns << " " << s.sequence << " " << int{s.has} << " " << vec(s.acc_mps2).transpose() << " "
        << vec(s.gyr_radps).transpose() << " " << vec(s.mag_uT).transpose() << " " << s.temp_degC << "\n";
  }
  return out.str();
}

TEST(GoldenTexts, EveryMistakeAndEveryOddityOfARecording) {
  std::string many = kAcc3;
  for (int k = 0; k < 12; ++k) many += std::to_string(k) + ",x,1\n";
  const std::string texts[] = {
      "",
      "# only: this\n\n# and that\n",
      "\xEF\xBB\xBF# sensor: a b\n\n time_s , acc_x_mps2,acc_y_mps2,acc_z_mps2\r\n0,1,2,3\r\n0.01,1,2,3\r\n",
      "acc_x_mps2,acc_y_mps2,acc_z_mps2\n1,2,3\n",
      "time_s,time_ms,acc_x_mps2,acc_y_mps2\n1,2,3,4\n",
      "time_s,acc_x_mps2,acc_y_mps2,acc_z_g,acc_x_mps2\n",
      "time_s,gyr_x_dps,gyr_y_dps,gyr_z_dsp,ref_qw\n",
      "time_s,temp_degC\n0,1\n",
      kAcc3,
      std::string(kAcc3) + "\n\n0,1,2,3,4\n1,1,2\n2,1,2,\n3,,,\n1e300,1,2,3\n5,1,2,0x3\n,1,2,3\n",
      std::string(kAcc3) + "0,1,2,3\n1,1,2,3\n1,1,2,3\n0.5,1,2,3\n2,1,inf,3\n3,1,1e999,3\n9,1,2,3\n10,1,2,3\n11,1,2,3",
      many,
      std::string(kMag3) + "0,0.1,0.2,0.3,\n10,,,,25.5\n10,0.1,0.2,0.4,\n20,0.1,0.2,-0.4,25\n20,0.2,,,\n90,0,0,0,26\n",
      "time_us,gyr_x_counts,gyr_y_counts,gyr_z_counts,accx_mps2,note\n0,1,2,3,,a\n1000,-1,-2,-3,5,b\n",
      "time_ns,acc_x_counts,acc_y_counts,acc_z_counts,mag_x_counts,mag_y_counts,mag_z_counts\n5,1,2,3,4,5,6\n"
      "123456789012345678,1,2,3,4,5,6\n123456789012345679.0,1,2,3,4,5,6\n",
  };
  std::string told;
  for (const std::string& text : texts)
    for (const OnMalformedRow policy : {OnMalformedRow::kFail, OnMalformedRow::kCount}) told += answer(text, policy);
  test::check_golden_text("mistakes_recording", told);
}

TEST(GoldenTexts, EveryNameThatAColumnMayHaveOrMayHaveMeant) {
  std::ostringstream told;
  for (const char* name :
       {"time_s",       "time_ms",      "time_us",     "time_ns",   "time_h",       "acc_x_mps2", "acc_y_g",
        "acc_z_counts", "acc_w_mps2",   "gyr_x_radps", "gyr_y_dps", "gyr_z_counts", "mag_x_uT",   "mag_y_gauss",
        "mag_z_T",      "mag_x_nT",     "temp_degC",   "temp_K",    "current_A",    "supply_V",   "ref_qw",
        "ref_qx",       "ref_qy",       "ref_qz",      "ref_px_m",  "ref_py_m",     "ref_pz_m",   "ref_moving",
        "ax_g",         "accel_x_mps2", "gyro_z_dps",  "Mag_x_uT",  "gyr_x",        "temp",       "time",
        "acc_x_mps3",   "note"}) {
    told << name << ":";
    if (const auto known = known_column(name))
      told << " group " << known->group << " field " << known->field << " times " << known->to_si << " " << known->unit;
    told << " | " << meant_column(name) << " | " << likely_mistake(name) << "\n";
  }
  test::check_golden_text("column_names", told.str());
}

}  // namespace
}  // namespace stillpoint::io
