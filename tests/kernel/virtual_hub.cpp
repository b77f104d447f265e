/// A HID sensor hub behind /dev/uhid, for the kernel's own drivers: accelerometer, gyroscope and magnetometer.
/// Commands on standard input, a line each: `plug N` makes the device, each of whose sensors sends N readings from its
/// switch-on and then is quiet; `unplug` takes it away; the end of the input ends the program. What happens is printed.
#include <fcntl.h>
#include <linux/uhid.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <numbers>
#include <string>
#include <vector>

namespace {

using Bytes = std::vector<std::uint8_t>;
using Counts = std::array<std::int16_t, 3>;

std::int64_t now_ns() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

/// As HID writes them: the values of the enumerations count from 1.
constexpr std::uint8_t kNoEvents = 1, kAllEvents = 2, kFullPower = 2, kPowerOff = 6, kReady = 2;

/// The feature report; its bytes go over the wire as they lie here.
struct __attribute__((packed)) Features {
  std::uint8_t id = 0;
  std::uint8_t reporting = kNoEvents, power = kPowerOff, state = kReady;
  std::uint16_t interval_ms = 10, sensitivity = 0;
};

struct __attribute__((packed)) Input {
  std::uint8_t id = 0, state = kReady;
  Counts counts{};
};

/// Items of HID 1.11, 6.2.2: tag and type with the size of the value, then the value.
class Descriptor {
 public:
  Descriptor& item(std::uint8_t tag, std::int64_t value, std::size_t size = 1) {
    bytes_.push_back(static_cast<std::uint8_t>(tag | size));
    for (std::size_t k = 0; k < size; ++k) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
    return *this;
  }
  Descriptor& open(std::uint8_t kind) { return item(kCollection, kind); }
  Descriptor& close() { return item(kEndCollection, 0, 0); }
  Descriptor& usage(std::uint16_t id) { return item(kUsage, id, 2); }
  /// One of `count` named values, of which the first is `first`.
  Descriptor& choice(std::uint8_t main, std::uint16_t of, std::uint16_t first, std::uint8_t count) {
    usage(of).item(kLogicalMin, 1).item(kLogicalMax, count).item(kReportSize, 8).item(kReportCount, 1).open(kLogical);
    for (std::uint16_t k = 0; k < count; ++k) usage(static_cast<std::uint16_t>(first + k));
    return item(main, 0).close();
  }
  Descriptor& number(std::uint8_t main, std::uint16_t id, std::int64_t least, std::int64_t most, int exponent) {
    return usage(id)
        .item(kLogicalMin, least, 2)
        .item(kLogicalMax, most, 2)
        .item(kReportSize, 16)
        .item(kUnitExponent, exponent & 0xf)
        .item(main, 2);
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

  static constexpr std::uint8_t kUsagePage = 0x04, kUsage = 0x08, kLogicalMin = 0x14, kLogicalMax = 0x24,
                                kReportSize = 0x74, kReportId = 0x84, kReportCount = 0x94, kUnitExponent = 0x54,
                                kInput = 0x80, kFeature = 0xb0, kCollection = 0xa0, kEndCollection = 0xc0;
  static constexpr std::uint8_t kPhysical = 0, kApplication = 1, kLogical = 2;

 private:
  Bytes bytes_;
};

/// Low bits of the number of a reading, around zero: each reading says which it is, and the mean stays.
std::int16_t tag(std::uint64_t number) { return static_cast<std::int16_t>(static_cast<int>(number % 256) - 128); }

struct Sensor {
  const char* name;
  std::uint16_t usage, x_usage;
  int exponent;  ///< one count is 10^exponent of what the kernel takes where no unit is named: g, deg/s, milligauss
  Counts (*reading)(std::uint64_t number);

  Features features{};
  std::uint64_t number = 0;  ///< readings sent since the program began
  std::uint64_t left = 0;
  std::int64_t due_ns = 0;
  bool on = false;

  void describe(Descriptor& d) const {
    d.usage(usage).open(Descriptor::kPhysical).item(Descriptor::kReportId, features.id);
    d.choice(Descriptor::kFeature, 0x316, 0x840, 6);         // reporting state
    d.choice(Descriptor::kFeature, 0x319, 0x850, 6);         // power state
    d.choice(Descriptor::kFeature, 0x201, 0x800, 7);         // sensor state
    d.number(Descriptor::kFeature, 0x30e, 0, INT16_MAX, 0);  // report interval, ms
    d.number(Descriptor::kFeature, 0x30f, 0, INT16_MAX, 0);  // sensitivity: 0, every reading is sent
    d.choice(Descriptor::kInput, 0x201, 0x800, 7);
    for (std::uint16_t axis = 0; axis < 3; ++axis)
      d.number(Descriptor::kInput, static_cast<std::uint16_t>(x_usage + axis), INT16_MIN, INT16_MAX, exponent);
    d.close();
  }

  void set(const std::uint8_t* data, std::size_t size) {
    std::memcpy(&features, data, std::min(size, sizeof features));
    const bool wanted = features.reporting == kAllEvents && features.power == kFullPower;
    if (wanted != on) std::printf("%s %s at %u ms\n", wanted ? "on" : "off", name, unsigned{features.interval_ms});
    on = wanted;
  }
  [[nodiscard]] std::int64_t interval_ns() const { return std::int64_t{features.interval_ms} * 1'000'000; }
  [[nodiscard]] bool sends() const { return on && left > 0; }
};

/// After a request the hub is silent for so long. While the kernel handles the answer to one, of whichever sensor, it
/// drops a reading that comes (hid_input_report takes a lock or nothing), and counts it nowhere.
constexpr std::int64_t kSilence_ns = 300'000'000;

constexpr double kTurn_rad = 10.0 * std::numbers::pi / 180.0 * 0.005;  // of a reading: 10 deg/s at 200 Hz

/// Lies flat, turns about z at 10 deg/s, in a field of 20 uT to the north and 43 uT down.
std::array<Sensor, 3> sensors() {
  return {Sensor{"accel_3d", 0x73, 0x453, -4,
                 [](std::uint64_t n) {
                   return Counts{tag(n), 37, 10000};
                 }},
          Sensor{"gyro_3d", 0x76, 0x457, -2,
                 [](std::uint64_t n) {
                   return Counts{-25, tag(n), 1000};
                 }},
          Sensor{"magn_3d", 0x83, 0x485, -1, [](std::uint64_t n) {
                   const double turned_rad = kTurn_rad * static_cast<double>(n);
                   return Counts{static_cast<std::int16_t>(std::lround(2000 * std::sin(turned_rad))),
                                 static_cast<std::int16_t>(std::lround(2000 * std::cos(turned_rad))),
                                 static_cast<std::int16_t>(-4300 + tag(n))};
                 }}};
}

[[noreturn]] void die(const char* what) {
  std::perror(what);
  std::exit(1);
}

class Hub {
 public:
  void plug(std::uint64_t readings) {
    uhid_event event{};
    event.type = UHID_CREATE2;
    auto& create = event.u.create2;
    std::snprintf(reinterpret_cast<char*>(create.name), sizeof create.name, "virtual sensor hub");
    create.bus = 0x03;  // USB
    create.vendor = 0x1209;
    create.product = 0x0001;
    Descriptor d;
    d.item(Descriptor::kUsagePage, 0x20).usage(0x01).open(Descriptor::kApplication);
    for (std::size_t k = 0; k < sensors_.size(); ++k) {
      Sensor& s = sensors_[k];
      s.features = Features{.id = static_cast<std::uint8_t>(k + 1)};
      s.left = readings;
      s.on = false;
      s.describe(d);
    }
    d.close();
    create.rd_size = static_cast<std::uint16_t>(d.bytes().size());
    std::copy(d.bytes().begin(), d.bytes().end(), create.rd_data);
    write(event);
    std::puts("plugged");
  }
  void unplug() {
    uhid_event event{};
    event.type = UHID_DESTROY;
    write(event);
    for (Sensor& s : sensors_) s.on = false;
    std::puts("unplugged");
  }

  [[nodiscard]] int fd() const { return fd_; }

  void answer() {
    uhid_event event{};
    if (read(fd_, &event, sizeof event) <= 0) die("/dev/uhid");
    for (Sensor& s : sensors_) s.due_ns = std::max(s.due_ns, now_ns() + kSilence_ns);
    uhid_event reply{};
    if (event.type == UHID_GET_REPORT) {
      reply.type = UHID_GET_REPORT_REPLY;
      auto& out = reply.u.get_report_reply;
      out.id = event.u.get_report.id;
      if (Sensor* s = find(event.u.get_report.rnum); s == nullptr) {
        out.err = EIO;
      } else if (event.u.get_report.rtype == UHID_FEATURE_REPORT) {
        out.size = sizeof s->features;
        std::memcpy(out.data, &s->features, sizeof s->features);
      } else {
        const Input input = input_of(*s);
        out.size = sizeof input;
        std::memcpy(out.data, &input, sizeof input);
      }
      write(reply);
    } else if (event.type == UHID_SET_REPORT) {
      reply.type = UHID_SET_REPORT_REPLY;
      reply.u.set_report_reply.id = event.u.set_report.id;
      Sensor* s = find(event.u.set_report.rnum);
      reply.u.set_report_reply.err = s == nullptr ? EIO : 0;
      write(reply);
      if (s != nullptr) s->set(event.u.set_report.data, event.u.set_report.size);
    }
  }

  /// Sends what is due. How long until the next reading is; a second where there is none.
  timespec send_due() {
    std::int64_t next_ns = now_ns() + 999'999'999;
    for (Sensor& s : sensors_) {
      if (s.sends() && s.due_ns <= now_ns()) send(s);
      if (s.sends()) next_ns = std::min(next_ns, s.due_ns);
    }
    return {0, static_cast<long>(std::max<std::int64_t>(0, next_ns - now_ns()))};
  }

 private:
  static Input input_of(const Sensor& s) { return {.id = s.features.id, .counts = s.reading(s.number)}; }
  void send(Sensor& s) {
    uhid_event event{};
    event.type = UHID_INPUT2;
    const Input input = input_of(s);
    event.u.input2.size = sizeof input;
    std::memcpy(event.u.input2.data, &input, sizeof input);
    write(event);
    ++s.number;
    longest_late_ns_ = std::max(longest_late_ns_, now_ns() - s.due_ns);
    // Who was kept from running goes on from here: a sensor measures at its times, it does not catch up.
    s.due_ns = std::max(s.due_ns + s.interval_ns(), now_ns());
    if (--s.left > 0) return;
    std::printf("late %.1f s at most\n", 1e-9 * static_cast<double>(longest_late_ns_));
    std::printf("sent %s %llu\n", s.name, static_cast<unsigned long long>(s.number));
  }
  void write(const uhid_event& event) {
    if (::write(fd_, &event, sizeof event) != sizeof event) die("/dev/uhid");
  }
  Sensor* find(std::uint8_t id) {
    for (Sensor& s : sensors_)
      if (s.features.id == id) return &s;
    return nullptr;
  }

  int fd_ = [] {
    const int fd = open("/dev/uhid", O_RDWR | O_CLOEXEC);
    if (fd < 0) die("/dev/uhid");
    return fd;
  }();
  std::array<Sensor, 3> sensors_ = sensors();
  std::int64_t longest_late_ns_ = 0;  ///< of a reading: this program was kept from running
};

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  Hub hub;
  std::string commands;
  for (;;) {
    const timespec wait = hub.send_due();
    pollfd wanted[2] = {{STDIN_FILENO, POLLIN, 0}, {hub.fd(), POLLIN, 0}};
    ppoll(wanted, 2, &wait, nullptr);
    if ((wanted[1].revents & POLLIN) != 0) hub.answer();
    if ((wanted[0].revents & (POLLIN | POLLHUP)) == 0) continue;
    char text[64];
    const ssize_t size = read(STDIN_FILENO, text, sizeof text);
    if (size <= 0) return 0;
    commands.append(text, static_cast<std::size_t>(size));
    for (std::size_t end = 0; (end = commands.find('\n')) != std::string::npos; commands.erase(0, end + 1)) {
      const std::string command = commands.substr(0, end);
      if (command.starts_with("plug ")) hub.plug(std::strtoull(command.c_str() + 5, nullptr, 10));
      if (command == "unplug") hub.unplug();
    }
  }
}
