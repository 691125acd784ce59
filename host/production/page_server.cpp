#include "host/production/page_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <poll.h>
#include <strings.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/types.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <list>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/driver/clock.h"
#include "host/files/file_descriptor.h"
#include "host/files/give_way.h"
#include "host/files/signals_held.h"
#include "host/production/clients.h"
#include "host/production/endpoint.h"
#include "selfproj/files/user_error.h"

namespace selfproj::production {
namespace {

constexpr std::int64_t kPatienceNs = 5'000'000'000;  // with a client that makes no progress
constexpr std::int64_t kSilenceNs = 1'000'000'000;   // of the stream; then an empty message, to notice who has gone
constexpr int kSweepMs = 100;
constexpr std::size_t kBlock = 32768;                     // of an answer, which goes out in such blocks
constexpr std::size_t kMaxHeld = std::size_t{16} << 20U;  // bytes that are kept for slow clients alone

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

// Whether a browser that believes to speak with this host speaks with this machine: another site's name that leads
// here is none of ours, whatever it begins with.
bool is_this_machine(const std::string& host, const Endpoint& endpoint) {
  constexpr std::uint32_t kLoopback = 127;
  const std::size_t colon = host.rfind(':');
  const bool port = colon != std::string::npos && host.find_first_not_of("0123456789", colon + 1) == std::string::npos;
  const std::string name = host.substr(0, port ? colon : std::string::npos);
  in_addr address{};
  return strcasecmp(name.c_str(), "localhost") == 0 || name == "[::1]" ||
         strcasecmp(name.c_str(), endpoint.host().c_str()) == 0 ||
         (inet_pton(AF_INET, name.c_str(), &address) == 1 && ntohl(address.s_addr) >> 24U == kLoopback);
}

std::string value_of(MHD_Connection* connection, MHD_ValueKind kind, const std::string& name) {
  const char* const value = MHD_lookup_connection_value(connection, kind, name.c_str());
  return value == nullptr ? "" : value;
}

bool has_body(MHD_Connection* connection) {
  return !value_of(connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_CONTENT_LENGTH).empty() ||
         !value_of(connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_TRANSFER_ENCODING).empty();
}

MHD_Result reply(MHD_Connection* connection, unsigned status, MHD_Response* response, const std::string& type) {
  if (response == nullptr) {
    return MHD_NO;  // closes the connection
  }
  for (const auto& [name, value] : {std::pair{"Content-Type", type.c_str()},
                                    {"Content-Security-Policy", kPolicy},
                                    {"X-Content-Type-Options", "nosniff"},
                                    {"Referrer-Policy", "no-referrer"},
                                    {"Cache-Control", "no-store"}}) {
    MHD_add_response_header(response, name, value);
  }
  const MHD_Result result = MHD_queue_response(connection, status, response);
  MHD_destroy_response(response);  // the connection has it
  return result;
}

MHD_Result refuse(MHD_Connection* connection, unsigned status, std::string text) {
  return reply(connection, status, MHD_create_response_from_buffer(text.size(), text.data(), MHD_RESPMEM_MUST_COPY),
               "text/plain");
}

}  // namespace

class PageServer::Implementation {
 public:
  Implementation(const std::string& option, Endpoint endpoint, std::string token, std::vector<File> files,
                 std::optional<Stream> stream)
      : endpoint_(std::move(endpoint)),
        token_(std::move(token)),
        cookie_("selfproj-token-" + std::to_string(endpoint_.port)),
        files_(std::move(files)),
        stream_(std::move(stream)),
        listening_(listen_at(option, endpoint_)),
        wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
        daemon_(MHD_start_daemon(MHD_USE_EPOLL | MHD_USE_NO_LISTEN_SOCKET | MHD_ALLOW_SUSPEND_RESUME, 0, nullptr,
                                 nullptr, &on_request, this, MHD_OPTION_NOTIFY_CONNECTION, &on_connection, this,
                                 MHD_OPTION_NOTIFY_COMPLETED, &on_completed, this, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
                                 kMaxRequest, MHD_OPTION_CONNECTION_LIMIT, static_cast<unsigned>(2 * most_),
                                 MHD_OPTION_END)) {
    if (daemon_ == nullptr || wake_.number() < 0) {
      throw UserError(option + " " + endpoint_.text(), "the server does not start: " + files::error_text(errno));
    }
    const files::SignalsHeld held;
    thread_ = std::thread([this] { run(); });
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;
  ~Implementation() {
    end_ = true;
    wake();
    thread_.join();
  }

  void wake() { static_cast<void>(eventfd_write(wake_.number(), 1)); }

 private:
  // A client, and what it is being sent.
  struct PageClient : Client {
    Implementation* server = nullptr;
    MHD_Connection* connection = nullptr;
    Text text;  // of which so many bytes are sent
    std::size_t sent = 0;
    std::uint64_t number = 0;  // of the newest message that it got
    bool watches = false;      // the stream
    bool waits = false;        // for a message or a text: libmicrohttpd then leaves the connection alone
  };

  void run() {
    const int epoll = MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd;
    files::give_way();
    Duty duty;
    bool full = false;
    std::int64_t swept_ns = driver::now_ns();
    while (!end_) {
      std::vector<pollfd> sockets{{epoll, POLLIN, 0}, {wake_.number(), POLLIN, 0}};
      for (const files::FileDescriptor& one : listening_) {
        sockets.push_back({one.number(), static_cast<std::int16_t>(full ? 0 : POLLIN), 0});
      }
      MHD_UNSIGNED_LONG_LONG due = kSweepMs;
      static_cast<void>(MHD_get_timeout(daemon_, &due));
      poll(sockets.data(), sockets.size(),
           static_cast<int>(std::min<MHD_UNSIGNED_LONG_LONG>(due, full ? kAcceptAgainMs : kSweepMs)));
      eventfd_t count = 0;
      if (eventfd_read(wake_.number(), &count) == 0) {
        go_on_after(0);
      }
      full = false;
      for (const files::FileDescriptor& one : listening_) {
        full = !accept_clients(
                   one.number(), most_, clients_, driver::now_ns(),
                   [this](int socket, const SocketAddress& from) { add(socket, from); },
                   [this](Clients<PageClient>::iterator client) { drop(client); }) ||
               full;
      }
      MHD_run(daemon_);
      closed_.clear();
      if (driver::now_ns() - swept_ns > kSweepMs * std::int64_t{1'000'000}) {
        swept_ns = driver::now_ns();
        go_on_after(kSilenceNs);
        drop_the_slow(swept_ns);
        limit_held();
      }
      duty.rest();
    }
    go_on_after(0);  // none may wait when the server ends
    MHD_run(daemon_);
    MHD_stop_daemon(daemon_);
  }

  void add(int socket, const SocketAddress& from) {
    PageClient& client = clients_[socket];
    client.machine = machine_of(from);
    client.since_ns = driver::now_ns();
    client.server = this;
    if (MHD_add_connection(daemon_, socket, from.generic(), from.size) == MHD_NO) {  // it closes the socket
      clients_.erase(socket);
    }
  }

  // Libmicrohttpd closes the socket when it notices.
  void drop(Clients<PageClient>::iterator client) {
    shutdown(client->first, SHUT_RDWR);
    client->second.text.reset();
    go_on(client->second);
    leaving_.insert(clients_.extract(client));
  }

  // Until go_on(), or the next wake().
  static void wait(PageClient& client) {
    client.waits = true;
    MHD_suspend_connection(client.connection);
  }

  static void go_on(PageClient& client) {
    if (client.waits) {
      client.waits = false;
      MHD_resume_connection(client.connection);
    }
  }

  // Those who have waited for so long get what there is.
  void go_on_after(std::int64_t ns) {
    const std::int64_t now = driver::now_ns();
    for (auto& [socket, client] : clients_) {
      if (now - client.since_ns >= ns) {
        go_on(client);
      }
    }
  }

  void drop_the_slow(std::int64_t now) {
    for (auto i = clients_.begin(); i != clients_.end();) {
      const auto client = i++;
      if (now - client->second.since_ns > kPatienceNs) {
        drop(client);
      }
    }
  }

  // Who has waited longest goes where too much is kept for slow clients.
  void limit_held() {
    std::vector<Clients<PageClient>::iterator> holders;
    for (auto i = clients_.begin(); i != clients_.end(); ++i) {
      if (i->second.text != nullptr) {
        holders.push_back(i);
      }
    }
    std::sort(holders.begin(), holders.end(),
              [](const auto& a, const auto& b) { return a->second.since_ns > b->second.since_ns; });
    std::set<const std::string*> held;
    std::size_t bytes = 0;
    for (const auto& holder : holders) {
      const Text& text = holder->second.text;
      bytes += held.insert(text.get()).second ? text->size() : 0;
      if (bytes > kMaxHeld) {
        drop(holder);
      }
    }
  }

  // --- what libmicrohttpd calls ---

  static void on_connection(void* self, MHD_Connection* connection, void** client,
                            MHD_ConnectionNotificationCode code) {
    auto* const server = static_cast<Implementation*>(self);
    const int socket = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
      PageClient& made = server->clients_[socket];
      made.connection = connection;
      *client = &made;
    } else {  // the answer that it may have ends after this
      server->closed_.push_back(server->clients_.extract(socket));
      server->closed_.push_back(server->leaving_.extract(socket));
    }
  }

  static MHD_Result on_request(void* self, MHD_Connection* connection, const char* path, const char* method,
                               const char* /*version*/, const char* /*data*/, std::size_t* /*size*/,
                               void** request) noexcept {
    try {
      PageClient& client = client_of(connection);
      if (*request == nullptr) {
        *request = &client;
        client.number = 0;
        // Only what is answered at the second call leaves the connection open, but that is after the body.
        if (!has_body(connection)) {
          return MHD_YES;
        }
      }
      return static_cast<Implementation*>(self)->answer(client, path, method);
    } catch (const std::exception&) {
      return refuse(connection, MHD_HTTP_INTERNAL_SERVER_ERROR, "this went wrong\n");
    }
  }

  static void on_completed(void* /*self*/, MHD_Connection* connection, void** /*request*/,
                           MHD_RequestTerminationCode /*code*/) {
    client_of(connection).since_ns = driver::now_ns();
  }

  // The next bytes of an answer. It is called when the client has taken those before.
  static ssize_t on_content(void* of, std::uint64_t /*position*/, char* buffer, std::size_t size) {
    PageClient& client = *static_cast<PageClient*>(of);
    if (client.text == nullptr) {  // dropped
      return MHD_CONTENT_READER_END_WITH_ERROR;
    }
    if (client.sent == client.text->size()) {
      if (!client.watches) {
        return MHD_CONTENT_READER_END_OF_STREAM;
      }
      if (!client.server->next_message(client)) {
        return 0;
      }
    }
    const std::size_t count = std::min(size, client.text->size() - client.sent);
    std::copy_n(client.text->data() + client.sent, count, buffer);
    client.sent += count;
    client.since_ns = driver::now_ns();
    return static_cast<ssize_t>(count);
  }

  static void on_end_of_content(void* of) {
    PageClient& client = *static_cast<PageClient*>(of);
    client.text.reset();
    if (client.watches) {
      client.watches = false;
      client.server->stream_->finish();
    }
  }

  static PageClient& client_of(MHD_Connection* connection) {
    return *static_cast<PageClient*>(
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)->socket_context);
  }

  MHD_Result answer(PageClient& client, const std::string& path, const std::string& method) {
    MHD_Connection* const connection = client.connection;
    if (method != MHD_HTTP_METHOD_GET && method != MHD_HTTP_METHOD_HEAD) {
      return refuse(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "only GET and HEAD are served\n");
    }
    if (has_body(connection)) {
      return refuse(connection, MHD_HTTP_BAD_REQUEST, "a request for a page has no body\n");
    }
    const bool with_token = !token_.empty() && same(value_of(connection, MHD_GET_ARGUMENT_KIND, "token"), token_);
    if (token_.empty() && !is_this_machine(value_of(connection, MHD_HEADER_KIND, "Host"), endpoint_)) {
      return refuse(connection, MHD_HTTP_FORBIDDEN, "this page is for this machine alone\n");
    }
    if (!token_.empty() && !with_token && !same(value_of(connection, MHD_COOKIE_KIND, cookie_), token_)) {
      return refuse(connection, MHD_HTTP_FORBIDDEN, "the address needs its token\n");
    }
    const bool watches = stream_ && path == stream_->path;
    const auto file = std::find_if(files_.begin(), files_.end(), [&](const File& one) { return one.path == path; });
    if (!watches && file == files_.end()) {
      return refuse(connection, MHD_HTTP_NOT_FOUND, "there is nothing here\n");
    }
    static const Text none = std::make_shared<const std::string>();
    client.text = watches ? none : file->text(client.number);
    if (client.text == nullptr) {
      if (end_) {
        return MHD_NO;
      }
      wait(client);
      return MHD_YES;
    }
    client.sent = 0;
    client.since_ns = driver::now_ns();
    limit_held();
    MHD_Response* const response = MHD_create_response_from_callback(watches ? MHD_SIZE_UNKNOWN : client.text->size(),
                                                                     kBlock, &on_content, &client, &on_end_of_content);
    client.watches = watches && response != nullptr;
    if (client.watches) {
      stream_->begin();
    }
    if (with_token && response != nullptr) {
      const std::string cookie = cookie_ + "=" + token_ + "; HttpOnly; SameSite=Strict; Path=/";
      MHD_add_response_header(response, MHD_HTTP_HEADER_SET_COOKIE, cookie.c_str());
    }
    return reply(connection, MHD_HTTP_OK, response, watches ? "application/octet-stream" : file->type);
  }

  // Gives a client that watches its next message. Returns false if it waits for one.
  bool next_message(PageClient& client) {
    static const Text empty = std::make_shared<const std::string>(8, '\0');
    client.text = stream_->next(client.number);
    client.sent = 0;
    if (client.text == nullptr) {
      client.text = empty;
      if (!end_ && driver::now_ns() - client.since_ns < kSilenceNs) {
        client.sent = empty->size();
        wait(client);
        return false;
      }
    }
    return true;
  }

  const std::size_t most_ = max_clients();
  const Endpoint endpoint_;
  const std::string token_;
  const std::string cookie_;  // its name: two lines on one machine have a cookie each
  const std::vector<File> files_;
  const std::optional<Stream> stream_;
  const std::list<files::FileDescriptor> listening_;
  const files::FileDescriptor wake_;
  MHD_Daemon* const daemon_;
  std::atomic<bool> end_{false};

  // Of the thread:
  Clients<PageClient> clients_;
  Clients<PageClient> leaving_;  // dropped; libmicrohttpd has not closed them yet
  std::vector<Clients<PageClient>::node_type> closed_;
  std::thread thread_;
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
  return fmt::format("http://{}:{}/{}", endpoint.host_to_open(), endpoint.port, token.empty() ? "" : "?token=" + token);
}

PageServer::File PageServer::fixed(const std::string& path, const std::string& type, std::string text) {
  return {path, type, [kept = std::make_shared<const std::string>(std::move(text))](std::uint64_t&) { return kept; }};
}

PageServer::PageServer(const std::string& option, const Endpoint& endpoint, const std::string& token,
                       std::vector<File> files, std::optional<Stream> stream) {
  files.push_back(fixed("/favicon.ico", "image/x-icon", ""));
  implementation_ = std::make_unique<Implementation>(option, endpoint, token, std::move(files), std::move(stream));
}

PageServer::~PageServer() = default;

void PageServer::wake() { implementation_->wake(); }

}  // namespace selfproj::production
