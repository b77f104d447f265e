/// How a command ends: what it says on standard error, its exit code, and who may write to standard output.
#pragma once
#include <algorithm>
#include <cstdio>
#include <initializer_list>
#include <string>

#include "core/result.h"
#include "io/quote.h"

namespace stillpoint::app {

/// A line on standard error. Where that is closed or full the line is lost; fmt::print would end the program. Messages
/// name what stands in files, and no file may steer the terminal.
inline void tell(const std::string& line) { std::fputs((io::without_controls(line) + '\n').c_str(), stderr); }

/// Prints the error to standard error and gives its exit code.
inline int report(const Error& error) {
  tell("stillpoint: " + error.message);
  return static_cast<int>(error.kind);
}

/// Whether one of these files is "-", standard output, where then nothing else may be written. Fails (64) when two are.
inline Result<bool> is_standard_output(std::initializer_list<std::string> files) {
  const auto count = std::count(files.begin(), files.end(), "-");
  if (count > 1)
    return fail(ErrorKind::kUsage, "only one output can be '-', standard output; name files for the others");
  return count == 1;
}

}  // namespace stillpoint::app
