/// Where the project lies, for tests and benches that read its files. One object file knows: were it in everybody's
/// compile line, a compiler cache could not serve another checkout.
#pragma once
#include <string>

namespace stillpoint {

/// `path` below the project's root.
[[nodiscard]] std::string in_source(const std::string& path);

}  // namespace stillpoint
