// The HTTP server of the live page.
#ifndef SELFPROJ_HOST_LINE_LIVE_SERVER_H
#define SELFPROJ_HOST_LINE_LIVE_SERVER_H

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host/line/endpoint.h"

namespace selfproj {

class LiveServer {
 public:
  // What it serves. All are called in threads of the server.
  struct Content {
    // The next message after this number, which it raises; null if there is none for a while.
    std::function<std::shared_ptr<const std::string>(std::uint64_t&)> next;
    std::function<std::shared_ptr<const std::string>()> part;
    std::function<bool()> begin;   // one more watches; false: too many. finish() is due in either case
    std::function<void()> finish;  // one less
  };

  // Listens from now on. `token`: what requests need; empty: none, but then they must be for a name of this machine.
  // Throws UserError about --live if it cannot.
  LiveServer(const Endpoint& endpoint, const std::string& token, Content content);
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;
  virtual ~LiveServer();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LINE_LIVE_SERVER_H
