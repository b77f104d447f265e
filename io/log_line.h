/// Lines on standard error that nobody waits for. A pipe that is not read, a terminal that is held or a full disk costs
/// lines, never the caller's time: a thread of its own writes, behind a bounded queue.
#pragma once
#include <string>

namespace stillpoint::io {

/// Any thread but the sensor's: it takes a short lock. A line end is added. Where the queue is full the line is lost,
/// and how many were is said when there is room again.
void log_line(std::string line);

/// Waits until all that was said is written, at most so long. False: standard error takes nothing.
bool flush_log(double timeout_s);

}  // namespace stillpoint::io
