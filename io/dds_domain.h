/// DDS domains of this machine: which are in use, and one for whoever wants to be alone (demo, measurements, tests).
#pragma once

namespace stillpoint::io {

/// Whether a participant of this machine, of whatever vendor, listens for discovery in this domain (0 to 232): its
/// multicast port is 7400 + 250 domain (RTPS 2.2, 9.6.1.1).
[[nodiscard]] bool is_domain_in_use(int domain) noexcept;

/// A domain that nobody of this machine was in when it was first asked for, and that no other process is given while
/// this one lives. 1 to 100, as the ports of higher ones may be taken by any connection; 0 when all are in use.
[[nodiscard]] int own_domain() noexcept;

}  // namespace stillpoint::io
