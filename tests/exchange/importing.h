/// What an import gives, or why it gives nothing.
#pragma once
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "exchange/import.h"

namespace stillpoint::test {

inline exchange::Imported read(const std::string& path, const exchange::ImportOptions& options = {}) {
  auto imported = exchange::import_recording(path, options);
  EXPECT_TRUE(imported) << (imported ? "" : imported.error().message);
  return imported ? *imported : exchange::Imported{};
}

inline std::string refusal(const std::string& path, const exchange::ImportOptions& options = {}) {
  const auto imported = exchange::import_recording(path, options);
  EXPECT_FALSE(imported);
  return imported ? "" : imported.error().message;
}

inline std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& l : lines) text += l + "\n";
  return text;
}

}  // namespace stillpoint::test
