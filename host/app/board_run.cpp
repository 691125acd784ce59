#include "host/app/board_run.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "host/driver/control.h"
#include "host/files/user_error.h"

namespace selfproj {
namespace {

// The URI of the control that belongs to the device. Empty if there is none, or its file does not exist: the board then
// keeps its settings.
std::string control_of(const std::string& device) {
  const std::string uri = control_uri(device);
  std::error_code unused;
  const bool missing = uri.starts_with("bar:") && !std::filesystem::exists(uri.substr(4), unused);
  return missing ? "" : uri;
}

}  // namespace

BoardRun::BoardRun(const std::string& device, const std::string& control, const RigCamera& camera,
                   const Measure& measure) {
  const std::string uri = control == "none" ? "" : control.empty() ? control_of(device) : control;
  if (uri.empty()) {
    return;
  }
  control_ = open_control(uri);
  ran_ = control_->read("control.run") != 0;
  const auto number = [](int value) { return static_cast<std::uint32_t>(value); };
  if (measure.select == Select::strongest && !control_->build().runs) {
    throw UserError(uri, "this board is built without the strongest run; select all lit pixels");
  }
  control_->write_together({{register_part("size.columns"), number(camera.columns)},
                            {register_part("size.rows"), number(camera.rows)},
                            {register_part("measure.mode"), number(static_cast<int>(measure.mode))},
                            {register_part("measure.threshold"), number(measure.threshold)},
                            {register_part("measure.select"), number(static_cast<int>(measure.select))},
                            {register_part("measure.gap"), number(measure.gap)},
                            {register_part("window.first"), number(measure.window.first)},
                            {register_part("window.last"), number(measure.window.last)},
                            {register_part("control.run"), 1}});
}

BoardRun::~BoardRun() {
  if (control_ != nullptr && !ran_) {
    try {
      control_->write("control.run", 0);
    } catch (const UserError&) {  // a board that does not answer any more cannot be stopped
    }
  }
}

}  // namespace selfproj
