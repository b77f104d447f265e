/// Little-endian numbers out of a text of bytes. Reading beyond the end gives zeros and is remembered.
#pragma once
#include <cstdint>
#include <cstring>
#include <string_view>

namespace stillpoint::exchange {

class Bytes {
 public:
  explicit Bytes(std::string_view text) : text_(text) {}

  template <class T>
  T number() {
    T value{};
    const std::string_view raw = take(sizeof(T));
    if (raw.size() == sizeof(T)) std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  std::string_view take(std::size_t n) {
    if (n > text_.size() - at_) {
      short_ = true;
      at_ = text_.size();
      return {};
    }
    const std::string_view part = text_.substr(at_, n);
    at_ += n;
    return part;
  }
  /// As many bytes as the 32-bit number before them says.
  std::string_view prefixed() { return take(number<std::uint32_t>()); }
  void skip(std::size_t n) { take(n); }
  void seek(std::size_t at) {
    short_ = short_ || at > text_.size();
    at_ = at < text_.size() ? at : text_.size();
  }

  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] bool done() const { return at_ == text_.size(); }
  [[nodiscard]] bool ran_out() const { return short_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  bool short_ = false;
};

}  // namespace stillpoint::exchange
