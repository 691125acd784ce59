// Stepping a Verilated model from one rising edge to the next.
//
// Nothing in the circuits happens at a falling edge, so that an evaluation there only tells the model that the clock is
// low. lower_clocks() tells it without one, which saves up to half of the evaluations.
//
//     BoardClocks clocks(6614, 8000, 1234);               // periods and phase in ps
//     const BoardClocks::Edge edge = clocks.next();    // of which clock, and when
//     ... inputs, from the outputs before the edge ...
//     clocks.raise(model, edge);
#ifndef SELFPROJ_SIM_DEVICE_CLOCKS_H
#define SELFPROJ_SIM_DEVICE_CLOCKS_H

#include <cstdint>

namespace selfproj {

// All clocks of the model are low, and were so at the last evaluation. Defined for the models that selfproj_verilate()
// (cmake/Verilated.cmake) was given the CLOCKS of.
template <class Model>
void lower_clocks(Model& model);

// The board's two unrelated clocks: periods in ps, and by how much the bus clock's first edge is later than one period.
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

  // To the next rising edge of a clock, or of both where they rise together.
  Edge next() {
    const Edge edge = {.video = next_video_ <= next_bus_,
                       .bus = next_bus_ <= next_video_,
                       .time_ps = next_video_ <= next_bus_ ? next_video_ : next_bus_};
    next_video_ += edge.video ? video_period_ : 0;
    next_bus_ += edge.bus ? bus_period_ : 0;
    return edge;
  }

  // The model at that edge. A clock is low again before the next edge of either.
  template <class Model>
  static void raise(Model& model, const Edge& edge) {
    lower_clocks(model);
    model.clk_i = edge.video;
    model.bus_clk_i = edge.bus;
    model.eval();
  }

 private:
  std::uint64_t video_period_;
  std::uint64_t bus_period_;
  std::uint64_t next_video_;
  std::uint64_t next_bus_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_DEVICE_CLOCKS_H
