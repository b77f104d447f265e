/// What the daemon says: one line an event on standard error.
#pragma once
#include <cstdio>
#include <string>

namespace stillpoint::app {

/// A closed or full standard error loses the line; that is no reason to end (fmt::print would throw).
inline void log(const std::string& line) { std::fputs(("stillpointd: " + line + '\n').c_str(), stderr); }

}  // namespace stillpoint::app
