#include "sources/serial.h"

#include <fmt/format.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <cerrno>
#include <cstring>
#include <optional>

namespace stillpoint::sources {
namespace {

struct Baud {
  int rate;
  speed_t code;
};
constexpr Baud kBauds[] = {{1200, B1200},       {2400, B2400},       {4800, B4800},       {9600, B9600},
                           {19200, B19200},     {38400, B38400},     {57600, B57600},     {115200, B115200},
                           {230400, B230400},   {460800, B460800},   {500000, B500000},   {576000, B576000},
                           {921600, B921600},   {1000000, B1000000}, {1152000, B1152000}, {1500000, B1500000},
                           {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000}, {3500000, B3500000},
                           {4000000, B4000000}};

std::optional<speed_t> code_of(int baud) {
  for (const Baud& b : kBauds)
    if (b.rate == baud) return b.code;
  return std::nullopt;
}

/// USB serial chips collect for 16 ms unless asked not to. Not every driver can be asked.
void ask_for_low_latency(int fd) {
  serial_struct line{};
  if (ioctl(fd, TIOCGSERIAL, &line) != 0) return;
  line.flags |= ASYNC_LOW_LATENCY;
  ioctl(fd, TIOCSSERIAL, &line);
}

}  // namespace

std::string set_serial_line(int fd, int baud) {
  const auto code = code_of(baud);
  if (!code) {
    std::string known;
    for (const Baud& b : kBauds) known += fmt::format("{}{}", known.empty() ? "" : ", ", b.rate);
    return fmt::format("cannot be set to {} baud; the rates are {}", baud, known);
  }
  termios settings{};
  if (tcgetattr(fd, &settings) != 0) return fmt::format("is no serial line: {}", std::strerror(errno));
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB | PARENB);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  cfsetispeed(&settings, *code);
  cfsetospeed(&settings, *code);
  if (tcsetattr(fd, TCSANOW, &settings) != 0)
    return fmt::format("cannot be set to {} baud: {}", baud, std::strerror(errno));
  ask_for_low_latency(fd);
  tcflush(fd, TCIFLUSH);  // what lay there is of no known age
  return {};
}

}  // namespace stillpoint::sources
