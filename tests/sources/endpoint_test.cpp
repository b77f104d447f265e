/// Serial lines at every rate, files, sockets: what opens how, and what is said of what does not.
#include "sources/endpoint.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <termios.h>

#include <array>
#include <fstream>
#include <iostream>

#include "sources/serial.h"
#include "tests/sources/sources_testing.h"

namespace stillpoint::sources {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

Endpoint endpoint(const std::string& from, int baud = 9600) { return {*parse_address(from), baud}; }

TEST(Endpoint, ASerialLineIsSetToTheRateThatIsAskedFor) {
  const Descriptor sensor(posix_openpt(O_RDWR | O_NOCTTY));
  ASSERT_EQ(grantpt(sensor.get()) | unlockpt(sensor.get()), 0);
  const Descriptor line(open(ptsname(sensor.get()), O_RDWR | O_NOCTTY));
  const std::pair<int, speed_t> rates[] = {
      {1200, B1200},       {2400, B2400},       {4800, B4800},       {9600, B9600},       {19200, B19200},
      {38400, B38400},     {57600, B57600},     {115200, B115200},   {230400, B230400},   {460800, B460800},
      {500000, B500000},   {576000, B576000},   {921600, B921600},   {1000000, B1000000}, {1152000, B1152000},
      {1500000, B1500000}, {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000}, {3500000, B3500000},
      {4000000, B4000000}};
  for (const auto& [baud, code] : rates) {
    EXPECT_EQ(set_serial_line(line.get(), baud), "") << baud;
    termios now{};
    ASSERT_EQ(tcgetattr(line.get(), &now), 0);
    EXPECT_EQ(cfgetispeed(&now), code) << baud;
    EXPECT_EQ(cfgetospeed(&now), code) << baud;
    EXPECT_EQ(now.c_lflag & (ICANON | ECHO | ISIG), 0U);
    EXPECT_EQ(now.c_cflag & (CSTOPB | PARENB), 0U);
    EXPECT_EQ(now.c_cflag & (CLOCAL | CREAD | CS8), static_cast<tcflag_t>(CLOCAL | CREAD | CS8));
    EXPECT_EQ(now.c_cc[VMIN], 0);
  }
  EXPECT_THAT(set_serial_line(line.get(), 12345), HasSubstr("cannot be set to 12345 baud; the rates are 1200, 2400, "));
  const Descriptor file(open("/dev/null", O_RDWR));
  EXPECT_THAT(set_serial_line(file.get(), 9600), HasSubstr("is no serial line"));
}

TEST(Endpoint, WhatCannotBeOpenedIsToldByItsReason) {
  const test::ScratchFolder folder;
  std::ofstream(folder / "file") << "text";
  const auto fault = [](const std::string& from) {
    const auto opened = endpoint(from).open();
    EXPECT_FALSE(opened) << from;
    return opened ? Error{} : opened.error();
  };
  EXPECT_EQ(fault(folder / "none").kind, ErrorKind::kNoInput);
  EXPECT_THAT(fault(folder / "none").message, EndsWith("none: No such file or directory"));
  EXPECT_EQ(fault(folder / "file/in").kind, ErrorKind::kUnavailable);
  EXPECT_EQ(fault(folder / ".").kind, ErrorKind::kNoInput);
  EXPECT_THAT(fault(folder / ".").message, HasSubstr("is a folder; name a serial line, a FIFO or a file"));
  // A device that no driver serves, as one that was pulled out.
  if (mknod((folder / "device").c_str(), S_IFCHR | 0600, static_cast<dev_t>(0xfff00)) == 0)
    EXPECT_EQ(fault(folder / "device").kind, ErrorKind::kNoInput);
  else
    std::cerr << "LOUD: SKIPPED, a device without a driver: only root may make one\n";
  EXPECT_EQ(fault("tcp://127.0.0.1:1").kind, ErrorKind::kUnavailable);
  EXPECT_THAT(fault("tcp://127.0.0.1:1").message, HasSubstr("127.0.0.1:1: Connection refused"));
}

TEST(Endpoint, AFileEndsAndASocketIsWaitedFor) {
  const test::ScratchFolder folder;
  std::ofstream(folder / "file") << "text";
  std::array<std::uint8_t, 16> room{};
  std::size_t bytes = 0;
  Endpoint file = endpoint(folder / "file");
  ASSERT_TRUE(file.open());
  EXPECT_TRUE(file.is_open());
  EXPECT_FALSE(file.joins_in_midst());
  EXPECT_FALSE(file.datagrams());
  EXPECT_EQ(file.read(room, 100, bytes), ReadState::kBytes);
  EXPECT_EQ(bytes, 4U);
  EXPECT_EQ(file.read(room, 100, bytes), ReadState::kEnd);
  file.close();
  EXPECT_FALSE(file.is_open());

  const std::string port = std::to_string(test::free_port());
  Endpoint server = endpoint("tcp-listen://:" + port), client = endpoint("tcp://:" + port);
  ASSERT_TRUE(server.open());
  EXPECT_EQ(server.read(room, 1, bytes), ReadState::kNothing);
  ASSERT_TRUE(client.open());
  EXPECT_EQ(server.read(room, 1, bytes), ReadState::kNothing) << "connected, and silent";
  client.close();
  EXPECT_EQ(server.read(room, 1000, bytes), ReadState::kClosed);
  server.close();
  EXPECT_TRUE(server.is_open()) << "it goes on listening";

  Endpoint udp = endpoint("udp://:" + port);
  ASSERT_TRUE(udp.open());
  EXPECT_TRUE(udp.datagrams());
  EXPECT_EQ(udp.read(room, 1, bytes), ReadState::kNothing);
}

/// Closes as a board does that loses its power: the other side is told nothing. False: this takes CAP_NET_ADMIN.
bool vanish(int fd) {
  const int on = 1;
  const bool may = setsockopt(fd, IPPROTO_TCP, TCP_REPAIR, &on, sizeof on) == 0;
  close(fd);
  return may;
}

bool closes_within_10_s(Endpoint& endpoint) {
  std::array<std::uint8_t, 16> room{};
  std::size_t bytes = 0;
  for (int k = 0; k < 100; ++k)
    if (endpoint.read(room, 100, bytes) == ReadState::kClosed) return true;
  return false;
}

TEST(Endpoint, APeerThatVanishesWithoutAWordIsNoticed) {
  const std::uint16_t port = test::free_port();
  sockaddr_in there = test::on_loopback(port);
  std::array<std::uint8_t, 16> room{};
  std::size_t bytes = 0;
  {
    const Descriptor sensor(socket(AF_INET, SOCK_STREAM, 0));
    ASSERT_EQ(bind(sensor.get(), reinterpret_cast<sockaddr*>(&there), sizeof there) | listen(sensor.get(), 1), 0);
    Endpoint client = endpoint("tcp://:" + std::to_string(port));
    ASSERT_TRUE(client.open());
    if (!vanish(accept(sensor.get(), nullptr, nullptr)))
      GTEST_SKIP() << "LOUD: SKIPPED, a peer that vanishes: only with CAP_NET_ADMIN";
    EXPECT_TRUE(closes_within_10_s(client));
  }
  const std::uint16_t other_port = test::free_port();
  there = test::on_loopback(other_port);
  Endpoint server = endpoint("tcp-listen://:" + std::to_string(other_port));
  ASSERT_TRUE(server.open());
  const int sensor = socket(AF_INET, SOCK_STREAM, 0);
  ASSERT_EQ(connect(sensor, reinterpret_cast<sockaddr*>(&there), sizeof there), 0);
  EXPECT_EQ(server.read(room, 100, bytes), ReadState::kNothing) << "connected, and silent";
  ASSERT_TRUE(vanish(sensor));
  EXPECT_TRUE(closes_within_10_s(server));
}

}  // namespace
}  // namespace stillpoint::sources
