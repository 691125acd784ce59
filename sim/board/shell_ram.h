// The memory beside a SystemC shell, which corresponds to rtl/common/sp_ram.sv beside a module of the RTL.
#ifndef SELFPROJ_SIM_BOARD_SHELL_RAM_H
#define SELFPROJ_SIM_BOARD_SHELL_RAM_H

#include <cstddef>
#include <cstdint>
#include <systemc>
#include <vector>

#include "hls/types.h"

namespace selfproj {

// Words of up to 64 bits. The word at rd_addr appears at rd_data one clock after rd_en, and stays until the next read.
// A read in the same clock as a write to the same address gives a word with every bit wrong, so that nobody can rely on
// it.
template <int Bits, int AddressBits>
class ShellRam : public sc_core::sc_module {
 public:
  sc_core::sc_in<bool> clk{"clk"};
  sc_core::sc_in<bool> rd_en{"rd_en"};
  sc_core::sc_in<hls::Uint<AddressBits>> rd_addr{"rd_addr"};
  sc_core::sc_out<hls::Uint<Bits>> rd_data{"rd_data"};
  sc_core::sc_in<bool> wr_en{"wr_en"};
  sc_core::sc_in<hls::Uint<AddressBits>> wr_addr{"wr_addr"};
  sc_core::sc_in<hls::Uint<Bits>> wr_data{"wr_data"};

  explicit ShellRam(const sc_core::sc_module_name& name) : sc_module(name) {
    SC_HAS_PROCESS(ShellRam);
    SC_METHOD(access);
    sensitive << clk.pos();
    dont_initialize();
  }

 private:
  void access() {
    if (rd_en.read()) {
      std::uint64_t word = words_[rd_addr.read().to_uint()];
      if (wr_en.read() && wr_addr.read() == rd_addr.read()) {
        word = ~word;
      }
      rd_data.write(word);
    }
    if (wr_en.read()) {
      words_[wr_addr.read().to_uint()] = wr_data.read();
    }
  }

  std::vector<std::uint64_t> words_ = std::vector<std::uint64_t>(std::size_t{1} << AddressBits);
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_BOARD_SHELL_RAM_H
