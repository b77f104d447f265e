/// Inputs and words of a harness, from files in libFuzzer's formats.
#pragma once
#include <string>
#include <vector>

namespace stillpoint::fuzz {

struct Inputs {
  std::vector<std::string> texts;  ///< sorted by path, so that a seed means the same everywhere
  bool any_folder = false;
};

/// Of files, and of folders all the files right inside. Ends the program (66) where one cannot be read.
[[nodiscard]] Inputs read_inputs(const std::vector<std::string>& paths);

/// Lines of "word", name="word" or # comment, with \\, \" and \xNN; empty for no path.
[[nodiscard]] std::vector<std::string> read_dictionary(const std::string& path);

}  // namespace stillpoint::fuzz
