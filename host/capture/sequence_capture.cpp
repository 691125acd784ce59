#include "host/capture/sequence_capture.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "host/camera/camera.h"
#include "host/camera/open_camera.h"
#include "host/capture/light_check.h"
#include "host/files/json_text.h"
#include "selfproj/files/user_error.h"

namespace selfproj::capture {
namespace {

// The camera, with its software trigger where it has one and the URI says nothing else.
std::unique_ptr<camera::Camera> open_for_capture(const std::string& text, bool& triggered) {
  camera::CameraUri uri = camera::parse_camera_uri(text);
  if (!uri.camera.trigger.empty() && uri.camera.trigger != "free" && uri.camera.trigger != "software") {
    throw UserError(uri.uri, "trigger: must be software or free for a capture");
  }
  triggered = uri.camera.trigger == "software";
  if (uri.camera.trigger.empty() && !uri.camera.rate && !uri.name.starts_with("/dev/")) {
    uri.camera.trigger = "software";
    try {
      std::unique_ptr<camera::Camera> camera = camera::open_camera(uri);
      triggered = true;
      return camera;
    } catch (const UserError&) {  // it may have no such trigger; any other reason comes again
      uri.camera.trigger = "free";
    }
  }
  return camera::open_camera(uri);
}

// Takes the images of a sequence, in its order.
class SequenceTaker {
 public:
  SequenceTaker(Shots& shots, images::ImageSequence& patterns, const WhiteAndBlack& levels, CaptureRecord& record)
      : shots_(shots),
        patterns_(patterns),
        levels_(levels),
        record_(record),
        wait_ns_(static_cast<std::int64_t>(record.settle.settle_ms * 1e6)) {}

  void run(const TakeShot& take) {
    for (std::size_t i = 0; i < patterns_.count();) {
      images::Image pattern = patterns_.read(i);
      const images::Image next = i + 1 < patterns_.count() ? patterns_.read(i + 1) : images::Image{};
      if (is_negative(pattern, next)) {
        const Pair images = pair(i, pattern, next);
        deliver(i, images.pattern, take);
        deliver(i + 1, images.negative, take);
        i += 2;
      } else {
        deliver(i, one(i, pattern, wait_ns_), take);
        ++i;
      }
    }
  }

 private:
  struct Taken {
    images::Image image;
    double delay_ms = 0;
  };
  struct Pair {
    Taken pattern;
    Taken negative;
  };

  Taken one(std::size_t i, const images::Image& pattern, std::int64_t wait_ns) {
    const std::int64_t shown = shots_.show(pattern, patterns_.files()[i]);
    Taken taken{.image = shots_.take_after(shown + wait_ns), .delay_ms = 0};
    taken.delay_ms = static_cast<double>(shots_.taken_ns() - shown) * 1e-6;
    return taken;
  }

  // Takes a pattern and its negative until they add up. If they do not although nothing changes any more, a bent curve
  // of the camera or an iris of the projector is the reason, and they count.
  Pair pair(std::size_t i, const images::Image& pattern, const images::Image& negative) {
    constexpr int kMaxTries = 8;
    constexpr std::int64_t kLonger = 200'000'000;
    Pair last;
    for (int tries = 0; tries < kMaxTries; ++tries) {
      const std::int64_t wait = tries == 0 ? wait_ns_ : 2 * wait_ns_ + kLonger;
      Pair now{.pattern = one(i, pattern, wait), .negative = one(i + 1, negative, wait)};
      const bool same = tries > 1 && same_light(now.pattern.image, last.pattern.image, levels_) &&
                        same_light(now.negative.image, last.negative.image, levels_);
      if (same || adds_up(now.pattern.image, now.negative.image, levels_)) {
        return now;
      }
      shots_.count_mixed(2);
      last = std::move(now);
    }
    throw UserError(record_.camera,
                    fmt::format("the images of {} and of its negative differ from one time to the next; does something "
                                "move, or does the light change?",
                                patterns_.files()[i]));
  }

  void deliver(std::size_t i, const Taken& taken, const TakeShot& take) {
    take(i, patterns_.count(), taken.image);
    record_.shots.push_back({.pattern = std::filesystem::path(patterns_.files()[i]).filename().string(),
                             .image = fmt::format("image_{:04}.png", i + 1),
                             .delay_ms = taken.delay_ms});
  }

  Shots& shots_;
  images::ImageSequence& patterns_;
  const WhiteAndBlack& levels_;
  CaptureRecord& record_;
  std::int64_t wait_ns_;
};

}  // namespace

std::string capture_json(const CaptureRecord& record) {
  using Json = nlohmann::ordered_json;
  Json json = {{"camera", record.camera},
               {"display", record.display},
               {"columns", record.columns},
               {"rows", record.rows},
               {"trigger", record.triggered ? "software" : "free"},
               {"settle_ms", record.settle.settle_ms}};
  if (record.settle_measured) {
    json["delay_min_ms"] = record.settle.min_ms;
    json["delay_max_ms"] = record.settle.max_ms;
  }
  json["saturated"] = record.exposure.saturated;
  json["dark"] = record.exposure.dark;
  json["retaken_incomplete"] = record.retaken.incomplete;
  json["retaken_missing"] = record.retaken.missing;
  json["retaken_mixed"] = record.retaken.mixed;
  for (const CaptureRecord::Shot& shot : record.shots) {
    json["images"].push_back({{"image", shot.image}, {"pattern", shot.pattern}, {"delay_ms", shot.delay_ms}});
  }
  return files::json_text(json, 2) + "\n";
}

CaptureRecord capture_sequence(const CaptureSetup& setup, const PatternsFor& patterns_for,
                               const std::function<void(const CaptureRecord&)>& begin, const TakeShot& take) {
  CaptureRecord record;
  record.display = setup.display;
  const std::unique_ptr<camera::Camera> camera = open_for_capture(setup.camera, record.triggered);
  record.camera = camera->uri();
  record.rows = camera->rows();
  record.columns = camera->columns();
  Projector projector(setup.display, setup.greys);
  images::ImageSequence patterns = patterns_for({record.rows, record.columns, projector.rows(), projector.columns()});
  if (const images::Image& first = patterns.first();
      first.rows != projector.rows() || first.columns != projector.columns()) {
    projector.show(first, patterns.files()[0]);  // says so before anything is measured
  }
  camera->start();
  Shots shots(projector, *camera, record.triggered);
  const WhiteAndBlack levels = take_white_and_black(shots, record.camera, setup.settle_ms);
  record.exposure = check_exposure(levels);
  record.white = levels.white;
  record.settle_measured = !setup.settle_ms;
  record.settle =
      setup.settle_ms ? Settle{.settle_ms = *setup.settle_ms} : measure_settle(shots, levels, record.camera);
  begin(record);
  SequenceTaker(shots, patterns, levels, record).run(take);
  record.retaken = shots.counters();
  camera->stop();
  return record;
}

}  // namespace selfproj::capture
