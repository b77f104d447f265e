#include "sources/stream_source.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include "core/clock.h"
#include "tests/sources/sources_testing.h"

namespace stillpoint::sources {
namespace {

using pipeline::Arrival;
using pipeline::SourceState;
using test::eventually_sample;
using test::ScratchFolder;

constexpr const char* kHeader = "time_ms,acc_x_mps2,acc_y_mps2,acc_z_mps2\n";

io::StreamParams from(const std::string& address) {
  io::StreamParams params;
  params.from = address;
  return params;
}

StreamSource source(const io::StreamParams& params) {
  auto made = StreamSource::create(params, 0.2);
  EXPECT_TRUE(made) << made.error().message;
  return std::move(*made);
}

void send(int fd, const std::string& text) {
  ASSERT_EQ(write(fd, text.data(), text.size()), static_cast<ssize_t>(text.size()));
}

TEST(StreamSource, ASerialLineIsReadUnpluggedAndFoundAgain) {
  const ScratchFolder folder;
  const std::string link = folder / "ttyIMU";  // as udev keeps it, whatever number the device gets
  const auto plug = [&link] {
    const int fd = posix_openpt(O_RDWR | O_NOCTTY);
    EXPECT_EQ(grantpt(fd) | unlockpt(fd), 0);
    std::filesystem::remove(link);
    std::filesystem::create_symlink(ptsname(fd), link);
    return fd;
  };
  StreamSource stream = source(from(link));
  Arrival out;
  EXPECT_EQ(stream.next(out), SourceState::kNothing) << "not there yet: waited for";

  int sensor = plug();
  ASSERT_FALSE(eventually_sample(stream, out, 0.4));
  send(sensor, std::string(kHeader) + "1,0,0,9.8\n2,0,0,9.8\n");
  ASSERT_TRUE(eventually_sample(stream, out));
  EXPECT_EQ(out.sample.t_ns, 1'000'000);
  EXPECT_LT(std::abs(monotonic_ns() - out.arrival_ns), 1'000'000'000);
  ASSERT_TRUE(eventually_sample(stream, out));
  const std::int64_t last_ns = out.sample.t_ns;

  close(sensor);
  EXPECT_TRUE(test::eventually_state(stream, out, SourceState::kGone));
  EXPECT_EQ(stream.report()->try_load()->link, LinkState::kGone);
  sensor = plug();
  for (int k = 0; k < 20 && !eventually_sample(stream, out, 0.1); ++k) send(sensor, "1,0,0,9.8\n2,0,0,9.8\n");
  EXPECT_EQ(stream.report()->try_load()->link, LinkState::kThere);
  EXPECT_GT(out.sample.t_ns, last_ns + 10'000'000) << "its clock began anew: the time away is kept";
  close(sensor);
}

/// A FIFO's end to write to, once the stream has opened the other; negative: it never has.
int writer_of(const std::string& fifo, StreamSource& stream) {
  int fd = -1;
  Arrival out;
  for (int k = 0; k < 50 && fd < 0; ++k) {
    stream.next(out);
    fd = open(fifo.c_str(), O_WRONLY | O_NONBLOCK);
  }
  return fd;
}

TEST(StreamSource, AFifoIsReadWriterAfterWriter) {
  const ScratchFolder folder;
  const std::string path = folder / "fifo";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  StreamSource stream = source(from(path));
  Arrival out;
  EXPECT_EQ(stream.next(out), SourceState::kNothing);
  for (int writer = 0; writer < 3; ++writer) {
    const int fd = writer_of(path, stream);
    ASSERT_GE(fd, 0);
    send(fd, std::string(kHeader) + std::to_string(10 * writer + 10) + ",0,0,9.8\n");
    ASSERT_TRUE(eventually_sample(stream, out)) << writer;
    close(fd);
    ASSERT_TRUE(test::eventually_state(stream, out, SourceState::kGone)) << writer;
  }
}

TEST(StreamSource, LinesThatAreNoReadingsAreToldWhileTheyCome) {
  const ScratchFolder folder;
  const std::string path = folder / "fifo";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  StreamSource stream = source(from(path));
  Arrival out;
  const int fd = writer_of(path, stream);
  ASSERT_GE(fd, 0);
  for (int k = 0; k < 100; ++k) {
    send(fd, "1,0,0,9.8\n");
    EXPECT_EQ(stream.next(out), SourceState::kNothing);
    usleep(1000);
  }
  EXPECT_GT(stream.report()->try_load()->ignored, 10U);
  close(fd);
}

TEST(StreamSource, AFileEnds) {
  const ScratchFolder folder;
  std::ofstream(folder / "a.csv") << kHeader << "1,0,0,9.8\n2,0,0,9.8";
  StreamSource stream = source(from(folder / "a.csv"));
  Arrival out;
  EXPECT_TRUE(eventually_sample(stream, out));
  EXPECT_TRUE(test::eventually_state(stream, out, SourceState::kEnd)) << "a cut line is no reading";
}

TEST(StreamSource, UdpTakesADatagramForALineAndTcpForAStream) {
  const std::uint16_t port = test::free_port();
  const sockaddr_in to = test::on_loopback(port);
  Arrival out;

  StreamSource datagrams = source(from("udp://:" + std::to_string(port)));
  EXPECT_EQ(datagrams.next(out), SourceState::kNothing);
  const int udp = socket(AF_INET, SOCK_DGRAM, 0);
  const std::string line = R"({"time_ms":5,"acc_g":[0,0,1]})";
  ASSERT_GT(sendto(udp, line.data(), line.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  ASSERT_TRUE(eventually_sample(datagrams, out));
  EXPECT_EQ(out.sample.t_ns, 5'000'000);
  close(udp);

  StreamSource server = source(from("tcp-listen://:" + std::to_string(port)));
  EXPECT_EQ(server.next(out), SourceState::kNothing);
  for (int peer = 0; peer < 2; ++peer) {
    const int tcp = socket(AF_INET, SOCK_STREAM, 0);
    ASSERT_EQ(connect(tcp, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    send(tcp, std::string(kHeader) + std::to_string(peer + 1) + ",0,");
    EXPECT_FALSE(eventually_sample(server, out, 0.2)) << "half a line";
    send(tcp, "0,9.8\n");
    ASSERT_TRUE(eventually_sample(server, out));
    close(tcp);
    ASSERT_TRUE(test::eventually_state(server, out, SourceState::kGone));
  }
}

TEST(StreamSource, AClientThatWaitsTakesThePlaceOfASilentOneAndOfNoOther) {
  const std::uint16_t port = test::free_port();
  const sockaddr_in to = test::on_loopback(port);
  const auto client = [&to] {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    return fd;
  };
  Arrival out;
  StreamSource server = source(from("tcp-listen://:" + std::to_string(port)));
  EXPECT_EQ(server.next(out), SourceState::kNothing);
  const int first = client();
  send(first, kHeader);
  const int second = client();
  send(second, std::string(kHeader) + "1000000,7,0,9.8\n");
  for (int k = 1; k <= 25; ++k) {  // longer than a silent one keeps its place
    send(first, std::to_string(100 * k) + ",0,0,9.8\n");
    ASSERT_TRUE(eventually_sample(server, out));
    EXPECT_EQ(out.sample.acc_mps2[0], 0.0) << "the first one speaks";
    usleep(100'000);
  }
  ASSERT_TRUE(eventually_sample(server, out, 5.0)) << "the first one is silent";
  EXPECT_EQ(out.sample.acc_mps2[0], 7.0);
  close(first);
  close(second);
}

TEST(StreamSource, SaysWhyADeviceCannotBeOpened) {
  const auto error_of = [](const std::string& address) {
    StreamSource stream = source(from(address));
    Arrival out;
    stream.next(out);
    return std::string(stream.report()->try_load()->error.view());
  };
  EXPECT_NE(error_of("/nowhere/ttyUSB0").find("/nowhere/ttyUSB0: No such file"), std::string::npos);
  EXPECT_NE(error_of("/tmp").find("is a folder"), std::string::npos);
  EXPECT_NE(error_of("/dev/zero").find("is no serial line"), std::string::npos);
  EXPECT_NE(error_of("tcp://:1").find("nobody listens there"), std::string::npos);
}

}  // namespace
}  // namespace stillpoint::sources
