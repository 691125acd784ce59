#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "model/column_moments.h"
#include "sim/board/moments_engine.h"

namespace selfproj {
namespace {

class ModelEngine final : public MomentsEngine {
 public:
  [[nodiscard]] std::string name() const override { return "model"; }

  void process(std::span<const ImageView> frames, const MomentsSettings& settings, std::span<Moments> out) override {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      out[i].resize(settings.columns);
      column_moments(frames[i], settings.mode, settings.threshold, out[i].view());
    }
  }
};

}  // namespace

std::unique_ptr<MomentsEngine> make_moments_model_engine() { return std::make_unique<ModelEngine>(); }

}  // namespace selfproj
