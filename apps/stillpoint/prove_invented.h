/// `stillpoint prove --only invented`: laws that nobody listed, drawn sealed, solved unseen, judged on fresh motion.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

namespace stillpoint::app {

inline constexpr const char* kInvented = "invented";

/// `room`: a folder for the solver's files. Gives the exit code.
[[nodiscard]] int prove_invented(const std::string& salt, std::size_t cases, bool quick,
                                 const std::filesystem::path& room);

}  // namespace stillpoint::app
