// A running line of structured light: parts out of depth images, judged, and told to everyone who wants to know.
#ifndef SELFPROJ_HOST_PRODUCTION_DEPTH_LINE_H
#define SELFPROJ_HOST_PRODUCTION_DEPTH_LINE_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "host/images/float_image.h"
#include "host/production/depth_cutter.h"
#include "host/production/judge.h"
#include "host/production/line_worker.h"
#include "host/production/slot_queue.h"
#include "host/rig/rig.h"
#include "model/packet.h"

namespace selfproj {

// Takes depth images, and their differences from the reference, from one thread and works on them in another. None is
// dropped: where the line falls kQueued images behind, claim() waits, the packets wait in the ring, and what is then
// lost is lost in the ring and counted there.
class DepthLine final : public LineWorker {
 public:
  static constexpr std::size_t kQueued = 8;

  // A depth image of the camera's size: z, and z_R - z, in mm; NaN where there is none.
  struct Maps {
    FloatImage depth;
    FloatImage difference;
  };

  // Who wants to know, as for PartLine.
  struct Listeners {
    std::function<void(const PacketHeader&, const Maps&)> image = {};
    TakePart part = {};
  };

  // `patterns` are the frames of a depth image, 2 m. Without a judge nothing is cut, and only images are told. The
  // judge must outlive the line. Throws UserError, naming the rig, as DepthCutter does.
  DepthLine(const Rig& rig, int patterns, const Judge* judge, Listeners listeners);
  DepthLine(const DepthLine&) = delete;
  DepthLine& operator=(const DepthLine&) = delete;
  ~DepthLine() override { stop(); }

  // Takes the image whose last frame has this header. Waits while the queue is full. Throws what a listener has thrown.
  void add(const PacketHeader& header, std::int64_t arrival_ns, const FloatImage& depth, const FloatImage& difference);

 private:
  bool work() override;
  bool any() override { return queue_.front() != nullptr; }
  [[nodiscard]] bool in_part() const override { return cutter_ && cutter_->in_part(); }
  void cut_now() override { cutter_->finish(); }
  [[nodiscard]] std::uint64_t specks() const override { return cutter_->specks(); }

  std::function<void(const PacketHeader&, const Maps&)> image_;
  SlotQueue<Maps> queue_;
  std::optional<DepthCutter> cutter_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_DEPTH_LINE_H
