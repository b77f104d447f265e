/// The HTTP side of `stillpoint page`: one document, one state, one stream of events, to browsers of this machine only.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "apps/stillpoint/page_document.h"
#include "core/result.h"

namespace stillpoint::app {

/// Called on any thread of the server.
struct PageData {
  std::function<std::string()> state;    ///< JSON in one line, with its line end
  std::function<std::string()> history;  ///< the same, what a new stream begins with
};

/// Listens on 127.0.0.1 alone. Answers GET, and only where the Host is 127.0.0.1 or localhost: a page of another site
/// that lets its own name point here (DNS rebinding) is refused.
class PageServer {
 public:
  static constexpr int kStreams = 8;  ///< at once; the next one is told 503

  /// Port 0: one that is free. Fails (69) when the port cannot be had.
  [[nodiscard]] static Result<std::unique_ptr<PageServer>> create(int port, PageDocument document, PageData data);
  /// Ends every stream.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  [[nodiscard]] int port() const noexcept;
  /// Sends the state to every open stream; it is made once for all, and not at all when there is none.
  void send_event();

 private:
  struct Impl;
  explicit PageServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillpoint::app
