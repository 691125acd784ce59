#include "host/line/live_server.h"

#include <httplib.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "host/io/file_descriptor.h"
#include "host/io/input_file.h"
#include "host/io/signals_held.h"
#include "host/io/user_error.h"
#include "host/line/live_files.h"

namespace selfproj {
namespace {

constexpr std::size_t kThreads = 16;  // of which those that watch take one each
constexpr int kReadS = 5;             // a request must be there within so many seconds
constexpr int kWriteS = 3;            // a browser that takes nothing for so long has gone; it may come again
constexpr std::size_t kMostPayload = 1024;
constexpr const char* kCookie = "selfproj-token=";

constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:";

// Whether the texts are equal, in a time that does not tell where they differ.
bool same(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return difference == 0;
}

std::string cookie_of(const httplib::Request& request) {
  const std::string cookies = request.get_header_value("Cookie");
  const std::size_t at = cookies.find(kCookie);
  if (at == std::string::npos) {
    return {};
  }
  const std::size_t begin = at + std::string(kCookie).size();
  return cookies.substr(begin, cookies.find(';', begin) - begin);
}

// Whether a browser that believes to speak with this host speaks with this machine: another site's name that leads
// here is none of ours.
bool is_this_machine(const std::string& host) {
  const std::string name = host.substr(0, host.rfind(':'));
  return name == "localhost" || name.rfind("127.", 0) == 0;
}

void refuse(httplib::Response& response, int status, const char* text) {
  response.status = status;
  response.set_content(text, "text/plain");
}

}  // namespace

struct LiveServer::Implementation {
  httplib::Server server;
  Content content;
  std::string token;
  std::string three;  // the text of three.js; empty: it is not installed
  std::atomic<bool> end{false};
  std::thread thread;

  bool judge(const httplib::Request& request, httplib::Response& response) {
    if (request.method != "GET" && request.method != "HEAD") {
      refuse(response, 405, "only GET and HEAD are served\n");
      return false;
    }
    if (token.empty()) {
      if (!is_this_machine(request.get_header_value("Host"))) {
        refuse(response, 403, "this page is for this machine alone\n");
        return false;
      }
      return true;
    }
    if (request.has_param("token") && same(request.get_param_value("token"), token)) {
      response.set_header("Set-Cookie", kCookie + token + "; HttpOnly; SameSite=Strict; Path=/");
      return true;
    }
    if (!same(cookie_of(request), token)) {
      refuse(response, 403, "the address needs its token\n");
      return false;
    }
    return true;
  }

  void serve_text(const char* path, const std::string& text, const char* type) {
    server.Get(
        path, [text, type](const httplib::Request&, httplib::Response& response) { response.set_content(text, type); });
  }

  void stream(httplib::Response& response) {
    if (!content.begin()) {
      content.finish();
      refuse(response, 503, "too many watch already\n");
      return;
    }
    auto number = std::make_shared<std::uint64_t>(0);
    response.set_chunked_content_provider(
        "application/octet-stream",
        [this, number](std::size_t, httplib::DataSink& sink) {
          if (end) {
            return false;
          }
          const auto message = content.next(*number);
          if (message == nullptr) {
            static const std::string nothing(8, '\0');  // an empty message, so that a dead connection is noticed
            return sink.write(nothing.data(), nothing.size());
          }
          return sink.write(message->data(), message->size());
        },
        [this](bool) { content.finish(); });
  }

  void set_up() {
    server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server.set_read_timeout(kReadS);
    server.set_write_timeout(kWriteS);
    server.set_keep_alive_timeout(1);
    server.set_payload_max_length(kMostPayload);
    server.set_socket_options([](int socket) {
      const int yes = 1;  // but not SO_REUSEPORT, with which two programs could have one port
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server.set_default_headers({{"Content-Security-Policy", kPolicy},
                                {"X-Content-Type-Options", "nosniff"},
                                {"Referrer-Policy", "no-referrer"},
                                {"Cache-Control", "no-store"}});
    server.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      return judge(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server.set_exception_handler([](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
      refuse(response, 500, "this went wrong\n");
    });
    serve_text("/", kLiveHtml, "text/html; charset=utf-8");
    serve_text("/live.js", kLiveJs, "text/javascript; charset=utf-8");
    serve_text("/live.css", kLiveCss, "text/css; charset=utf-8");
    serve_text("/favicon.ico", "", "image/x-icon");
    server.Get("/three.js", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(three, "text/javascript; charset=utf-8");
    });
    server.Get("/part", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(*content.part(), "application/octet-stream");
    });
    server.Get("/stream", [this](const httplib::Request&, httplib::Response& response) { stream(response); });
  }
};

LiveServer::LiveServer(const Endpoint& endpoint, const std::string& token, Content content)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& i = *implementation_;
  i.content = std::move(content);
  i.token = token;
  try {
    i.three = read_input(SELFPROJ_THREE_JS, std::size_t{1} << 24U);
  } catch (const UserError&) {
    i.three.clear();  // the page says that there is no 3-D view
  }
  i.set_up();
  errno = 0;
  if (!i.server.bind_to_port(endpoint.address, endpoint.port)) {
    throw UserError("--live " + endpoint.text(), error_text(errno != 0 ? errno : EADDRINUSE));
  }
  const SignalsHeld held;
  i.thread = std::thread([&i] { i.server.listen_after_bind(); });
  while (!i.server.is_running()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

LiveServer::~LiveServer() {
  implementation_->end = true;
  implementation_->server.stop();
  implementation_->thread.join();
}

}  // namespace selfproj
