/// The command line tool in a scratch folder of its own.
#pragma once
#include <string>

#include "tests/apps/apps_testing.h"

namespace stillpoint::test {

class ToolInFolder : public ::testing::Test {
 protected:
  /// The exit code; what it said on standard error is in `told_`.
  int tool(const std::string& arguments) {
    const int code = run("cd " + (folder_ / ".") + " && " + STILLPOINT + " " + arguments, folder_ / "err");
    told_ = read_file(folder_ / "err");
    return code;
  }
  ScratchFolder folder_;
  std::string told_;
};

}  // namespace stillpoint::test
