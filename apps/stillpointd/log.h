/// What the daemon says: one line an event on standard error, waited for by nobody.
#pragma once
#include <string>

#include "io/log_line.h"

namespace stillpoint::app {

inline void log(const std::string& line) { io::log_line("stillpointd: " + line); }

}  // namespace stillpoint::app
