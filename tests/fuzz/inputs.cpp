#include "tests/fuzz/inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace stillpoint::fuzz {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad() || !in.is_open()) {
    fmt::print(stderr, "{}: cannot be read\n", path.string());
    std::exit(66);
  }
  return text;
}

std::string unescaped(const std::string& quoted) {
  std::string out;
  for (std::size_t i = 0; i < quoted.size(); ++i) {
    if (quoted[i] != '\\' || i + 1 == quoted.size()) {
      out += quoted[i];
    } else if (quoted[i + 1] == 'x' && i + 3 < quoted.size()) {
      out += static_cast<char>(std::stoi(quoted.substr(i + 2, 2), nullptr, 16));
      i += 3;
    } else {
      out += quoted[++i];
    }
  }
  return out;
}

}  // namespace

Inputs read_inputs(const std::vector<std::string>& paths) {
  Inputs out;
  for (const std::string& path : paths) {
    std::vector<fs::path> files{path};
    if (fs::is_directory(path)) {
      out.any_folder = true;
      files.clear();
      for (const auto& entry : fs::directory_iterator(path))
        if (entry.is_regular_file()) files.push_back(entry.path());
      std::sort(files.begin(), files.end());
    }
    for (const auto& file : files) out.texts.push_back(read(file));
  }
  return out;
}

std::vector<std::string> read_dictionary(const std::string& path) {
  std::vector<std::string> out;
  if (path.empty()) return out;
  std::istringstream lines(read(path));
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find('"'), last = line.rfind('"');
    if (line.starts_with('#') || first == last) continue;
    out.push_back(unescaped(line.substr(first + 1, last - first - 1)));
  }
  return out;
}

}  // namespace stillpoint::fuzz
