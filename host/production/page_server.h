// An HTTP server of a page, read only.
#ifndef SELFPROJ_HOST_PRODUCTION_PAGE_SERVER_H
#define SELFPROJ_HOST_PRODUCTION_PAGE_SERVER_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/production/endpoint.h"

namespace selfproj::production {

// What requests to an endpoint need: 128 random bits as text, or nothing on a loopback address.
std::string page_token(const Endpoint& endpoint);

// Where a browser finds the page.
std::string page_url(const Endpoint& endpoint, const std::string& token);

// On a loopback address, requests must be for a name of this machine. On any other, they need the token. Nothing comes
// from anywhere else, and only GET and HEAD are served.
//
// One thread serves all, by libmicrohttpd. A request that does not fit into kMaxRequest bytes is refused. Who does not
// complete a request in five seconds, or takes no further block of an answer for so long, is closed; clients.h says who
// must go where many come, and how much of a core the thread may take.
class PageServer {
 public:
  using Text = std::shared_ptr<const std::string>;

  static constexpr std::size_t kMaxRequest = 32768;

  // A path such as "/live.js", its media type, and what is there. The function is called in the server's thread, and
  // must not wait: if it returns null, it is called again after wake() or a second, with the same number, which is 0 at
  // a request's first call.
  struct File {
    std::string path;
    std::string type;
    std::function<Text(std::uint64_t&)> text;
  };

  // Messages without end at a path. All are called in the server's thread, and must not wait.
  struct Stream {
    std::string path;
    std::function<Text(std::uint64_t&)> next;  // the newest message after this number, which it raises; null: none yet
    std::function<void()> begin;               // one more watches
    std::function<void()> finish;              // one less
  };

  // Listens from now on. Throws UserError about `option` if it cannot.
  PageServer(const std::string& option, const Endpoint& endpoint, const std::string& token, std::vector<File> files,
             std::optional<Stream> stream = {});
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;
  virtual ~PageServer();

  // There is a new message, or a text that was not there. For any thread.
  void wake();

  // A file whose text stays.
  static File fixed(const std::string& path, const std::string& type, std::string text);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_PAGE_SERVER_H
