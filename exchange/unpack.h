/// Files as they come from phones and laptops: plain, gzipped, zipped, or a folder of tables.
#pragma once
#include <string>
#include <vector>

#include "core/result.h"

namespace stillpoint::exchange {

struct NamedText {
  std::string name;  ///< as a message shows it: the file, and inside an archive the member
  std::string text;
};

/// The file, or its members, unpacked; of a folder the files in it and in four levels of folders below. Members of
/// macOS, hidden ones, pictures and films are left out. Fails with 66 (not there) or 65 (damaged, encrypted, or more
/// than 4 GB unpacked).
[[nodiscard]] Result<std::vector<NamedText>> read_unpacked(const std::string& path);

/// What a gzip stream holds.
[[nodiscard]] Result<std::string> gunzip(const std::string& packed, const std::string& name);
/// The members of a zip archive.
[[nodiscard]] Result<std::vector<NamedText>> unzip(const std::string& archive, const std::string& name);

}  // namespace stillpoint::exchange
