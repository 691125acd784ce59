#include "lab/image_profiler.h"

#include <stdexcept>

#include "selfproj/model/board.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"

namespace selfproj::lab {
namespace {

model::BoardSettings settings_of(const rig::Rig& rig) {
  const model::Measure measure = rig.measure.of_board();
  return {.columns = rig.camera.columns,
          .rows = rig.camera.rows,
          .mode = measure.mode,
          .threshold = measure.threshold,
          .select = measure.select,
          .gap = measure.gap,
          .window = measure.window};
}

}  // namespace

ImageProfiler::ImageProfiler(const rig::Rig& rig, const light_section::ReferenceProfile& reference)
    : board_(settings_of(rig)), profiler_(rig, reference) {}

void ImageProfiler::profile(const model::ImageView& image, const light_section::ProfileView& to,
                            model::Moments* moments) {
  board_.process(image, true, 0, {});
  model::PacketView packet;
  if (!board_.next(packet) || !profiler_.profile(packet, to)) {
    throw std::invalid_argument("image profiler: the board's packet does not go with the reference");
  }
  if (moments != nullptr) {
    model::Runs runs;
    runs.resize(static_cast<model::Select>(packet.header.select), packet.header.columns);
    model::unpack_columns(packet.header, packet.payload.data(), runs.view());
    *moments = runs.moments;
  }
}

}  // namespace selfproj::lab
