#include "apps/stillpoint/page_server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>

namespace stillpoint::app {
namespace {

/// Threads beside those of the streams: for the document, the state and refusals.
constexpr int kOtherThreads = 4;

/// The newest event, handed to every stream that waits for it. A stream that is slow misses events; none piles up.
class Events {
 public:
  void send(std::string event) {
    const std::lock_guard lock(mutex_);
    newest_ = std::make_shared<const std::string>(std::move(event));
    ++number_;
    changed_.notify_all();
  }
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  /// How many were sent so far: what a stream that begins now need not be told.
  std::uint64_t sent() {
    const std::lock_guard lock(mutex_);
    return number_;
  }
  /// The first event after number `seen`, which is set to its number. Nothing when the server ends.
  std::shared_ptr<const std::string> next(std::uint64_t& seen) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || number_ > seen; });
    if (closed_) return nullptr;
    seen = number_;
    return newest_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<const std::string> newest_;
  std::uint64_t number_ = 0;
  bool closed_ = false;
};

bool is_host_here(const httplib::Request& request) {
  if (request.get_header_value_count("Host") != 1) return false;
  const std::string host = request.get_header_value("Host");
  const std::string name = host.substr(0, host.find(':'));
  const bool has_port = name.size() < host.size();
  const bool is_number = std::all_of(host.begin() + static_cast<std::ptrdiff_t>(name.size()) + (has_port ? 1 : 0),
                                     host.end(), [](char c) { return c >= '0' && c <= '9'; });
  return (name == "127.0.0.1" || name == "localhost") && is_number;
}

void refuse(httplib::Response& response, int status, const std::string& why) {
  response.status = status;
  response.set_content("stillpoint page: " + why + "\n", "text/plain");
}

/// Every request passes here first, whatever it asks for.
httplib::Server::HandlerResponse guard(const httplib::Request& request, httplib::Response& response) {
  if (!is_host_here(request)) {
    refuse(response, 403, "the Host of a request must be 127.0.0.1 or localhost");
    return httplib::Server::HandlerResponse::Handled;
  }
  if (request.method != "GET") {
    response.set_header("Allow", "GET");
    refuse(response, 405, "only GET is answered; nothing can be changed from here");
    return httplib::Server::HandlerResponse::Handled;
  }
  return httplib::Server::HandlerResponse::Unhandled;
}

/// Without SO_REUSEPORT, which the library would set: with it two servers share a port, and nobody is told.
void set_options(socket_t socket) {
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

}  // namespace

struct PageServer::Impl {
  Impl(PageDocument its_document, PageData its_data) : document(std::move(its_document)), data(std::move(its_data)) {}

  void set_up() {
    server.new_task_queue = [] { return new httplib::ThreadPool(kStreams + kOtherThreads); };
    server.set_socket_options(set_options);
    server.set_keep_alive_max_count(1);  // a browser that keeps a connection would keep a thread
    server.set_keep_alive_timeout(2);    // also for a connection that asks nothing
    server.set_read_timeout(2);
    server.set_write_timeout(2);
    server.set_payload_max_length(1024);
    server.set_tcp_nodelay(true);
    server.set_default_headers({{"Content-Security-Policy", document.policy},
                                {"X-Content-Type-Options", "nosniff"},
                                {"Referrer-Policy", "no-referrer"},
                                {"Cross-Origin-Resource-Policy", "same-origin"},
                                {"Cache-Control", "no-store"}});
    server.set_pre_routing_handler(guard);
    server.set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (response.body.empty()) refuse(response, response.status, "there are /, /events and /state");
    });
    server.Get("/", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(document.html, "text/html; charset=utf-8");
    });
    server.Get("/state", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(data.state(), "application/json");
    });
    server.Get("/events", [this](const httplib::Request&, httplib::Response& response) { open_stream(response); });
  }

  void open_stream(httplib::Response& response) {
    if (++streams > kStreams) {
      --streams;
      response.set_header("Retry-After", "5");
      refuse(response, 503, fmt::format("{} streams are open, more are not served; close a page", kStreams));
      return;
    }
    // The history goes out with the first event; after that each event once.
    auto begun = std::make_shared<bool>(false);
    auto seen = std::make_shared<std::uint64_t>(events.sent());
    const auto provide = [this, begun, seen](std::size_t, httplib::DataSink& sink) {
      if (!*begun) {
        *begun = true;
        const std::string first = "retry: 1000\nevent: history\ndata: " + data.history() + "\n";
        return sink.write(first.data(), first.size());
      }
      const auto event = events.next(*seen);
      return event != nullptr && sink.write(event->data(), event->size());
    };
    response.set_chunked_content_provider("text/event-stream", provide, [this](bool) { --streams; });
  }

  PageDocument document;
  PageData data;
  Events events;
  std::atomic<int> streams{0};
  httplib::Server server;
  int port = 0;
  std::thread thread;
};

Result<std::unique_ptr<PageServer>> PageServer::create(int port, PageDocument document, PageData data) {
  auto impl = std::make_unique<Impl>(std::move(document), std::move(data));
  impl->set_up();
  errno = 0;
  const int bound = port == 0                                      ? impl->server.bind_to_any_port("127.0.0.1")
                    : impl->server.bind_to_port("127.0.0.1", port) ? port
                                                                   : -1;
  if (bound < 0)
    return fail(ErrorKind::kUnavailable,
                fmt::format("port {} of 127.0.0.1 cannot be had: {}; give another one with --port, or 0 for a free one",
                            port, errno == 0 ? "the system does not say why" : std::strerror(errno)));
  impl->port = bound;
  impl->thread = std::thread([server = &impl->server] { server->listen_after_bind(); });
  return std::unique_ptr<PageServer>(new PageServer(std::move(impl)));
}

PageServer::PageServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

PageServer::~PageServer() {
  impl_->events.close();
  // Before it runs, it cannot be stopped.
  for (int i = 0; i < 1000 && !impl_->server.is_running(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  impl_->server.stop();
  impl_->thread.join();
}

int PageServer::port() const noexcept { return impl_->port; }

void PageServer::send_event() {
  if (impl_->streams > 0) impl_->events.send("data: " + impl_->data.state() + "\n");
}

}  // namespace stillpoint::app
