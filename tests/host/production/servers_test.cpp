// Clients that drip, stay silent, ask for too much or take nothing: the page and the Modbus server serve the others,
// keep little, and end at once.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/driver/clock.h"
#include "host/files/file_descriptor.h"
#include "host/production/endpoint.h"
#include "host/production/modbus_server.h"
#include "host/production/page_server.h"
#include "selfproj/files/user_error.h"

namespace selfproj::test {
namespace {

using production::Endpoint;
using production::PageServer;

constexpr std::int64_t kMs = 1'000'000;
// Below the five seconds that the page's server gives a client which makes no progress, and the ten that the Modbus
// server gives a silent one: what a server does sooner, it does without waiting for such a client. How much sooner is a
// matter of the machine, and of what else it does.
constexpr std::int64_t kNoWaitMs = 4000;

void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

// A connection to this machine, from one of its addresses.
class Peer {
 public:
  explicit Peer(const Endpoint& endpoint, std::uint32_t from = INADDR_LOOPBACK)
      : socket_(socket(endpoint.resolved().at(0).generic()->sa_family, SOCK_STREAM, 0)) {
    if (endpoint.address.find(':') == std::string::npos) {
      sockaddr_in here{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {htonl(from)}, .sin_zero = {}};
      bind(socket_.number(), reinterpret_cast<const sockaddr*>(&here), sizeof here);
    }
    const production::SocketAddress there = endpoint.resolved().at(0);
    connected_ = connect(socket_.number(), there.generic(), there.size) == 0;
  }

  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] int number() const { return socket_.number(); }

  bool send(const std::string& text) const {
    return ::send(number(), text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }

  // What comes until `count` bytes are there, the other side has closed, or the time is over.
  [[nodiscard]] std::string receive(std::size_t count, std::int64_t ms = kNoWaitMs) {
    const std::int64_t end = driver::now_ns() + ms * kMs;
    std::string result;
    std::array<char, 65536> bytes{};
    while (result.size() < count && files::wait_readable(number(), end - driver::now_ns())) {
      const ssize_t got = recv(number(), bytes.data(), std::min(bytes.size(), count - result.size()), 0);
      if (got <= 0) {
        closed_ = true;
        break;
      }
      result.append(bytes.data(), static_cast<std::size_t>(got));
    }
    return result;
  }

  // Whether the other side has closed, or closes within the time.
  [[nodiscard]] bool is_closed(std::int64_t ms = 0) {
    static_cast<void>(receive(std::size_t{1} << 30U, ms));
    return closed_;
  }

 private:
  files::FileDescriptor socket_;
  bool connected_ = false;
  bool closed_ = false;
};

Endpoint free_endpoint(const std::string& address = "127.0.0.1") {
  const files::FileDescriptor probe(socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in here{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {htonl(INADDR_LOOPBACK)}, .sin_zero = {}};
  socklen_t size = sizeof here;
  bind(probe.number(), reinterpret_cast<const sockaddr*>(&here), size);
  getsockname(probe.number(), reinterpret_cast<sockaddr*>(&here), &size);
  return {.address = address, .port = ntohs(here.sin_port)};
}

std::size_t resident_bytes() {
  std::size_t all = 0;
  std::size_t resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// The address sanitizer keeps what is freed.
void expect_growth_below(std::size_t before, std::size_t bytes) {
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LT(resident_bytes(), before + bytes);
#else
  static_cast<void>(before + bytes);
#endif
}

// --- where servers listen ---

TEST(Endpoint, OfText) {
  for (const auto& [text, host, loopback] : {std::tuple{"8080", "127.0.0.1", true},
                                             {"127.0.0.1:8080", "127.0.0.1", true},
                                             {"localhost:8080", "localhost", true},
                                             {"[::1]:8080", "[::1]", true},
                                             {"0.0.0.0:8080", "0.0.0.0", false},
                                             {"[::]:8080", "[::]", false},
                                             {"192.0.2.7:8080", "192.0.2.7", false},
                                             {"[2001:db8::7]:8080", "[2001:db8::7]", false}}) {
    const Endpoint endpoint = production::endpoint_of_text("--live", text);
    EXPECT_EQ(endpoint.text(), std::string(host) + ":8080") << text;
    EXPECT_EQ(endpoint.is_loopback(), loopback) << text;
  }
  for (const char* const text : {"",
                                 ":",
                                 "0",
                                 ":8080",
                                 "8080:",
                                 "65536",
                                 "localhost:65536",
                                 "localhost:-1",
                                 "::1:8080",
                                 "[::1]",
                                 "[::1]8080",
                                 "[127.0.0.1]:8080",
                                 "[localhost]:8080",
                                 "1.2.3:8080",
                                 "0:8080",
                                 "8080:8080",
                                 "1.2.3.256:8080",
                                 "a b:8080",
                                 "no.such.name.invalid:8080",
                                 "[::1",
                                 "::1]:8080",
                                 "[]:8080"}) {
    EXPECT_THROW(static_cast<void>(production::endpoint_of_text("--live", text)), UserError) << text;
  }
}

// --- the page ---

// A page with a file of so many bytes, which is another one for every request, and a stream.
class PageServerTest : public ::testing::Test {
 protected:
  void serve(const Endpoint& endpoint = free_endpoint(), const std::string& token = "", std::size_t bytes = 100) {
    endpoint_ = endpoint;
    server_ = std::make_unique<PageServer>(
        "--live", endpoint, token,
        std::vector<PageServer::File>{
            PageServer::fixed("/", "text/html", "the page"),
            {"/file", "text/plain",
             [bytes](std::uint64_t&) { return std::make_shared<const std::string>(bytes, 'f'); }},
            {"/later", "text/plain",
             [this](std::uint64_t& asked) {
               asked = asked == 0 ? newest_ + 1 : asked;
               return newest_ < asked ? nullptr : std::make_shared<const std::string>("it came");
             }},
            {"/fails", "text/plain",
             [](std::uint64_t&) -> PageServer::Text { throw UserError("file", "is not there"); }}},
        PageServer::Stream{.path = "/stream",
                           .next = [this](std::uint64_t& number) -> PageServer::Text {
                             const std::uint64_t newest = newest_;
                             if (newest == number) {
                               return nullptr;
                             }
                             number = newest;
                             return std::make_shared<const std::string>("message " + std::to_string(newest) + ".");
                           },
                           .begin = [this] { ++watchers_; },
                           .finish = [this] { --watchers_; }});
  }

  void send_message() {
    ++newest_;
    server_->wake();
  }

  // The status of the answer; 0 if none comes.
  int get(const std::string& path, const std::string& headers = "Host: localhost\r\n", const char* method = "GET") {
    Peer browser(endpoint_);
    browser.send(std::string(method) + " " + path + " HTTP/1.1\r\nConnection: close\r\n" + headers + "\r\n");
    answer_ = browser.receive(std::size_t{1} << 20U, kNoWaitMs);
    return answer_.size() > 12 && answer_.starts_with("HTTP/1.1 ") ? std::stoi(answer_.substr(9, 3)) : 0;
  }

  int get_of_host(const std::string& host) { return get("/", "Host: " + host + "\r\n"); }

  // Peers that each have sent this.
  std::list<Peer> peers(std::size_t count, const std::string& text) {
    std::list<Peer> result;
    for (std::size_t i = 0; i < count; ++i) {
      result.emplace_back(endpoint_).send(text);
    }
    return result;
  }

  void expect_served_soon() { EXPECT_EQ(get("/"), 200); }

  std::atomic<std::uint64_t> newest_{0};
  std::atomic<int> watchers_{0};
  Endpoint endpoint_;
  std::string answer_;
  std::unique_ptr<PageServer> server_;
};

TEST_F(PageServerTest, IsForThisMachineAlone) {
  serve();
  for (const char* const host : {"localhost", "LocalHost:8080", "127.0.0.1", "127.0.0.1:9", "127.8.9.1", "[::1]:80"}) {
    EXPECT_EQ(get_of_host(host), 200) << host;
    EXPECT_TRUE(answer_.ends_with("\r\n\r\nthe page")) << answer_;
  }
  for (const char* const host :
       {"127.evil.example", "127.0.0.1.evil.example", "localhost.evil.example", "evil.example:127", "127.1", "127",
        "127.0.0.1:80:evil", "127.0.0.1@evil.example", "[::1].evil.example", "[::1", "::1", "0x7f.0.0.1", "127.0.0.256",
        "localhost:evil", "2130706433", "xlocalhost", "192.0.2.1", "[::2]"}) {
    EXPECT_EQ(get_of_host(host), 403) << host;
  }
  EXPECT_NE(get("/", ""), 200);
  EXPECT_NE(get_of_host(""), 200);
}

TEST_F(PageServerTest, TakesOnlyGetAndHead) {
  serve();
  EXPECT_EQ(get("/file"), 200);
  EXPECT_NE(answer_.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(get("/file", "Host: localhost\r\n", "HEAD"), 200);
  EXPECT_TRUE(answer_.ends_with("\r\n\r\n"));
  EXPECT_NE(answer_.find("Content-Length: 100\r\n"), std::string::npos);
  EXPECT_EQ(get("/favicon.ico"), 200);
  for (const char* const method : {"POST", "PUT", "DELETE", "OPTIONS", "CONNECT", "TRACE", "get"}) {
    EXPECT_EQ(get("/", "Host: localhost\r\n", method), 405) << method;
  }
  for (const char* const path : {"/nothing", "/../../etc/passwd", "//", "/file/"}) {
    EXPECT_EQ(get(path), 404) << path;
  }
  EXPECT_EQ(get("/fails"), 500);
}

TEST_F(PageServerTest, TwoTokensOnOneMachine) {
  const Endpoint everywhere = free_endpoint("0.0.0.0");
  serve(everywhere, "0123456789abcdef");
  const auto get_with = [&](const std::string& cookie) { return get("/", "Host: a\r\nCookie: " + cookie + "\r\n"); };
  EXPECT_EQ(get("/", "Host: localhost\r\n"), 403);
  EXPECT_EQ(get("/?token=0123456789abcdee"), 403);
  EXPECT_EQ(get("/?token=0123456789abcdef"), 200);
  const std::string cookie = "selfproj-token-" + std::to_string(everywhere.port) + "=0123456789abcdef";
  EXPECT_NE(answer_.find("Set-Cookie: " + cookie + ";"), std::string::npos) << answer_;
  EXPECT_EQ(get_with(cookie), 200);
  EXPECT_EQ(get_with("selfproj-token-1=another; " + cookie), 200);  // of another line
  EXPECT_EQ(get_with("x" + cookie), 403);
  EXPECT_EQ(get_with("selfproj-token=0123456789abcdef"), 403);
}

TEST_F(PageServerTest, ListensOnNamesAndIpv6) {
  serve(free_endpoint("localhost"));
  EXPECT_EQ(get_of_host("localhost"), 200);
  try {
    serve(free_endpoint("::1"));
  } catch (const UserError&) {
    GTEST_SKIP() << "this machine has no IPv6";
  }
  EXPECT_EQ(get_of_host("[::1]:" + std::to_string(endpoint_.port)), 200);
  EXPECT_THROW(serve(endpoint_), UserError);  // it is taken
}

TEST_F(PageServerTest, RequestsAreBounded) {
  serve();
  const std::size_t before = resident_bytes();
  const std::string much(100'000, 'a');
  for (const std::string& begin :
       {std::string("GET /"), std::string("GET / HTTP/1.1\r\nHost: localhost\r\nX: "),
        std::string("GET / HTTP/1.1\r\nHost: localhost\r\n"),
        std::string("GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\n"),
        std::string("GET / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
                    "3b9aca00\r\n")}) {
    Peer greedy(endpoint_);
    greedy.send(begin);
    bool taken = true;
    for (int i = 0; i < 300 && taken; ++i) {  // 30 MB, where the server still reads
      taken = greedy.send(begin.ends_with("localhost\r\n") ? "X" + std::to_string(i) + ": " + much + "\r\n" : much);
    }
    EXPECT_TRUE(begin.find("\r\n\r\n") != std::string::npos || greedy.is_closed(kNoWaitMs)) << begin;
  }
  expect_growth_below(before, 20'000'000);
  expect_served_soon();
}

TEST_F(PageServerTest, ServesBesideManyWhoAreSilent) {
  serve();
  const auto silent = peers(200, "");
  const auto begun = peers(200, "GET / HTTP/1.1\r\nHost: loc");
  const auto watching = peers(100, "GET /stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  expect_served_soon();
}

TEST_F(PageServerTest, EndsAtOnce) {
  serve(free_endpoint(), "", 10'000'000);
  const auto silent = peers(30, "");
  const auto begun = peers(30, "GET / HTTP/1.1\r\nHost: loc");
  const auto watching = peers(30, "GET /stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const auto asking = peers(30, "GET /file HTTP/1.1\r\nHost: localhost\r\n\r\n");
  std::atomic<bool> end{false};
  std::thread dripping([&] {
    Peer slow(endpoint_);
    for (char c = 'a'; !end && slow.send(std::string(1, c)); c = c == 'z' ? 'a' : static_cast<char>(c + 1)) {
      sleep_ms(20);
    }
  });
  sleep_ms(200);
  const std::int64_t begin = driver::now_ns();
  server_.reset();
  EXPECT_LT(driver::now_ns() - begin, kNoWaitMs * kMs);
  EXPECT_EQ(watchers_, 0);
  end = true;
  dripping.join();
}

TEST_F(PageServerTest, KeepsLittleForThoseWhoTakeNothing) {
  constexpr std::size_t kFile = std::size_t{4} << 20U;
  serve(free_endpoint(), "", kFile);
  const std::size_t before = resident_bytes();
  std::list<Peer> greedy;
  for (int i = 0; i < 100; ++i) {  // 400 MB
    greedy.emplace_back(endpoint_).send("GET /file HTTP/1.1\r\nHost: localhost\r\n\r\n");
    sleep_ms(2);
  }
  expect_growth_below(before, 50'000'000);
  expect_served_soon();
  EXPECT_EQ(get("/file"), 200);  // who takes what comes gets all
}

TEST_F(PageServerTest, StreamsTheNewest) {
  serve();
  Peer first(endpoint_);
  Peer stuck(endpoint_);  // reads nothing
  first.send("GET /stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  stuck.send("GET /stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  while (watchers_ < 2) {
    sleep_ms(1);
  }
  send_message();
  std::string seen;
  while (seen.find("message 1.") == std::string::npos) {
    const std::string more = first.receive(1);
    ASSERT_FALSE(more.empty()) << seen;
    seen += more;
  }
  newest_ = 6;
  send_message();
  while (seen.find("message 7.") == std::string::npos) {
    const std::string more = first.receive(1);
    ASSERT_FALSE(more.empty()) << seen;
    seen += more;
  }
  EXPECT_EQ(seen.find("message 5."), std::string::npos);
  EXPECT_EQ(first.receive(2 + 3 + 8 + 2, 3000),
            std::string("\r\n8\r\n") + std::string(8, '\0') + "\r\n");  // after a second
  {
    Peer gone(endpoint_);
    gone.send("GET /stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
    while (watchers_ < 3) {
      sleep_ms(1);
    }
  }
  for (int i = 0; i < 3000 && watchers_ > 2; ++i) {
    sleep_ms(1);
  }
  EXPECT_EQ(watchers_, 2);
}

TEST_F(PageServerTest, WaitsForATextWithoutDelayingOthers) {
  serve();
  Peer waiting(endpoint_);
  for (int i = 1; i < 4; ++i) {
    waiting.send("GET /later HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(waiting.receive(1, 50), "");
    EXPECT_EQ(get("/"), 200);
    send_message();
    std::string answer = waiting.receive(1);
    while (!answer.empty() && !answer.ends_with("\r\n\r\nit came")) {
      const std::string more = waiting.receive(1);
      ASSERT_FALSE(more.empty()) << answer;
      answer += more;
    }
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 200 ")) << "[" << answer << "]";
  }
  const auto others = peers(10, "GET /later HTTP/1.1\r\nHost: localhost\r\n\r\n");
  sleep_ms(50);
  server_.reset();  // which none of them keeps
}

TEST_F(PageServerTest, LongClosesWhoMakesNoProgress) {
  serve(free_endpoint(), "", 10'000'000);
  Peer silent(endpoint_);
  Peer asking(endpoint_);
  asking.send("GET /file HTTP/1.1\r\nHost: localhost\r\n\r\n");
  Peer slow(endpoint_);
  slow.send("GET / HTTP/1.1\r\n");
  const std::int64_t begin = driver::now_ns();
  while (slow.send("X")) {  // for ever, where nobody is closed
    sleep_ms(100);
  }
  EXPECT_GT(driver::now_ns() - begin, kNoWaitMs * kMs);
  // The last to be closed made progress a little later than the others. What it was sent before, it may take in pieces.
  sleep_ms(1000);
  EXPECT_TRUE(silent.is_closed(kNoWaitMs));
  EXPECT_TRUE(asking.is_closed(kNoWaitMs));
}

// --- Modbus ---

std::string request_of(int function = 4, int first = 0, int count = static_cast<int>(production::kModbusRegisters)) {
  const auto byte = [](int value) { return static_cast<char>(value); };
  return {0, 7, 0, 0, 0, 6, 1, byte(function), byte(first >> 8), byte(first), byte(count >> 8), byte(count)};
}

class ModbusServerTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kAnswer = 9 + 2 * production::kModbusRegisters;

  ModbusServerTest()
      : endpoint_(free_endpoint()), server_(std::make_unique<production::ModbusServer>(endpoint_, [] {
          std::array<std::uint16_t, production::kModbusRegisters> values{};
          values.fill(0x1234);
          return values;
        })) {}

  static void expect_answer(Peer& controller) {
    const std::string answer = controller.receive(kAnswer);
    EXPECT_EQ(answer.substr(0, 11), std::string({0, 7, 0, 0, 0, 55, 1, 4, 52, 0x12, 0x34}));
    EXPECT_EQ(answer.size(), kAnswer);
  }

  void expect_served_soon() {
    Peer controller(endpoint_);
    controller.send(request_of());
    expect_answer(controller);
  }

  Endpoint endpoint_;
  std::unique_ptr<production::ModbusServer> server_;
};

TEST_F(ModbusServerTest, AssemblesRequests) {
  const std::string request = request_of();
  for (const std::size_t head : {1U, 6U, 7U, 11U}) {
    for (const int pause : {25, 200}) {
      Peer controller(endpoint_);
      controller.send(request.substr(0, head));
      sleep_ms(pause);
      controller.send(request.substr(head));
      expect_answer(controller);
    }
  }
  Peer controller(endpoint_);
  for (const char byte : request) {
    controller.send(std::string(1, byte));
    sleep_ms(20);
  }
  expect_answer(controller);
  controller.send(request + request + request + request.substr(0, 5));
  for (int i = 0; i < 3; ++i) {
    expect_answer(controller);
  }
  controller.send(request.substr(5));
  expect_answer(controller);
}

TEST_F(ModbusServerTest, RefusesWhatIsNoRequest) {
  const auto answer_to = [&](const std::string& request) {
    Peer controller(endpoint_);
    controller.send(request);
    return controller.receive(9);
  };
  EXPECT_EQ(answer_to(request_of(6)), std::string({0, 7, 0, 0, 0, 3, 1, '\x86', 1}));
  EXPECT_EQ(answer_to(request_of(4, 0, 0)), std::string({0, 7, 0, 0, 0, 3, 1, '\x84', 3}));
  EXPECT_EQ(answer_to(request_of(3, 0, 126)), std::string({0, 7, 0, 0, 0, 3, 1, '\x83', 3}));
  EXPECT_EQ(answer_to(request_of(3, 25, 2)), std::string({0, 7, 0, 0, 0, 3, 1, '\x83', 2}));
  std::string request = request_of();
  request[2] = 1;  // another protocol
  EXPECT_EQ(answer_to(request), "");
  for (const int length : {0, 1, 255, 0xFFFF}) {
    request = request_of();
    request[4] = static_cast<char>(length >> 8);
    request[5] = static_cast<char>(length);
    EXPECT_EQ(answer_to(request), "") << length;
  }
  request = request_of() + "x";
  request[5] = 7;
  EXPECT_EQ(answer_to(request), "");
  expect_served_soon();
}

TEST_F(ModbusServerTest, NobodyDelaysAnother) {
  constexpr int kDripMs = 30;
  std::atomic<bool> end{false};
  std::list<std::thread> threads;
  for (int i = 0; i < 10; ++i) {
    threads.emplace_back([&] {  // drips, and comes again
      while (!end) {
        Peer slow(endpoint_);
        for (int k = 0; k < 11 && !end && slow.send(request_of().substr(static_cast<std::size_t>(k), 1)); ++k) {
          sleep_ms(kDripMs);
        }
      }
    });
  }
  Peer deaf(endpoint_);  // asks and takes nothing
  while (::send(deaf.number(), request_of().data(), request_of().size(), MSG_NOSIGNAL | MSG_DONTWAIT) > 0) {
  }
  Peer controller(endpoint_);
  std::vector<std::int64_t> waited(50);
  for (std::int64_t& answered_ns : waited) {
    const std::int64_t begin = driver::now_ns();
    controller.send(request_of());
    expect_answer(controller);
    answered_ns = driver::now_ns() - begin;
    sleep_ms(10);
  }
  std::nth_element(waited.begin(), waited.begin() + 25, waited.end());
  EXPECT_LT(waited[25], 11 * kDripMs * kMs) << "half of the answers come sooner than the request of one that drips";
  end = true;
  for (std::thread& thread : threads) {
    thread.join();
  }
}

TEST_F(ModbusServerTest, ClosesWhoNeedsTooLong) {
  Peer slow(endpoint_);
  const std::int64_t begin = driver::now_ns();
  slow.send(request_of().substr(0, 3));
  EXPECT_TRUE(slow.is_closed(kNoWaitMs));
  EXPECT_GT(driver::now_ns() - begin, 450 * kMs);
}

TEST_F(ModbusServerTest, SilentConnectionsLockNobodyOut) {
  Peer controller(endpoint_);
  Peer distant(endpoint_, INADDR_LOOPBACK + 1);  // of another machine
  for (Peer* const one : {&controller, &distant}) {
    one->send(request_of());
    expect_answer(*one);
  }
  std::list<Peer> silent;
  for (int i = 0; i < 400; ++i) {
    silent.emplace_back(endpoint_);
    if (i % 100 == 99) {
      expect_served_soon();
      controller.send(request_of());
      expect_answer(controller);  // who is being served stays
      sleep_ms(300);
    }
  }
  distant.send(request_of());
  expect_answer(distant);
  EXPECT_TRUE(silent.front().is_closed(kNoWaitMs));
}

TEST_F(ModbusServerTest, EndsAtOnce) {
  std::list<Peer> silent;
  for (int i = 0; i < 50; ++i) {
    silent.emplace_back(endpoint_).send(request_of().substr(0, static_cast<std::size_t>(i % 12)));
  }
  const std::int64_t begin = driver::now_ns();
  server_.reset();
  EXPECT_LT(driver::now_ns() - begin, kNoWaitMs * kMs);
}

}  // namespace
}  // namespace selfproj::test
