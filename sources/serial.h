/// A serial line: 8 data bits, no parity, 1 stop bit, raw, no flow control, as little delay as the driver offers.
#pragma once
#include <string>

namespace stillpoint::sources {

/// What is wrong with it, empty when the line is set. `fd` is an open tty.
[[nodiscard]] std::string set_serial_line(int fd, int baud);

}  // namespace stillpoint::sources
