#include "host/production/endpoint.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <cstdint>
#include <optional>
#include <string>

#include "host/files/numbers.h"
#include "selfproj/files/user_error.h"

namespace selfproj::production {

Endpoint endpoint_of_text(const std::string& option, const std::string& text) {
  Endpoint result;
  const std::size_t colon = text.rfind(':');
  if (colon != std::string::npos) {
    result.address = text.substr(0, colon);
  }
  const auto port = files::number_of_text<std::uint16_t>(text.substr(colon == std::string::npos ? 0 : colon + 1));
  in_addr address{};
  if (!port || *port == 0 || inet_pton(AF_INET, result.address.c_str(), &address) != 1) {
    throw UserError(option + " " + text, "is neither a port from 1 to 65535 nor ADDRESS:PORT with an IPv4 address");
  }
  result.port = *port;
  return result;
}

}  // namespace selfproj::production
