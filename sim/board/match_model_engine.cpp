#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/gray_match.h"
#include "sim/board/match_engine.h"

namespace selfproj {
namespace {

class MatchModelEngine final : public MatchEngine {
 public:
  MatchModelEngine(std::vector<std::uint16_t> table, int bits) : table_(std::move(table)), bits_(bits) {}

  [[nodiscard]] std::string name() const override { return "model"; }

  void look_up(const std::uint16_t* codes, int rows, int columns, std::uint16_t* lines) override {
    GrayMatch::look_up(codes, static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), bits_, table_.data(),
                       lines);
  }

 private:
  std::vector<std::uint16_t> table_;
  int bits_;
};

}  // namespace

std::unique_ptr<MatchEngine> make_match_model_engine(std::vector<std::uint16_t> table, int bits) {
  return std::make_unique<MatchModelEngine>(std::move(table), bits);
}

}  // namespace selfproj
