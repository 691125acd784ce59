// Stepping a Verilated model from one rising edge to the next.
//
// Verilator's eval() finds out which clocks have risen, and repeats until nothing changes. Each edge costs two calls,
// one of them for the fall, at which nothing happens in the circuits. A caller who steps the clocks knows all that, and
// rise() does only what one rising edge needs, where the parts of eval() are known (verilated_rise.h). eval() may still
// be called before, after and in between.
//
//     BoardClocks clocks(6614, 8000, 1234);               // periods and phase in ps
//     const BoardClocks::Edge edge = clocks.next();    // of which clock, and when
//     ... inputs, from the outputs before the edge ...
//     clocks.raise(model, edge);
#ifndef SELFPROJ_SIM_BOARD_CLOCKS_H
#define SELFPROJ_SIM_BOARD_CLOCKS_H

#include <cstdint>
#include <utility>

namespace selfproj::sim {

// Updates the model at a rising edge of those clocks that are 1, all of which have been 0 since the edge before; inputs
// may have changed with it. The model's clocks are clk_i and perhaps bus_clk_i.
template <class Model>
void rise_by_eval(Model& model) {
  const auto video = std::exchange(model.clk_i, 0);
  if constexpr (requires { model.bus_clk_i; }) {
    const auto bus = std::exchange(model.bus_clk_i, 0);
    model.eval();
    model.bus_clk_i = bus;
  } else {
    model.eval();
  }
  model.clk_i = video;
  model.eval();
}

// The same, in the fastest way that there is. eval() must have been called once before. Defined for models for which
// selfproj_verilate() (cmake/Verilated.cmake) was given CLOCKS; none of them may make a clock itself.
template <class Model>
void rise(Model& model);

// Whether rise() of the model is not just rise_by_eval().
template <class Model>
bool rises_fast();

// The board's two unrelated clocks: their periods in ps, and how much later than one period the bus clock's first edge
// is.
class BoardClocks {
 public:
  struct Edge {
    bool video;
    bool bus;
    std::uint64_t time_ps;
  };

  BoardClocks(std::uint64_t video_period_ps, std::uint64_t bus_period_ps, std::uint64_t bus_phase_ps)
      : video_period_(video_period_ps),
        bus_period_(bus_period_ps),
        next_video_(video_period_ps),
        next_bus_(bus_period_ps + bus_phase_ps) {}

  // Advances to the next rising edge of a clock, or of both if they rise together.
  Edge next() {
    const Edge edge = {.video = next_video_ <= next_bus_,
                       .bus = next_bus_ <= next_video_,
                       .time_ps = next_video_ <= next_bus_ ? next_video_ : next_bus_};
    next_video_ += edge.video ? video_period_ : 0;
    next_bus_ += edge.bus ? bus_period_ : 0;
    return edge;
  }

  template <class Model>
  static void raise(Model& model, const Edge& edge) {
    model.clk_i = edge.video;
    model.bus_clk_i = edge.bus;
    rise(model);
  }

 private:
  std::uint64_t video_period_;
  std::uint64_t bus_period_;
  std::uint64_t next_video_;
  std::uint64_t next_bus_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_CLOCKS_H
