// Registers for tests without a board: behind a port that the model answers, and as the bytes that a bus would show.
#ifndef SELFPROJ_TESTS_SUPPORT_BOARD_REGISTERS_H
#define SELFPROJ_TESTS_SUPPORT_BOARD_REGISTERS_H

#include <cstdint>
#include <memory>
#include <string>

#include "model/register_file.h"
#include "model/spec/generated/register_table.h"
#include "sim/board/access_port.h"

namespace selfproj::test {

// A port to `board`, the model of the register file. `board` must outlive the port.
inline std::unique_ptr<driver::RegisterPort> port_of(model::RegisterFile& board, const model::BoardState& state = {}) {
  return std::make_unique<sim::AccessPort>([&board, state](bool write, std::uint32_t address, std::uint32_t data) {
    return write ? board.write(address, data) : board.read(address, state);
  });
}

// The bytes of all registers after reset, little endian.
inline std::string register_bytes(const model::BoardBuild& build = {}) {
  model::RegisterFile board(build);
  std::string bytes;
  for (std::uint32_t address = 0; address <= spec::kRegisters.back().address; address += 4) {
    const std::uint32_t word = board.read(address, {}).data;
    for (int shift = 0; shift < 32; shift += 8) {
      bytes.push_back(static_cast<char>(word >> shift & 0xFFU));
    }
  }
  return bytes;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_BOARD_REGISTERS_H
