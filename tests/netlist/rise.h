// rise() of sim/board/clocks.h for models that are stepped by eval() alone.
#ifndef SELFPROJ_TESTS_NETLIST_RISE_H
#define SELFPROJ_TESTS_NETLIST_RISE_H

#include "sim/board/clocks.h"

namespace selfproj {

template <class Model>
void rise(Model& model) {
  const auto video = model.clk_i;
  const auto bus = model.bus_clk_i;
  model.clk_i = 0;
  model.bus_clk_i = 0;
  model.eval();
  model.clk_i = video;
  model.bus_clk_i = bus;
  model.eval();
}

}  // namespace selfproj

#endif  // SELFPROJ_TESTS_NETLIST_RISE_H
