// Defines rise() of one model. cmake/verilate.cmake includes this behind the model's code, so that the compiler sees
// all that runs in a clock (a tenth fewer instructions). SELFPROJ_MODEL is the model's class, and SELFPROJ_PART(name)
// the function `name` of its root. With SELFPROJ_FAST_RISE, rise() consists of the parts of eval() that an edge needs.
//
// These parts are private, and each version of Verilator may write others. If a model has none that are known here, its
// rise() calls eval().
#ifndef SELFPROJ_SIM_BOARD_VERILATED_RISE_H
#define SELFPROJ_SIM_BOARD_VERILATED_RISE_H

#include "sim/board/clocks.h"

namespace selfproj::sim {
namespace {

template <class Root>
concept HasBusClock = requires(Root* root) {
  root->bus_clk_i;
};
// Logic between inputs and registers
template <class Root>
concept HasInputLogic = requires(Root* root) {
  root->__VicoTriggered;
};

// As version 5.006 writes it
template <class Root>
concept Verilator5006 = requires(Root* root) {
  root->__Vtrigrprev__TOP__clk_i = 0;
  requires !HasBusClock<Root> || requires { root->__Vtrigrprev__TOP__bus_clk_i = 0; };
  requires !HasInputLogic<Root> || requires {
    root->__VicoIterCount = 0;
    SELFPROJ_PART(eval_triggers__ico)(root);
    SELFPROJ_PART(eval_ico)(root);
  };
  SELFPROJ_PART(eval_triggers__act)(root);
  root->__VnbaTriggered = root->__VactTriggered;
  SELFPROJ_PART(eval_nba)(root);
};

template <Verilator5006 Root>
void rise_by_parts(Root* root) {
  root->__Vtrigrprev__TOP__clk_i = 0;
  if constexpr (HasBusClock<Root>) {
    root->__Vtrigrprev__TOP__bus_clk_i = 0;
  }
  if constexpr (HasInputLogic<Root>) {
    root->__VicoIterCount = 0;
    SELFPROJ_PART(eval_triggers__ico)(root);
    SELFPROJ_PART(eval_ico)(root);
  }
  SELFPROJ_PART(eval_triggers__act)(root);
  root->__VnbaTriggered = root->__VactTriggered;
  SELFPROJ_PART(eval_nba)(root);
}

// As versions 5.032 to 5.48 write it
template <class Root>
concept Verilator5032 = requires(Root* root) {
  root->__Vtrigprevexpr___TOP__clk_i__0 = 0;
  requires !HasBusClock<Root> || requires { root->__Vtrigprevexpr___TOP__bus_clk_i__0 = 0; };
  requires !HasInputLogic<Root> || requires {
    root->__VicoFirstIteration = 1;
    SELFPROJ_PART(eval_phase__ico)(root);
  };
  SELFPROJ_PART(eval_phase__act)(root);
  SELFPROJ_PART(eval_phase__nba)(root);
};

template <Verilator5032 Root>
void rise_by_parts(Root* root) {
  root->__Vtrigprevexpr___TOP__clk_i__0 = 0;
  if constexpr (HasBusClock<Root>) {
    root->__Vtrigprevexpr___TOP__bus_clk_i__0 = 0;
  }
  if constexpr (HasInputLogic<Root>) {
    root->__VicoFirstIteration = 1;
    SELFPROJ_PART(eval_phase__ico)(root);
  }
  SELFPROJ_PART(eval_phase__act)(root);
  SELFPROJ_PART(eval_phase__nba)(root);
}

#ifdef SELFPROJ_FAST_RISE
template <class Model>
concept HasParts = requires(Model& model) {
  rise_by_parts(model.rootp);
};
#else
template <class Model>
concept HasParts = false;
#endif

template <class Model>
void rise_of(Model& model) {
  if constexpr (HasParts<Model>) {
    rise_by_parts(model.rootp);
  } else {
    rise_by_eval(model);
  }
}

}  // namespace

template <>
void rise<SELFPROJ_MODEL>(SELFPROJ_MODEL& model) {
  rise_of(model);
}

template <>
bool rises_fast<SELFPROJ_MODEL>() {
  return HasParts<SELFPROJ_MODEL>;
}

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_VERILATED_RISE_H
