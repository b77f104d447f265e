/// Keys for the tests of DDS-Security, made by the script that users run.
#pragma once
#include <gtest/gtest.h>

#include <string>

#include "io/dds_params.h"
#include "tests/apps/apps_testing.h"
#include "tests/dds/dds_testing.h"
#include "tests/source_folder.h"

namespace stillpoint::test {

class Keys {
 public:
  /// NAME[=ROLE] of each participant.
  explicit Keys(const std::string& participants) { make(participants); }
  void make(const std::string& participants, const std::string& environment = {}) const {
    const int code =
        run(environment + " " + in_source("scripts/dds_keys.sh ") + (folder_ / "keys") + " " + participants,
            folder_ / "log");
    EXPECT_EQ(code, 0) << read_file(folder_ / "log");
  }
  /// `find` becomes `replace` in a file that is to be signed again by make().
  void edit(const std::string& file, const std::string& find, const std::string& replace) const {
    std::string text = read_file(*this / file);
    const auto at = text.find(find);
    ASSERT_NE(at, std::string::npos) << find << " is not in " << file;
    write_file(*this / file, text.replace(at, find.size(), replace));
  }
  [[nodiscard]] std::string operator/(const std::string& name) const { return folder_ / ("keys/" + name); }

 private:
  ScratchFolder folder_;
};

/// A participant of the test's domain; without a folder it has no keys.
inline io::DdsParams with_keys(const std::string& folder, const char* transport = "udp") {
  io::DdsParams params = test_params(transport);
  params.security.folder = folder;
  return params;
}

}  // namespace stillpoint::test
