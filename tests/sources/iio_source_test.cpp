#include "sources/iio_source.h"

#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "sources/iio_device.h"
#include "sources/iio_values.h"
#include "sources/reopening.h"
#include "tests/sources/fake_iiod.h"
#include "tests/sources/sources_testing.h"

namespace stillpoint::sources {
namespace {

using pipeline::Arrival;
using pipeline::SourceState;
using test::FakeDevice;
using test::FakeIiod;

template <class T>
std::string bytes_of(T value, bool big_endian = false) {
  std::string out(sizeof value, '\0');
  std::memcpy(out.data(), &value, sizeof value);
  if (big_endian) std::reverse(out.begin(), out.end());
  return out;
}

std::string channels(const std::string& type, const std::string& format, bool timestamp) {
  std::string xml;
  for (int k = 0; k < 3; ++k)
    xml += "<channel id=\"" + type + "_" + "xyz"[k] + "\" type=\"input\"><scan-element index=\"" + std::to_string(k) +
           "\" format=\"" + format + "\" /><attribute name=\"raw\" filename=\"r\" /><attribute name=\"scale\" " +
           "filename=\"s\" /><attribute name=\"mount_matrix\" filename=\"m\" /></channel>";
  if (timestamp)
    xml +=
        "<channel id=\"timestamp\" type=\"input\"><scan-element index=\"3\" format=\"le:s64/64&gt;&gt;0\" /></channel>";
  return xml;
}

std::map<std::string, std::string> attributes(const std::string& type, const std::string& scale, double rate_hz,
                                              const std::string& mount = "1, 0, 0; 0, 1, 0; 0, 0, 1") {
  std::map<std::string, std::string> out{{"/sampling_frequency", std::to_string(rate_hz)},
                                         {"/current_timestamp_clock", "realtime"}};
  for (const char axis : {'x', 'y', 'z'}) {
    out[type + "_" + axis + "/scale"] = scale;
    out[type + "_" + axis + "/mount_matrix"] = mount;
    out[type + "_" + axis + "/raw"] = axis == 'z' ? "1000" : "0";
  }
  return out;
}

constexpr std::int64_t kDeviceClock_ns = 1'000'000'000'000;  // a clock of its own: it is another machine

/// 16 bits in 32: the upper half holds what belongs to the next axis.
FakeDevice accelerometer(const std::string& scale = "0.0098") {
  return {"iio:device0",
          "accel_3d",
          channels("accel", "le:s16/32&gt;&gt;0", true),
          200.0,
          [](std::int64_t k) {
            std::string scan;
            for (const std::int16_t raw : {std::int16_t{-100}, std::int16_t{200}, std::int16_t{1000}})
              scan += bytes_of(raw) + bytes_of(std::int16_t{0x7a5a});
            return scan + std::string(4, '\0') + bytes_of(kDeviceClock_ns + 5'000'000 * k);
          },
          attributes("accel", scale, 200.0)};
}
FakeDevice gyroscope() {
  return {"iio:device1",
          "gyro_3d",
          channels("anglvel", "be:s12/16&gt;&gt;4", true),
          100.0,
          [](std::int64_t k) {
            std::string scan;
            for (const int raw : {-2048, 1, 2047}) scan += bytes_of(static_cast<std::int16_t>(raw * 16 + 5), true);
            return scan + std::string(2, '\0') + bytes_of(kDeviceClock_ns + 10'000'000 * k);
          },
          attributes("anglvel", "0.001", 100.0)};
}
FakeDevice magnetometer() {
  return {"iio:device2",
          "magn_3d",
          channels("magn", "le:s32/32&gt;&gt;0", false),
          50.0,
          [](std::int64_t) { return bytes_of(200) + bytes_of(0) + bytes_of(-430); },
          attributes("magn", "0.001", 50.0, "0, -1, 0; 1, 0, 0; 0, 0, 1")};
}

io::IioParams params_of(std::uint16_t port) {
  io::IioParams params;
  params.uri = "ip:127.0.0.1:" + std::to_string(port);
  params.block_s = 0.02;
  return params;
}

TEST(IioValues, AnElementsUpperHalfIsMaskedAndItsSignExtended) {
  const std::uint8_t bytes[] = {0x9c, 0xff, 0x5a, 0x7a};
  EXPECT_EQ(iio_element_value(bytes, {false, true, 16, 32, 0}), -100);
  EXPECT_EQ(iio_element_value(bytes, {false, false, 16, 32, 0}), 0xff9c);
  const std::uint8_t shifted[] = {0x80, 0x05};
  EXPECT_EQ(iio_element_value(shifted, {true, true, 12, 16, 4}), -2048);
  const std::uint8_t wide[] = {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff};
  EXPECT_EQ(iio_element_value(wide, {false, true, 64, 64, 0}), -1);
}

TEST(IioValues, ChannelsAndMountMatricesAreReadAsTheKernelWritesThem) {
  EXPECT_EQ(iio_channel_kind("accel_y")->axis, 1U);
  EXPECT_EQ(iio_channel_kind("magn_z")->unit, 100.0);
  EXPECT_EQ(iio_channel_kind("temp")->unit, 1e-3);
  EXPECT_FALSE(iio_channel_kind("accel_w"));
  EXPECT_FALSE(iio_channel_kind("voltage0"));
  const auto mount = parse_mount_matrix("0, -1, 0; 1, 0, 0; 0, 0, 1\n");
  ASSERT_TRUE(mount);
  EXPECT_TRUE(Vec3(*mount * Vec3(1, 2, 3)).isApprox(Vec3(-2, 1, 3)));
  EXPECT_FALSE(parse_mount_matrix("1, 0, 0; 0, 1, 0; 0, 0, -1")) << "it mirrors";
  EXPECT_FALSE(parse_mount_matrix(""));
}

TEST(IioSource, ThreeDevicesBecomeOneSourceThatIsLostAndFoundAgain) {
  const std::uint16_t port = test::free_port();
  FakeIiod iiod({accelerometer(), gyroscope(), magnetometer()}, port);
  ASSERT_TRUE(iiod.listening());
  IioSource source(params_of(port), 0.2);
  Arrival out;
  for (int run = 0; run < 2; ++run) {
    std::map<int, int> count;
    std::map<int, std::int64_t> last_ns;
    for (int k = 0; k < 300; ++k) {
      ASSERT_TRUE(test::eventually_sample(source, out)) << source.report()->try_load()->error.view();
      const RawSample& s = out.sample;
      const Vec3 expected_acc(-0.98, 1.96, 9.8), expected_gyr(-2.048, 0.001, 2.047), expected_mag(0, 20, -43);
      EXPECT_TRUE(s.has != kAcc || vec(s.acc_mps2).isApprox(expected_acc)) << vec(s.acc_mps2);
      EXPECT_TRUE(s.has != kGyr || vec(s.gyr_radps).isApprox(expected_gyr)) << vec(s.gyr_radps);
      EXPECT_TRUE(s.has != kMag || vec(s.mag_uT).isApprox(expected_mag)) << "gauss, turned by the mount matrix";
      EXPECT_TRUE(count[s.has]++ == 0 || s.t_ns > last_ns[s.has]);
      last_ns[s.has] = s.t_ns;
      EXPECT_LT(std::abs(s.t_ns - out.arrival_ns), 1'000'000'000) << "all on this machine's clock";
    }
    EXPECT_GT(count[kAcc], 1.5 * count[kGyr]);
    EXPECT_GT(count[kGyr], 0);
    EXPECT_EQ(iiod.written("accel_3d /current_timestamp_clock"), "monotonic");
    iiod.stop();
    EXPECT_TRUE(test::eventually_state(source, out, SourceState::kGone));
    EXPECT_EQ(source.report()->try_load()->link, LinkState::kGone);
    iiod.start();
  }
}

TEST(IioSource, ADeviceThatItsDriverMakesLaterJoinsTheOthers) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{}, {"accel_3d", "gyro_3d"}}) {
    FakeIiod late({accelerometer()}, test::free_port());
    io::IioParams params = params_of(late.port());
    params.devices = names;
    IioSource source(params, 0.2);
    Arrival out;
    ASSERT_TRUE(test::eventually_sample(source, out));
    EXPECT_EQ(out.sample.has, kAcc);
    late.add(gyroscope());
    bool joined = false;
    for (int k = 0; k < 4000 && !joined; ++k) joined = test::eventually_sample(source, out) && out.sample.has == kGyr;
    EXPECT_TRUE(joined) << "with " << names.size() << " names";
    EXPECT_EQ(source.report()->try_load()->opened, 1U) << "the accelerometer went on";
  }
}

TEST(IioSource, AfterEachLossTheWaitIsShortAgain) {
  const std::uint16_t port = test::free_port();
  FakeIiod iiod({accelerometer()}, port);
  IioSource source(params_of(port), 60.0);
  Arrival out;
  std::vector<std::int64_t> away_ns;
  for (int loss = 0; loss < 7; ++loss) {
    ASSERT_TRUE(test::eventually_sample(source, out, 30.0));
    iiod.stop();
    ASSERT_TRUE(test::eventually_state(source, out, SourceState::kGone));
    iiod.start();
    const std::int64_t began_ns = monotonic_ns();
    ASSERT_TRUE(test::eventually_sample(source, out, 30.0));
    away_ns.push_back(monotonic_ns() - began_ns);
  }
  // Doubled with each loss, the last three would be sixteen, 32 and 64 times as long as the first wait.
  EXPECT_LT(*std::min_element(away_ns.end() - 3, away_ns.end()), 8 * Reopening::kFirst_ns);
}

/// Another range was set meanwhile: the same raw values are twice the force.
TEST(IioSource, ADeviceThatComesBackWithAnotherScaleIsReadInThatOne) {
  const std::uint16_t port = test::free_port();
  auto iiod = std::make_unique<FakeIiod>(std::vector{accelerometer()}, port);
  IioSource source(params_of(port), 0.2);
  Arrival out;
  ASSERT_TRUE(test::eventually_sample(source, out));
  EXPECT_TRUE(vec(out.sample.acc_mps2).isApprox(Vec3(-0.98, 1.96, 9.8)));
  iiod->stop();
  ASSERT_TRUE(test::eventually_state(source, out, SourceState::kGone));
  iiod = nullptr;
  iiod = std::make_unique<FakeIiod>(std::vector{accelerometer("0.0196")}, port);
  ASSERT_TRUE(test::eventually_sample(source, out));
  EXPECT_TRUE(vec(out.sample.acc_mps2).isApprox(Vec3(-1.96, 3.92, 19.6))) << vec(out.sample.acc_mps2);
}

/// It has a scale, and does not tell it while its driver is busy: a raw value taken for m/s^2 would be 1000 of them.
TEST(IioSource, WhatDoesNotTellItsScaleIsNotRead) {
  const std::uint16_t port = test::free_port();
  FakeDevice silent = accelerometer();
  silent.attributes.erase("accel_y/scale");
  auto iiod = std::make_unique<FakeIiod>(std::vector{silent}, port);
  IioSource source(params_of(port), 0.2);
  Arrival out;
  EXPECT_FALSE(test::eventually_sample(source, out, 0.5));
  const std::string why(source.report()->try_load()->error.view());
  EXPECT_NE(why.find("accel_3d does not tell the scale and offset of accel_y"), std::string::npos) << why;
  iiod = nullptr;
  iiod = std::make_unique<FakeIiod>(std::vector{accelerometer()}, port);
  ASSERT_TRUE(test::eventually_sample(source, out));
  EXPECT_TRUE(vec(out.sample.acc_mps2).isApprox(Vec3(-0.98, 1.96, 9.8)));
}

TEST(IioSource, BesideOneThatDoesNotTellItsScaleTheOthersAreRead) {
  const std::uint16_t port = test::free_port();
  FakeDevice silent = magnetometer();
  silent.attributes.erase("magn_x/scale");
  const FakeIiod iiod({accelerometer(), silent}, port);
  IioSource source(params_of(port), 0.2);
  Arrival out;
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(test::eventually_sample(source, out));
  EXPECT_TRUE(vec(out.sample.acc_mps2).isApprox(Vec3(-0.98, 1.96, 9.8)));
  const std::string why(source.report()->try_load()->error.view());
  EXPECT_NE(why.find("magn_3d does not tell"), std::string::npos) << why;
}

TEST(IioSource, AThermometerThatDoesNotTellItsScaleIsLeftOut) {
  const std::uint16_t port = test::free_port();
  FakeDevice warm = accelerometer();
  warm.channels_xml +=
      R"(<channel id="temp" type="input"><attribute name="raw" filename="r" /><attribute name="scale" filename="s" /></channel>)";
  const FakeIiod iiod({warm}, port);
  IioSource source(params_of(port), 0.2);
  Arrival out;
  ASSERT_TRUE(test::eventually_sample(source, out));
  EXPECT_TRUE(vec(out.sample.acc_mps2).isApprox(Vec3(-0.98, 1.96, 9.8)));
  EXPECT_EQ(out.sample.has & kTemp, 0);
}

TEST(IioSource, TheKernelKeepsASecondOfWhatIsNotFetched) {
  const std::uint16_t port = test::free_port();
  FakeIiod iiod({accelerometer()}, port);
  IioSource source(params_of(port), 0.2);  // blocks of 0.02 s
  Arrival out;
  ASSERT_TRUE(test::eventually_sample(source, out));
  EXPECT_EQ(iiod.written("accel_3d BUFFERS_COUNT"), "50");
}

TEST(IioSource, WhatCameWhileADeviceStartedIsTaken) {
  const std::uint16_t port = test::free_port();
  FakeDevice device = accelerometer();
  device.opening_s = 0.3;  // a driver that waits until its sensor is awake, and collects meanwhile
  std::atomic<std::int64_t> asked_ns{0};
  device.scan = [scan = device.scan, &asked_ns](std::int64_t k) {
    if (k == 0) asked_ns = monotonic_ns();
    return scan(k).replace(16, 8, bytes_of(asked_ns - 250'000'000 + 5'000'000 * k));
  };
  FakeIiod iiod({device}, port);
  IioSource source(params_of(port), 0.2);
  Arrival out;
  ASSERT_TRUE(test::eventually_sample(source, out));
  EXPECT_EQ(out.sample.t_ns, asked_ns - 250'000'000) << "the first of all";
}

TEST(IioSource, ADeviceWithoutABufferIsPolled) {
  const std::uint16_t port = test::free_port();
  FakeDevice polled = accelerometer();
  for (std::size_t at = 0; (at = polled.channels_xml.find("<scan-element")) != std::string::npos;)
    polled.channels_xml.erase(at, polled.channels_xml.find("/>", at) + 2 - at);
  FakeIiod iiod({polled}, port);
  io::IioParams params = params_of(port);
  params.poll_hz = 200.0;
  IioSource source(params, 0.2);
  Arrival out;
  std::int64_t first_ns = 0;
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(test::eventually_sample(source, out));
    if (k == 0) first_ns = out.sample.t_ns;
  }
  EXPECT_NEAR(out.sample.acc_mps2[2], 9.8, 1e-9);
  EXPECT_GT(out.sample.t_ns - first_ns, 49 * 4'000'000);
  EXPECT_NE(source.report()->try_load()->error.view().find("has no buffer"), std::string::npos);
}

TEST(IioSource, WhatLayInTheBufferFromBeforeIsDropped) {
  const std::uint16_t port = test::free_port();
  FakeDevice device = accelerometer();
  device.scan = [scan = device.scan](std::int64_t k) {
    std::string bytes = scan(k);
    if (k < 3) bytes.replace(16, 8, bytes_of(kDeviceClock_ns - 60'000'000'000 + k));
    return bytes;
  };
  FakeIiod iiod({device}, port);
  IioSource source(params_of(port), 0.2);
  Arrival out;
  ASSERT_TRUE(test::eventually_sample(source, out));
  EXPECT_LT(out.arrival_ns - out.sample.t_ns, 1'000'000'000);
}

TEST(IioSource, SaysWhatIsThereWhenTheNameIsWrong) {
  const std::uint16_t port = test::free_port();
  FakeIiod iiod({accelerometer()}, port);
  io::IioParams params = params_of(port);
  params.devices = {"lsm6dsx_accel"};
  IioSource source(params, 0.2);
  Arrival out;
  EXPECT_FALSE(test::eventually_sample(source, out, 1.0));
  EXPECT_NE(source.report()->try_load()->error.view().find("accel_3d"), std::string::npos)
      << source.report()->try_load()->error.view();
}

}  // namespace
}  // namespace stillpoint::sources
