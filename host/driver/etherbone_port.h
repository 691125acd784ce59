#ifndef SELFPROJ_HOST_DRIVER_ETHERBONE_PORT_H
#define SELFPROJ_HOST_DRIVER_ETHERBONE_PORT_H

#include <chrono>
#include <memory>
#include <string>

#include "host/driver/register_port.h"

namespace selfproj {

struct EtherboneOptions {
  std::chrono::milliseconds patience{50};  // until a question is repeated; doubles up to eight times of it
  int tries = 8;                           // questions before the board counts as gone
};

// The registers of a board on the network, at HOST or HOST:PORT, port kEtherbonePort unless given, by LiteX's
// Etherbone. Datagrams may be lost, repeated and reordered.
//
// A read is repeated until an answer comes. A write goes through the board's mailbox (model/write_mailbox.h) with a
// ticket, one more than that of the last write. The board performs a write only if its ticket is the next one. So a
// datagram that comes twice or late changes nothing, and the host repeats it until it has the answer: every write is
// performed once, or refused by the board, or an error says that no answer came and the write may have been performed
// or not. A board without the mailbox gets each write in one datagram that is never repeated. If no answer to it comes,
// that is an error; but the network itself may deliver it twice or late.
//
// Throws UserError with the URI if no board answers.
std::unique_ptr<RegisterPort> make_etherbone_port(const std::string& place, const EtherboneOptions& options = {});

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_ETHERBONE_PORT_H
