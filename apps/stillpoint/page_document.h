/// The page as one HTML file, and the policy that lets a browser run nothing but what stands in it.
#pragma once
#include <string>

namespace stillpoint::app {

struct PageDocument {
  std::string html;
  std::string policy;  ///< Content-Security-Policy: style and script by their hashes, nothing else but our own events
};

[[nodiscard]] PageDocument page_document();

}  // namespace stillpoint::app
