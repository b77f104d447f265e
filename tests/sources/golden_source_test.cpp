/// What is said of every mistake in a `source:` block, how each kind is printed, and what is made of every kind of
/// line.
#include <gtest/gtest.h>

#include "core/units.h"
#include "io/config.h"
#include "sources/address.h"
#include "sources/iio_values.h"
#include "sources/line.h"
#include "sources/stamps.h"
#include "tests/golden.h"

namespace stillpoint::sources {
namespace {

TEST(GoldenSource, EveryMistakeOfABlockAndEveryBlockInFull) {
  std::string told;
  for (
      const char* block :
      {"5",
       "{}",
       "{kind: serial, from: a, files: b}",
       "{kind: [stream]}",
       "{kind: recording}",
       "{kind: recording, file: ''}",
       "{kind: recording, file: a.csv, speed: -1, seed: 1.5, wait_for_file: 3, at_end: sleep, baud: 9600}",
       "{kind: recording, file: a.csv, speed: 0, seed: 7, wait_for_file: true, at_end: wait}",
       "{kind: simulation, file: /a.yaml, speed: 2, faults: {}}",
       "{kind: stream}",
       "{kind: stream, from: ''}",
       "{kind: stream, from: [a]}",
       "{kind: stream, from: stdin, format: json, baud: 299, rate_hz: -1, reopen_at_most_s: 0}",
       "{kind: stream, from: stdin, columns: 3}",
       "{kind: stream, from: stdin, columns: {acc_x_g: [1]}}",
       "{kind: stream, from: stdin, columns: {acc_x: 1, ref_qw: 2, gyr_x_counts: 3, mag_y_counts: 4, acc_z_counts: 5}}",
       "{kind: stream, from: stdin, columns: [time_ms, acc_x_g, -, [a], current_A]}",
       "{kind: stream, from: b/../c, format: text, baud: 9600, columns: [time_ms, -, acc_x_counts], "
       "acc_mps2_per_count: 1, gyr_radps_per_count: 2, mag_uT_per_count: 3, rate_hz: 50, reopen_at_most_s: 7}",
       "{kind: stream, from: 'udp://:5', format: frames, mount: {accelerometer: \"-x +z y\", gyroscope: [1, 0, 0, 0], "
       "magnetometer: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]}}",
       "{kind: stream, from: stdin, mount: {accelerometer: \"+x +y\", gyroscope: \"+x +x +z\", magnetometer: \"*x y "
       "z\"}}",
       "{kind: stream, from: stdin, mount: {accelerometer: \"x y z w\", gyroscope: \"+x +y +w\", magnetometer: \"xx y "
       "z\"}}",
       "{kind: stream, from: stdin, mount: {accelerometer: \"-x y z\", gyroscope: [1, 2], magnetometer: [1, 0, 0, "
       ".nan]}}",
       "{kind: stream, from: stdin, mount: {accelerometer: [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]], gyroscope: [[1, 0, 0], "
       "[0, 1, 0], [0, 0, -1]], magnetometer: [[1, 0.0009, 0], [0, 1, 0], [0, 0, 1]]}}",
       "{kind: ros2, imu_topic: '', mag_topic: ''}",
       "{kind: ros2, imu_topic: /a, mag_topic: '', domain: 233, reliable: 2}",
       "{kind: ros2, imu_topic: a/b, mag_topic: c, domain: 3, reliable: true, use_covariance: false}",
       "{kind: iio, devices: {a: b}}",
       "{kind: iio, uri: 'ip:h', devices: one, rate_hz: 5, poll_hz: 6, block_s: 0.5, trigger: t}",
       "{kind: iio, devices: [a, b, [c]], poll_hz: 0.05, block_s: 2}"}) {
    const auto config = io::parse_config(std::string("source: ") + block + "\n", "/folder/f.yaml");
    told += std::string("source: ") + block + "\n";
    if (!config) {
      told += config.error().message + "\n";
      continue;
    }
    const std::string printed = io::print_config(*config);
    told += printed.substr(0, printed.find("\nsensor:")) + "\n" + config->source.description() + " at " +
            config->source.place + (config->source.live() ? " live\n" : "\n");
  }
  test::check_golden_text("sources", told);
}

TEST(GoldenSource, WhatIsMadeOfEveryLine) {
  io::StreamParams counts;
  counts.columns = {{"time_us", "1"},      {"acc_x_counts", "2"}, {"acc_y_counts", "4"}, {"acc_z_counts", "3"},
                    {"gyr_x_counts", "5"}, {"gyr_y_counts", "6"}, {"gyr_z_counts", "7"}, {"mag_x_counts", "8"},
                    {"mag_y_counts", "9"}, {"mag_z_counts", "10"}};
  counts.acc_mps2_per_count = 0.5;
  counts.gyr_radps_per_count = 0.25;
  counts.mag_uT_per_count = 2.0;
  io::StreamParams named;
  named.columns = {{"time_ns", "t"}, {"mag_x_T", "m.0"}, {"mag_y_T", "m.1"}, {"mag_z_T", "m.2"}, {"temp_degC", "deg"}};
  std::ostringstream told;
  const auto tell = [&told](LineFormat& format, const char* line) {
    Reading r;
    if (format.use_header(line)) {
      told << "header | " << line << "\n";
      return;
    }
    const Piece piece = format.parse(line, r);
    told << static_cast<int>(piece);
    if (piece == Piece::kReading)
      told << " t " << r.has_time << " " << r.sample.t_ns << " unit " << r.time_unit_ns << " has " << int{r.sample.has}
           << " " << vec(r.sample.acc_mps2).transpose() << " | " << vec(r.sample.gyr_radps).transpose() << " | "
           << vec(r.sample.mag_uT).transpose() << " | " << r.sample.temp_degC;
    told << " | " << format.unknown_names(line) << " | " << line << "\n";
  };
  for (const io::StreamParams& params : {io::StreamParams{}, counts, named}) {
    LineFormat format(params);
    for (const char* line :
         {"1,2,3,4",
          "1 2 3 4 5 6 7 8 9 10",
          "1;2;3;4;5;6;7;8;9;10;11",
          "  7\t2\t3\t4\t5\t6\t7\t8\t9\t10 ",
          "1,,3,4,5,6,,8,9,10",
          "1,2,3,4,5,6,7,8,9,1e1",
          "1,2,3,4,5,6,7,8,9,.5e",
          "time_ms,acc_x_g,acc_y_g,acc_z_g",
          "5,1,0,-1",
          "5,1,0,-1,7",
          "5,1,0",
          "-5.5,1,0,+1",
          "5,1,nan,2",
          "# note",
          "time_s gyr_z_dps gyr_y_dps gyr_x_dps other",
          "5 1 2 3 x",
          "5 1 2 3 4",
          "t,deg,m.0,m.1,m.2",
          "5,36.5,1e-6,2e-6,3e-6",
          R"({"t": 5, "m": [1e-6, 2e-6, 3e-6], "deg": 36.5})",
          R"({"time_s": 5, "acc_mps2": {"x": 1, "y": 2, "z": 3}, "gyr_dps": [1, 2, 3]})",
          R"({"time_us": 5, "mag_uT": [1, 2], "temp_degC": -4})",
          R"( {"time_ms" : 5.25 , "acc_g" : [ 1 , 0 , 0 ] , "a" : { "b" : [ true , false , null , "}" ] } }	)",
          R"({"acc_x_g": 1, "acc_y_g": 2})",
          R"({"a": tru})",
          R"({"a": nul})",
          R"({"a": 1,})",
          R"({"a": [1,]})",
          R"({a: 1})",
          R"({"a": 1} 2)",
          R"({"a\"b": "c\\", "acc_g": [1, 2, 3]})",
          R"({"acc_g": [1, 2, 3, 4]})",
          R"({"a":{"a":{"a":{"a":{"a":{"a":{"a":{}}}}}}},"temp_degC":1})",
          R"({"a":{"a":{"a":{"a":{"a":{"a":{"a":{"a":{}}}}}}}},"temp_degC":1})"})
      tell(format, line);
  }
  test::check_golden_text("lines", told.str());
}

TEST(GoldenSource, TimesOfUnevenArrivals) {
  std::ostringstream told;
  told << std::fixed;
  for (const double rate_hz : {0.0, 50.0, 2.0}) {
    Stamps stamps(rate_hz);
    for (int k = 0; k < 400; ++k) {
      if (k > 150 && k < 190) continue;  // a pause
      if (k == 250) stamps.restart();    // the cable
      Reading r;
      r.sample.has = k % 5 == 0 ? kMag : kAcc;
      r.has_time = rate_hz == 2.0 && k > 300;  // a sender that learns to tell the time
      r.sample.t_ns = (k % 90) * 20'000'000LL;
      r.time_unit_ns = 1e6;
      const std::int64_t arrival_ns = 5'000'000'000 + k * 20'000'000LL + (k * 7919 % 13) * 900'000LL;
      const bool stamped = stamps.stamp(r, arrival_ns, k == 190 ? 40 : 1);
      if (k % 3 == 0) told << stamped << ' ' << (stamped ? in_seconds(r.sample.t_ns) : 0.0) << '\n';
    }
  }
  test::check_golden("stamps", told.str());
}

TEST(GoldenSource, AddressesAndWordsOfTheKernel) {
  std::ostringstream told;
  for (const char* from : {"", "-", "stdin", "/dev/tty", "a:b", "tcp://1.2.3.4:5", "tcp://:65535", "tcp-listen://:80",
                           "udp://localhost:9", "udp://:0", "udp://:65536", "udp://:5x", "udp://host:5",
                           "udp://1.2.3.4", "http://:80", "://:1", "tcp://1.2.3:4:5"}) {
    const auto address = parse_address(from);
    if (address)
      told << static_cast<int>(address->kind) << ' ' << address->path << ' ' << address->host << ' ' << address->port;
    else
      told << address.error().message;
    told << '\n';
  }
  for (const char* id : {"temp", "temp_ambient", "temp0", "temp1", "accel_x", "anglvel_y", "magn_z", "magn_w", "magn_",
                         "magn_xy", "accel", "incli_x"}) {
    told << id;
    if (const auto kind = iio_channel_kind(id))
      told << ' ' << int{kind->part} << ' ' << kind->axis << ' ' << kind->unit;
    told << '\n';
  }
  for (const char* text : {"1,0,0;0,1,0;0,0,1", " 0, 0, 1 ; 1, 0, 0 ; 0, 1, 0", "1,0,0;0,1,0;0,0", "1,0,0;0,1,x;0,0,1",
                           "2,0,0;0,1,0;0,0,1", "-1,0,0;0,-1,0;0,0,1"}) {
    const auto mount = parse_mount_matrix(text);
    told << text << ": " << (mount ? Vec3(*mount * Vec3(1, 2, 3)) : Vec3(0, 0, 0)).transpose() << '\n';
  }
  const std::uint8_t bytes[] = {0x81, 0x42, 0xc3, 0x24, 0xa5, 0x66, 0xe7, 0x98};
  for (const IioElement& e :
       {IioElement{false, false, 8, 8, 0}, IioElement{false, true, 8, 8, 0}, IioElement{true, true, 12, 16, 4},
        IioElement{false, true, 12, 16, 4}, IioElement{true, false, 24, 32, 8}, IioElement{false, true, 20, 32, 3},
        IioElement{true, true, 40, 64, 24}, IioElement{false, true, 64, 64, 0}})
    told << iio_element_value(bytes, e) << ' ';
  told << IioScale{3.0, 0.5}.apply(7.0) << '\n';
  test::check_golden_text("addresses", told.str());
}

}  // namespace
}  // namespace stillpoint::sources
