// Results for a programmable controller: Modbus TCP.
#ifndef SELFPROJ_HOST_PRODUCTION_MODBUS_SERVER_H
#define SELFPROJ_HOST_PRODUCTION_MODBUS_SERVER_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "host/production/endpoint.h"
#include "host/production/part_result.h"

namespace selfproj::production {

// The registers, 16 bits each; of two, the first has the higher half. The same as input registers (function 4) and as
// holding registers (function 3). All other functions are refused: a controller can change nothing.
enum class ModbusRegister : std::size_t {
  layout = 0,        // 1: the version of this list
  heartbeat = 1,     // counts tenths of a second while parts are classified, and wraps
  verdict = 2,       // of the last part: 0 none yet, 1 good, 2 bad, 3 inconclusive
  part = 3,          // number of the last part, 2 registers
  good = 5,          // parts so far, 2 registers each
  bad = 7,           //
  inconclusive = 9,  //
  age_ms = 11,       // age of the last result, 2 registers; greatest number: none yet
  defects = 13,      // of the last part, at most 65535
  depth_um = 14,     // of its largest defect, two's complement
  delay_us = 15,     // from its last frame to its result, 2 registers
  lost = 17,         // packets lost so far, 2 registers
  specks = 19,       // objects too short to be a part, 2 registers
  moments = 21,      // the last part by moments (`inspect --verdict`): 0 not judged, 1 no defect, 2 a defect
  by_moments = 22,   // parts with a defect by moments so far, 2 registers
  disagree = 24,     // frames that board and model judged differently so far, 2 registers
};
inline constexpr std::size_t kModbusRegisters = 26;

// The registers' values at the time `now_ns` of the steady clock.
std::array<std::uint16_t, kModbusRegisters> modbus_registers(const PartCounts& parts, std::uint64_t lost,
                                                             std::uint16_t heartbeat, std::int64_t now_ns);

// Answers in a thread of its own, each client by itself. A client that sends anything that is no request, or a request
// for longer than half a second, loses its connection, and nothing else happens. So does one that has asked for nothing
// ten seconds after it came or ten minutes after its last request; clients.h says who must go where many come, and how
// much of a core the thread may take.
class ModbusServer {
 public:
  using Registers = std::function<std::array<std::uint16_t, kModbusRegisters>()>;

  // Asks `registers` for every request; it may be called from another thread until the end. Throws UserError about
  // --modbus if it cannot listen there.
  ModbusServer(const Endpoint& endpoint, Registers registers);
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;
  ~ModbusServer();

 private:
  class Connections;

  Registers registers_;
  std::unique_ptr<Connections> connections_;
  std::jthread thread_;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_MODBUS_SERVER_H
