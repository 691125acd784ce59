#include "host/production/modbus_server.h"

#include <modbus/modbus-tcp.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <list>
#include <memory>
#include <stop_token>
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

constexpr int kPatienceMs = 50;                         // so that the end is noticed
constexpr std::int64_t kRequestNs = 500'000'000;        // from the first to the last byte of a request
constexpr std::int64_t kNeverAskedNs = 10'000'000'000;  // a client is silent
constexpr std::int64_t kIdleNs = 600'000'000'000;

// Of a request: identification, 0, the bytes that follow the length, unit; then function and data.
constexpr std::size_t kBeforeLength = 4;
constexpr std::size_t kHead = 7;

using Values = std::array<std::uint16_t, kModbusRegisters>;

void put(Values& values, ModbusRegister at, std::uint64_t value) {
  values.at(static_cast<std::size_t>(at)) = static_cast<std::uint16_t>(value);
}

void put_two(Values& values, ModbusRegister at, std::uint64_t value) {
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint32_t>::max();
  const std::uint64_t limited = std::min(value, kMax);
  values.at(static_cast<std::size_t>(at)) = static_cast<std::uint16_t>(limited >> 16U);
  values.at(static_cast<std::size_t>(at) + 1) = static_cast<std::uint16_t>(limited);
}

}  // namespace

std::array<std::uint16_t, kModbusRegisters> modbus_registers(const PartCounts& parts, std::uint64_t lost,
                                                             std::uint16_t heartbeat, std::int64_t now_ns) {
  const auto not_negative = [](std::int64_t ns) { return static_cast<std::uint64_t>(std::max<std::int64_t>(0, ns)); };
  Values values{};
  const bool any = parts.last_part > 0;
  put(values, ModbusRegister::layout, 1);
  put(values, ModbusRegister::heartbeat, heartbeat);
  put(values, ModbusRegister::verdict, any ? static_cast<std::uint64_t>(parts.last_verdict) + 1 : 0);
  put_two(values, ModbusRegister::part, parts.last_part);
  put_two(values, ModbusRegister::good, parts.verdicts[0]);
  put_two(values, ModbusRegister::bad, parts.verdicts[1]);
  put_two(values, ModbusRegister::inconclusive, parts.verdicts[2]);
  put_two(values, ModbusRegister::age_ms,
          any ? not_negative(now_ns - parts.last_ns) / 1'000'000 : std::numeric_limits<std::uint64_t>::max());
  put(values, ModbusRegister::defects, std::min<std::uint64_t>(parts.last_defects, UINT16_MAX));
  const double depth = std::clamp(std::round(1000 * parts.last_depth_mm), -32768.0, 32767.0);
  put(values, ModbusRegister::depth_um, static_cast<std::uint16_t>(static_cast<std::int16_t>(depth)));
  put_two(values, ModbusRegister::delay_us, not_negative(parts.last_delay_ns) / 1000);
  put_two(values, ModbusRegister::lost, lost);
  put_two(values, ModbusRegister::specks, parts.specks);
  const bool judged = parts.last_moments && parts.last_moments->frames > 0;
  put(values, ModbusRegister::moments, !judged ? 0 : parts.last_moments->defect() ? 2 : 1);
  put_two(values, ModbusRegister::by_moments, parts.by_moments);
  put_two(values, ModbusRegister::disagree, parts.board_disagrees);
  return values;
}

// What libmodbus holds, and the sockets.
class ModbusServer::Connections {
 public:
  explicit Connections(const Endpoint& endpoint)
      : listening_(listen_at("--modbus", endpoint)),
        context_(modbus_new_tcp("127.0.0.1", endpoint.port), modbus_free),  // only to answer by
        mapping_(modbus_mapping_new(0, 0, kModbusRegisters, kModbusRegisters), modbus_mapping_free) {
    if (context_ == nullptr || mapping_ == nullptr) {
      throw UserError("--modbus " + endpoint.text(), modbus_strerror(errno));
    }
  }
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;
  ~Connections() {
    for (const auto& [socket, client] : clients_) {
      ::close(socket);
    }
  }

  // Waits for requests, and answers those that are there.
  void serve(const Registers& registers) {
    std::vector<pollfd> sockets;
    for (const files::FileDescriptor& one : listening_) {
      sockets.push_back({one.number(), static_cast<std::int16_t>(full_ ? 0 : POLLIN), 0});
    }
    const std::size_t first = sockets.size();
    for (const auto& [socket, client] : clients_) {
      sockets.push_back({socket, POLLIN, 0});
    }
    poll(sockets.data(), sockets.size(), full_ ? kAcceptAgainMs : kPatienceMs);
    const std::int64_t now = driver::now_ns();
    bool renewed = false;  // the registers
    for (std::size_t i = first; i < sockets.size(); ++i) {
      if (sockets[i].revents != 0 && !renewed) {
        const Values values = registers();
        std::copy(values.begin(), values.end(), mapping_->tab_registers);
        std::copy(values.begin(), values.end(), mapping_->tab_input_registers);
        renewed = true;
      }
      const auto client = clients_.find(sockets[i].fd);
      if ((sockets[i].revents != 0 && !receive(client->first, client->second, now)) || is_late(client->second, now)) {
        drop(client);
      }
    }
    full_ = false;
    for (const files::FileDescriptor& one : listening_) {
      full_ = !accept_clients(
                  one.number(), most_, clients_, now,
                  [&](int socket, const SocketAddress& from) {
                    clients_[socket] = {{.machine = machine_of(from), .since_ns = now}};
                  },
                  [this](Clients<Controller>::iterator client) { drop(client); }) ||
              full_;
    }
  }

 private:
  // What has arrived of a client's requests.
  struct Controller : Client {
    std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> bytes{};
    std::size_t size = 0;
    std::int64_t begun_ns = 0;  // when the first of the bytes came
    bool asked = false;         // it has sent a whole request
  };

  static bool is_late(const Controller& client, std::int64_t now) {
    return (client.size > 0 && now - client.begun_ns > kRequestNs) ||
           now - client.since_ns > (client.asked ? kIdleNs : kNeverAskedNs);
  }

  void drop(Clients<Controller>::iterator client) {
    ::close(client->first);
    clients_.erase(client);
  }

  // Takes what is there, and answers the requests that are whole. Returns false if the client has gone, or what it
  // sends is no request.
  bool receive(int socket, Controller& client, std::int64_t now) {
    const ssize_t count = recv(socket, &client.bytes.at(client.size), client.bytes.size() - client.size, MSG_DONTWAIT);
    if (count <= 0) {
      return count < 0 && (errno == EAGAIN || errno == EINTR);
    }
    client.begun_ns = client.size == 0 ? now : client.begun_ns;
    client.size += static_cast<std::size_t>(count);
    modbus_set_socket(context_.get(), socket);
    while (client.size >= kHead) {
      const std::size_t size = kBeforeLength + 2 + (std::size_t{client.bytes[4]} << 8U) + client.bytes[5];
      const bool is_modbus = client.bytes[2] == 0 && client.bytes[3] == 0;
      if (!is_modbus || size <= kHead || size > client.bytes.size()) {
        return false;
      }
      if (client.size < size) {
        break;
      }
      if (!answer(client.bytes.data(), size)) {
        return false;
      }
      std::copy(client.bytes.begin() + static_cast<std::ptrdiff_t>(size),
                client.bytes.begin() + static_cast<std::ptrdiff_t>(client.size), client.bytes.begin());
      client.size -= size;
      client.begun_ns = client.since_ns = now;
      client.asked = true;
    }
    return true;
  }

  // Answers a whole request. Libmodbus sends without waiting, because the socket does not block: who takes no answers
  // loses its connection. After some refusals libmodbus would wait and read on; these are made here.
  bool answer(const std::uint8_t* request, std::size_t size) {
    constexpr std::size_t kRead = kHead + 5;  // function, first register, count
    const std::uint8_t function = request[kHead];
    if (function != MODBUS_FC_READ_HOLDING_REGISTERS && function != MODBUS_FC_READ_INPUT_REGISTERS) {
      return modbus_reply_exception(context_.get(), request, MODBUS_EXCEPTION_ILLEGAL_FUNCTION) >= 0;
    }
    if (size != kRead) {
      return false;
    }
    const int count = request[kRead - 2] << 8U | request[kRead - 1];
    if (count < 1 || count > MODBUS_MAX_READ_REGISTERS) {
      return modbus_reply_exception(context_.get(), request, MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE) >= 0;
    }
    return modbus_reply(context_.get(), request, static_cast<int>(size), mapping_.get()) >= 0;
  }

  const std::size_t most_ = max_clients();
  const std::list<files::FileDescriptor> listening_;
  std::unique_ptr<modbus_t, void (*)(modbus_t*)> context_;
  std::unique_ptr<modbus_mapping_t, void (*)(modbus_mapping_t*)> mapping_;
  Clients<Controller> clients_;
  bool full_ = false;  // somebody may wait to be accepted
};

ModbusServer::ModbusServer(const Endpoint& endpoint, Registers registers)
    : registers_(std::move(registers)), connections_(std::make_unique<Connections>(endpoint)) {
  const files::SignalsHeld held;
  thread_ = std::jthread([this](const std::stop_token& stop) {
    files::give_way();
    Duty duty;
    while (!stop.stop_requested()) {
      connections_->serve(registers_);
      duty.rest();
    }
  });
}

ModbusServer::~ModbusServer() = default;

}  // namespace selfproj::production
