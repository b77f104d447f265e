/// What a function returns that may fail outside the hot path: a value, or an Error that says where, what and what to
/// do. A bug is not an Error: SP_EXPECTS stops the process, in every build.
#pragma once
#include <cstdio>
#include <cstdlib>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace stillpoint {

/// The values are the exit codes of the programs (sysexits.h).
enum class ErrorKind : int {
  kThreshold = 1,
  kUsage = 64,
  kBadData = 65,
  kNoInput = 66,
  kUnavailable = 69,
  kCannotCreate = 73,
  kBadConfig = 78,
};

struct Error {
  ErrorKind kind = ErrorKind::kBadData;
  std::string message;  ///< "file:line:column: what is wrong; what to do"; several faults stand on several lines
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorKind kind, std::string message) {
  return tl::unexpected<Error>(Error{kind, std::move(message)});
}

}  // namespace stillpoint

#define SP_EXPECTS(condition)                                                              \
  do {                                                                                     \
    if (!(condition)) [[unlikely]] {                                                       \
      std::fprintf(stderr, "%s:%d: broken promise: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                        \
    }                                                                                      \
  } while (false)
