// Where a server listens: [ADDRESS:]PORT.
#ifndef SELFPROJ_HOST_PRODUCTION_ENDPOINT_H
#define SELFPROJ_HOST_PRODUCTION_ENDPOINT_H

#include <cstdint>
#include <string>

namespace selfproj::production {

struct Endpoint {
  std::string address = "127.0.0.1";  // IPv4
  std::uint16_t port = 0;

  [[nodiscard]] bool is_loopback() const { return address.rfind("127.", 0) == 0; }
  [[nodiscard]] std::string text() const { return address + ":" + std::to_string(port); }
};

// Throws UserError about `option` if the text is none.
Endpoint endpoint_of_text(const std::string& option, const std::string& text);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_ENDPOINT_H
