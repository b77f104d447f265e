/// DDS-Security: who a participant is, what it may do, and that nobody else reads it. The `security:` block of `dds:`,
/// and what is wrong with the files that it names.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "core/fields.h"

namespace stillpoint::io {

struct SecurityParams {
  std::string folder{};
  std::string identity_ca{}, certificate{}, private_key{}, governance{}, permissions_ca{}, permissions{};

  template <class P = SecurityParams>
  static constexpr auto fields() {
    return std::tuple{
        field("folder", &P::folder,
              "holds the six files, as scripts/dds_keys.sh and ROS 2's keystores name them; empty: every key below, or "
              "no security at all"),
        field("identity_ca", &P::identity_ca, "certificate of who says who is who; empty: folder/identity_ca.cert.pem"),
        field("certificate", &P::certificate, "who this one is; empty: folder/cert.pem"),
        field("private_key", &P::private_key, "proves it, without a passphrase; empty: folder/key.pem"),
        field("governance", &P::governance, "what is protected in the domain, signed; empty: folder/governance.p7s"),
        field("permissions_ca", &P::permissions_ca,
              "certificate of who signed the other two; empty: folder/permissions_ca.cert.pem"),
        field("permissions", &P::permissions,
              "what this one may publish and read, signed; empty: folder/permissions.p7s"),
    };
  }
};

struct SecurityFile {
  std::string SecurityParams::*path;
  const char* key;
  const char* name;  ///< in the folder
};
inline constexpr std::array kSecurityFiles{
    SecurityFile{&SecurityParams::identity_ca, "identity_ca", "identity_ca.cert.pem"},
    SecurityFile{&SecurityParams::certificate, "certificate", "cert.pem"},
    SecurityFile{&SecurityParams::private_key, "private_key", "key.pem"},
    SecurityFile{&SecurityParams::governance, "governance", "governance.p7s"},
    SecurityFile{&SecurityParams::permissions_ca, "permissions_ca", "permissions_ca.cert.pem"},
    SecurityFile{&SecurityParams::permissions, "permissions", "permissions.p7s"}};

/// Whether anything is named.
[[nodiscard]] bool is_secured(const SecurityParams& params);
/// With the folder's files where no other is named.
[[nodiscard]] SecurityParams with_folder(const SecurityParams& params);

/// Why Fast DDS would refuse these files, in words, one entry a fault; it says no more than "initialization error".
[[nodiscard]] std::vector<std::string> check(const SecurityParams& params);
/// What works and should not be so: a private key that everybody may read.
[[nodiscard]] std::vector<std::string> warnings(const SecurityParams& params);

}  // namespace stillpoint::io
