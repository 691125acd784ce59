#include "host/production/modbus_server.h"

#include <fcntl.h>
#include <modbus/modbus-tcp.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "host/files/file_descriptor.h"
#include "host/files/signals_held.h"
#include "selfproj/files/user_error.h"

namespace selfproj::production {
namespace {

constexpr int kMaxPending = 128;               // connections that wait to be accepted
constexpr int kPatienceMs = 50;                // so that the end is noticed
constexpr std::uint32_t kByteWaitUs = 20'000;  // between the bytes of one request

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
  return values;
}

// What libmodbus holds, and the sockets.
class ModbusServer::Connection {
 public:
  explicit Connection(const Endpoint& endpoint)
      : context_(modbus_new_tcp(endpoint.address.c_str(), endpoint.port), modbus_free),
        mapping_(modbus_mapping_new(0, 0, kModbusRegisters, kModbusRegisters), modbus_mapping_free),
        listening_(-1) {
    if (context_ == nullptr || mapping_ == nullptr) {
      throw UserError("--modbus " + endpoint.text(), modbus_strerror(errno));
    }
    listening_.reset(modbus_tcp_listen(context_.get(), kMaxPending));
    if (listening_.number() < 0) {
      throw UserError("--modbus " + endpoint.text(), files::error_text(errno));
    }
    fcntl(listening_.number(), F_SETFL, O_NONBLOCK);
    modbus_set_byte_timeout(context_.get(), 0, kByteWaitUs);
    modbus_set_indication_timeout(context_.get(), 0, kByteWaitUs);
    // The library sleeps for this time after some refusals: one client must not stop the others.
    modbus_set_response_timeout(context_.get(), 0, 1);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    for (const int client : clients_) {
      ::close(client);
    }
  }

  // Waits for requests, and answers those that are there.
  void serve(const Registers& registers) {
    std::vector<pollfd> sockets;
    sockets.push_back({.fd = listening_.number(), .events = POLLIN, .revents = 0});
    for (const int client : clients_) {
      sockets.push_back({.fd = client, .events = POLLIN, .revents = 0});
    }
    if (poll(sockets.data(), sockets.size(), kPatienceMs) <= 0) {
      return;
    }
    for (std::size_t i = 1; i < sockets.size(); ++i) {
      if (sockets[i].revents != 0 && !answer(sockets[i].fd, registers)) {
        ::close(sockets[i].fd);
        std::erase(clients_, sockets[i].fd);
      }
    }
    for (int client = accept4(listening_.number(), nullptr, nullptr, SOCK_CLOEXEC); client >= 0;
         client = accept4(listening_.number(), nullptr, nullptr, SOCK_CLOEXEC)) {
      if (clients_.size() >= kMaxClients) {
        ::close(client);
      } else {
        clients_.push_back(client);
      }
    }
  }

 private:
  // Returns false if the client has gone, or what it sends is no request.
  bool answer(int client, const Registers& registers) {
    modbus_set_socket(context_.get(), client);
    std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> request{};
    const int length = modbus_receive(context_.get(), request.data());
    if (length < 0) {
      return false;
    }
    if (length == 0) {  // for another slave
      return true;
    }
    const int header = modbus_get_header_length(context_.get());
    const std::uint8_t function = request.at(static_cast<std::size_t>(header));
    if (function != MODBUS_FC_READ_HOLDING_REGISTERS && function != MODBUS_FC_READ_INPUT_REGISTERS) {
      return modbus_reply_exception(context_.get(), request.data(), MODBUS_EXCEPTION_ILLEGAL_FUNCTION) >= 0;
    }
    const Values values = registers();
    std::copy(values.begin(), values.end(), mapping_->tab_registers);
    std::copy(values.begin(), values.end(), mapping_->tab_input_registers);
    return modbus_reply(context_.get(), request.data(), length, mapping_.get()) >= 0;
  }

  std::unique_ptr<modbus_t, void (*)(modbus_t*)> context_;
  std::unique_ptr<modbus_mapping_t, void (*)(modbus_mapping_t*)> mapping_;
  files::FileDescriptor listening_;
  std::vector<int> clients_;
};

ModbusServer::ModbusServer(const Endpoint& endpoint, Registers registers)
    : registers_(std::move(registers)), connection_(std::make_unique<Connection>(endpoint)) {
  const files::SignalsHeld held;
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      connection_->serve(registers_);
    }
  });
}

ModbusServer::~ModbusServer() = default;

}  // namespace selfproj::production
