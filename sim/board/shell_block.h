// What the SystemC shells need in a program: the memories beside them, pins, and a clock.
#ifndef SELFPROJ_SIM_BOARD_SHELL_BLOCK_H
#define SELFPROJ_SIM_BOARD_SHELL_BLOCK_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <systemc>
#include <type_traits>
#include <vector>

#include "hls/types.h"

namespace selfproj::sim {

// The memory beside a shell, which corresponds to rtl/common/sp_ram.sv beside a module of the RTL.
// The word at rd_addr appears at rd_data one clock after rd_en, and stays until the next read.
// A read in the same clock as a write to the same address gives a word with every bit wrong, so that nobody can rely on
// it.
template <typename Word, typename Address>
class ShellRam : public sc_core::sc_module {
 public:
  sc_core::sc_in<bool> clk{"clk"};
  sc_core::sc_in<bool> rd_en{"rd_en"};
  sc_core::sc_in<Address> rd_addr{"rd_addr"};
  sc_core::sc_out<Word> rd_data{"rd_data"};
  sc_core::sc_in<bool> wr_en{"wr_en"};
  sc_core::sc_in<Address> wr_addr{"wr_addr"};
  sc_core::sc_in<Word> wr_data{"wr_data"};

  explicit ShellRam(const sc_core::sc_module_name& name) : sc_module(name) {
    SC_HAS_PROCESS(ShellRam);
    SC_METHOD(access);
    sensitive << clk.pos();
    dont_initialize();
  }

 private:
  void access() {
    if (rd_en.read()) {
      Word word = words_[rd_addr.read().to_uint()];
      if (wr_en.read() && wr_addr.read() == rd_addr.read()) {
        word = ~word;
      }
      rd_data.write(word);
    }
    if (wr_en.read()) {
      words_[wr_addr.read().to_uint()] = wr_data.read();
    }
  }

  std::vector<Word> words_ = std::vector<Word>(std::size_t{1} << Address().length());
};

// The SystemC shells with their memories, stepped one clock at a time by the owner of the pins.
//
//     ColumnMomentsBlock block("moments");
//     ColumnMomentsPins pins;
//     pins.beat_valid_i = 1; ...
//     block.clock(pins);              // the edge that ends this clock; the outputs are those of the next one
//
// A block takes no simulated time: its clock is a signal that changes in delta cycles. clock() may be called from a
// thread of the block's kernel, or from outside while that kernel does not run. Like everything in SystemC, blocks must
// be built before their kernel first runs.
//
// Pins have the names of the RTL's ports and the types of a Verilated model.

// The type of a port of `Bits` in a Verilated model; a wide one has words of 32 bits, the lowest first.
template <int Bits>
using PortOf = std::conditional_t<
    (Bits > 64), std::array<std::uint32_t, (Bits + 31) / 32>,
    std::conditional_t<
        (Bits > 32), std::uint64_t,
        std::conditional_t<(Bits > 16), std::uint32_t, std::conditional_t<(Bits > 8), std::uint16_t, std::uint8_t>>>>;
using Wide128 = PortOf<128>;

// A number between a shell and its pins.
template <typename Number, typename Port>
Number number_of(const Port& port) {
  if constexpr (std::is_integral_v<Port>) {
    return Number(port);
  } else {
    Number number = 0;
    for (std::size_t i = port.size(); i-- > 0;) {
      number = (number << 32) | Number(hls::Uint<32>(port[i]));
    }
    return number;
  }
}
template <int Bits>
PortOf<Bits> port_of(const hls::WideUint<Bits>& number) {
  PortOf<Bits> port{};
  hls::WideUint<Bits> rest = number;
  for (std::uint32_t& word : port) {
    word = rest.to_uint();
    rest = rest >> 32;
  }
  return port;
}

template <class Ram, class Bit, class Address, class Word>
void connect(Ram& ram, sc_core::sc_signal<bool>& clk, Bit& rd_en, Address& rd_addr, Word& rd_data, Bit& wr_en,
             Address& wr_addr, Word& wr_data) {
  ram.clk(clk);
  ram.rd_en(rd_en);
  ram.rd_addr(rd_addr);
  ram.rd_data(rd_data);
  ram.wr_en(wr_en);
  ram.wr_addr(wr_addr);
  ram.wr_data(wr_data);
}

// The common part of the blocks: clock and reset, and how a clock passes.
class ShellBlock : public sc_core::sc_module {
 public:
  using sc_core::sc_module::sc_module;

 protected:
  template <typename T>
  using Signal = sc_core::sc_signal<T>;

  // Called after the inputs were written: makes the edge, after which the outputs can be read.
  void pass_clock(bool reset);

  Signal<bool> clk_{"clk"};
  Signal<bool> rst_{"rst"};

 private:
  static void settle();
};

constexpr int kShellRegisters = 40;  // more than any circuit has from its input to its output

// Resets a block, whatever it did before.
template <class Block, class Pins>
void reset_shell(Block& block, Pins& pins) {
  constexpr int kClocks = 4;
  pins.rst_i = 1;
  for (int i = 0; i < kClocks; ++i) {
    block.clock(pins);
  }
  pins.rst_i = 0;
}

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_SHELL_BLOCK_H
