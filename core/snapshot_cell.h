/// The latest value of one writer for any number of readers (a sequence lock). The writer never waits for a reader;
/// a reader that meets a write in progress gets nothing and keeps its last whole copy.
/// After Boehm, "Can seqlocks get along with programming language memory models?", MSPC 2012: the payload is carried in
/// atomic words, so that a torn copy is discarded without ever having been a data race. The words are stored with
/// release and loaded with acquire instead of standing between two fences: a reader that saw one word of a store
/// then also sees its odd version, and ThreadSanitizer, which does not know fences, can follow.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>

namespace stillpoint {

template <class T>
class SnapshotCell {
  static_assert(std::is_trivially_copyable_v<T>, "the cell copies the value bytewise");

 public:
  /// One writer thread only. Wait-free.
  void store(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint64_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    version_.store(version + 2, std::memory_order_release);
  }

  /// Any thread. Empty before the first store and while one is in progress. Wait-free.
  [[nodiscard]] std::optional<T> try_load() const noexcept {
    const std::uint64_t before = version_.load(std::memory_order_acquire);
    if (before == 0 || (before & 1U) != 0) return std::nullopt;
    std::array<std::uint64_t, kWords> words;
    for (std::size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
    if (version_.load(std::memory_order_relaxed) != before) return std::nullopt;
    T value;
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
    return value;
  }

  /// Any thread. Changes with every store: a reader that has seen this version need not copy again.
  [[nodiscard]] std::uint64_t version() const noexcept { return version_.load(std::memory_order_acquire); }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  std::atomic<std::uint64_t> version_{0};
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace stillpoint
