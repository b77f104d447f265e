/// The little-endian CDR that ROS 2 messages are stored in: numbers aligned to their size, counted from behind the
/// four bytes of the encapsulation header.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "core/types.h"
#include "exchange/bytes.h"

namespace stillpoint::exchange {

class CdrReader {
 public:
  explicit CdrReader(std::string_view message) : bytes_(message.substr(message.size() < 4 ? message.size() : 4)) {
    good_ = message.size() >= 4 && message[0] == 0 && message[1] == 1;
  }
  template <class T>
  T number() {
    bytes_.skip((sizeof(T) - bytes_.at() % sizeof(T)) % sizeof(T));
    return bytes_.number<T>();
  }
  std::string_view text() {
    const std::string_view with_end = bytes_.take(number<std::uint32_t>());
    return with_end.substr(0, with_end.empty() ? 0 : with_end.size() - 1);
  }
  Vec3 vector() {
    const double x = number<double>(), y = number<double>(), z = number<double>();
    return {x, y, z};
  }
  /// std_msgs/Header: its time in ns.
  std::int64_t header() {
    const std::int64_t sec = number<std::int32_t>(), nsec = number<std::uint32_t>();
    text();
    return sec * 1'000'000'000 + nsec;
  }
  void skip_numbers(int count) {
    for (int i = 0; i < count; ++i) number<double>();
  }
  [[nodiscard]] bool good() const { return good_ && !bytes_.ran_out(); }

 private:
  Bytes bytes_;
  bool good_;
};

class CdrWriter {
 public:
  template <class T>
  void number(T value) {
    bytes_.append((sizeof(T) - (bytes_.size() - 4) % sizeof(T)) % sizeof(T), '\0');
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void text(std::string_view t) {
    number(static_cast<std::uint32_t>(t.size() + 1));
    bytes_.append(t);
    bytes_ += '\0';
  }
  void vector(const Array3& v) {
    for (const double x : v) number(x);
  }
  void header(std::int64_t t_ns, std::string_view frame) {
    number(static_cast<std::int32_t>(t_ns / 1'000'000'000));
    number(static_cast<std::uint32_t>(t_ns % 1'000'000'000));
    text(frame);
  }
  void numbers(double value, int count) {
    for (int i = 0; i < count; ++i) number(value);
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_{'\0', '\1', '\0', '\0'};
};

}  // namespace stillpoint::exchange
