#include "host/production/page_server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/files/file_descriptor.h"
#include "host/files/signals_held.h"
#include "selfproj/files/user_error.h"

namespace selfproj::production {
namespace {

constexpr std::size_t kThreads = 16;  // of which those that watch take one each
constexpr int kReadS = 5;             // a request must be there within so many seconds
constexpr int kWriteS = 3;            // a browser that takes nothing for so long has gone; it may come again
constexpr std::size_t kMaxPayload = 1024;
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

struct PageServer::Implementation {
  httplib::Server server;
  std::vector<File> files;
  std::optional<Stream> messages;
  std::string token;
  std::atomic<bool> end{false};
  std::thread thread;

  bool admit(const httplib::Request& request, httplib::Response& response) {
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

  void stream(httplib::Response& response) {
    if (!messages->begin()) {
      messages->finish();
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
          const auto message = messages->next(*number);
          if (message == nullptr) {
            static const std::string nothing(8, '\0');  // an empty message, so that a dead connection is noticed
            return sink.write(nothing.data(), nothing.size());
          }
          return sink.write(message->data(), message->size());
        },
        [this](bool) { messages->finish(); });
  }

  void set_up() {
    server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server.set_read_timeout(kReadS);
    server.set_write_timeout(kWriteS);
    server.set_keep_alive_timeout(1);
    server.set_payload_max_length(kMaxPayload);
    server.set_socket_options([](int socket) {
      const int yes = 1;  // but not SO_REUSEPORT, with which two programs could have one port
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server.set_default_headers({{"Content-Security-Policy", kPolicy},
                                {"X-Content-Type-Options", "nosniff"},
                                {"Referrer-Policy", "no-referrer"},
                                {"Cache-Control", "no-store"}});
    server.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server.set_exception_handler([](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
      refuse(response, 500, "this went wrong\n");
    });
    for (const File& file : files) {
      server.Get(file.path, [&file](const httplib::Request&, httplib::Response& response) {
        response.set_content(*file.text(), file.type);
      });
    }
    if (messages) {
      server.Get(messages->path, [this](const httplib::Request&, httplib::Response& response) { stream(response); });
    }
  }
};

std::string page_token(const Endpoint& endpoint) {
  if (endpoint.is_loopback()) {
    return {};
  }
  std::random_device device;
  std::string token;
  for (int i = 0; i < 4; ++i) {
    token += fmt::format("{:08x}", static_cast<std::uint32_t>(device()));
  }
  return token;
}

std::string page_url(const Endpoint& endpoint, const std::string& token) {
  return fmt::format("http://{}/{}", endpoint.text(), token.empty() ? "" : "?token=" + token);
}

PageServer::File PageServer::fixed(const std::string& path, const std::string& type, std::string text) {
  return {path, type, [kept = std::make_shared<const std::string>(std::move(text))] { return kept; }};
}

PageServer::PageServer(const std::string& option, const Endpoint& endpoint, const std::string& token,
                       std::vector<File> files, std::optional<Stream> stream)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& i = *implementation_;
  i.files = std::move(files);
  i.files.push_back(fixed("/favicon.ico", "image/x-icon", ""));
  i.messages = std::move(stream);
  i.token = token;
  i.set_up();
  errno = 0;
  if (!i.server.bind_to_port(endpoint.address, endpoint.port)) {
    throw UserError(option + " " + endpoint.text(), files::error_text(errno != 0 ? errno : EADDRINUSE));
  }
  const files::SignalsHeld held;
  i.thread = std::thread([&i] { i.server.listen_after_bind(); });
  while (!i.server.is_running()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

PageServer::~PageServer() {
  implementation_->end = true;
  implementation_->server.stop();
  implementation_->thread.join();
}

}  // namespace selfproj::production
