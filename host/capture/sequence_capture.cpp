#include "host/capture/sequence_capture.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/camera/camera.h"
#include "host/camera/open_camera.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace {

// The camera, with its software trigger where it has one and the URI says nothing else.
std::unique_ptr<Camera> open_for_capture(const std::string& text, bool& triggered) {
  CameraUri uri = parse_camera_uri(text);
  if (!uri.camera.trigger.empty() && uri.camera.trigger != "free" && uri.camera.trigger != "software") {
    throw UserError(uri.uri, "trigger: a capture needs software or free");
  }
  triggered = uri.camera.trigger == "software";
  if (uri.camera.trigger.empty() && !uri.camera.rate && !uri.name.starts_with("/dev/")) {
    uri.camera.trigger = "software";
    try {
      std::unique_ptr<Camera> camera = open_camera(uri);
      triggered = true;
      return camera;
    } catch (const UserError&) {  // it may have no such trigger; any other reason comes again
      uri.camera.trigger = "free";
    }
  }
  return open_camera(uri);
}

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
    json["delay_least_ms"] = record.settle.least_ms;
    json["delay_most_ms"] = record.settle.most_ms;
  }
  json["saturated"] = record.exposure.saturated;
  json["dark"] = record.exposure.dark;
  json["retaken_incomplete"] = record.retaken.incomplete;
  json["retaken_missing"] = record.retaken.missing;
  for (const CaptureRecord::Shot& shot : record.shots) {
    json["images"].push_back({{"image", shot.image}, {"pattern", shot.pattern}, {"delay_ms", shot.delay_ms}});
  }
  return json.dump(2) + "\n";
}

CaptureRecord capture_sequence(const CaptureSetup& setup, const PatternsFor& patterns_for,
                               const std::function<void(const CaptureRecord&)>& begin, const TakeShot& take) {
  CaptureRecord record;
  record.display = setup.display;
  const std::unique_ptr<Camera> camera = open_for_capture(setup.camera, record.triggered);
  record.camera = camera->uri();
  record.rows = camera->rows();
  record.columns = camera->columns();
  Projector projector(setup.display, setup.greys);
  ImageSequence patterns = patterns_for({record.rows, record.columns, projector.rows(), projector.columns()});
  if (const Image& first = patterns.first(); first.rows != projector.rows() || first.columns != projector.columns()) {
    projector.show(first, patterns.files()[0]);  // says so before anything is measured
  }
  camera->start();
  Shots shots(projector, *camera, record.triggered);
  const WhiteAndBlack levels = take_white_and_black(shots, record.camera);
  record.exposure = check_exposure(levels);
  record.white = levels.white;
  record.settle_measured = !setup.settle_ms;
  record.settle =
      setup.settle_ms ? Settle{.settle_ms = *setup.settle_ms} : measure_settle(shots, levels, record.camera);
  begin(record);
  const auto wait = static_cast<std::int64_t>(record.settle.settle_ms * 1e6);
  for (std::size_t i = 0; i < patterns.count(); ++i) {
    const std::string& file = patterns.files()[i];
    const std::int64_t shown = shots.show(patterns.read(i), file);
    take(i, patterns.count(), shots.take_after(shown + wait));
    record.shots.push_back({.pattern = std::filesystem::path(file).filename().string(),
                            .image = fmt::format("image_{:04}.png", i + 1),
                            .delay_ms = static_cast<double>(shots.taken_ns() - shown) * 1e-6});
  }
  record.retaken = shots.counters();
  camera->stop();
  return record;
}

}  // namespace selfproj
