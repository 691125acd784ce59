#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/column_runs.h"
#include "model/packet_payload.h"
#include "sim/board/moments_engine.h"

namespace selfproj {
namespace {

class ModelEngine final : public MomentsEngine {
 public:
  [[nodiscard]] std::string name() const override { return "model"; }

  void process(std::span<const ImageView> frames, const MomentsSettings& settings, std::span<Runs> out) override {
    const Measure& measure = settings.measure;
    std::vector<std::uint8_t> payload(moments_payload_bytes(measure.mode, settings.columns));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      out[i].resize(measure.select, settings.columns);
      measure_columns(frames[i], measure, out[i].view());
      if (measure.select == Select::strongest) {  // as a packet tells it
        pack_runs(measure.mode, settings.columns, out[i].view(), payload.data());
        unpack_runs(measure.mode, settings.columns, payload.data(), out[i].view());
      }
    }
  }
};

}  // namespace

std::unique_ptr<MomentsEngine> make_moments_model_engine() { return std::make_unique<ModelEngine>(); }

}  // namespace selfproj
