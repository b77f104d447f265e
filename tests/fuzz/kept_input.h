/// The input that is being run, kept on disk when the program ends over it.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace stillpoint::fuzz {

/// From here on what ends the program, a signal or a sanitizer, first writes the input to PREFIXcrash-HASH, or, when
/// one run takes longer than `timeout_s`, to PREFIXtimeout-HASH.
void keep_fatal_inputs(const std::string& prefix, unsigned timeout_s);

/// The bytes must live until the next call.
void now_running(std::span<const std::uint8_t> input) noexcept;
/// Nothing is.
void nothing_running() noexcept;

}  // namespace stillpoint::fuzz
