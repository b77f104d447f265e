/// Keys whose value is one of a few words.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "io/quote.h"
#include "io/yaml.h"

namespace stillpoint::io {

template <class E>
using Words = std::vector<std::pair<std::string, E>>;

template <class E>
void read_word(const YAML::Node& node, E& out, const Words<E>& words, const std::string& key, YamlFaults& faults) {
  std::vector<std::string> known;
  for (const auto& [word, value] : words) {
    if (node.IsScalar() && node.Scalar() == word) {
      out = value;
      return;
    }
    known.push_back(word);
  }
  const std::string given = node.IsScalar() ? node.Scalar() : "";
  faults.add(node, fmt::format("'{}' cannot be {}{}", key, node.IsScalar() ? quote(given) : "a list or a map",
                               suggestion(given, known)));
}

/// "not set" for a value without a word.
template <class E>
[[nodiscard]] std::string word_of(E value, const Words<E>& words) {
  for (const auto& [word, known] : words)
    if (known == value) return word;
  return "not set";
}

}  // namespace stillpoint::io
