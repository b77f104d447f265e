/// What a discovered law is in words: its unit, its drivers, how long it is, and which mechanisms of sensors behave so.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/result.h"
#include "laws/expression.h"

namespace stillpoint::diag {

/// Mechanisms that are known to behave like this law, in plain words; empty where none is known.
[[nodiscard]] std::vector<std::string> mechanisms_of(const laws::Node& law, const std::string& sensor);

/// The law behind "unknown:", the engine's own products in the words of the grammar. Reads back where it is a law.
[[nodiscard]] std::string law_text(const std::string& effect);

/// The law itself, of a table its driver; nullopt where what stands behind "unknown:" is none.
[[nodiscard]] std::optional<laws::Node> law_tree(const std::string& effect);

/// Whether it is switched on at a moment and off by a driver: then it begins and ends for no more reason than a law in
/// a window.
[[nodiscard]] bool is_a_window_itself(const std::string& effect);

/// The member "law" of a finding (docs/formats.md); nullopt where its effect is no discovered law.
[[nodiscard]] std::optional<nlohmann::ordered_json> law_json(const Finding& finding);

}  // namespace stillpoint::diag
