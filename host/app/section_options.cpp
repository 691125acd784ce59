#include "host/app/section_options.h"

#include <fmt/format.h>

#include <string>

#include "host/camera/camera_uri.h"
#include "host/cli/command_line.h"
#include "host/files/user_error.h"
#include "host/images/frame_options.h"
#include "host/light_section/reference.h"
#include "host/light_section/reference_file.h"
#include "model/pixel_clock.h"

namespace selfproj {

Rig SectionOptions::load_rig() const {
  Rig result = load_any_rig(rig);
  if (result.kind != RigKind::light_section) {
    throw UserError(rig, "is not a rig of kind light-section");
  }
  if (pixel_clock_hz) {
    result.board = RigBoard{.pixel_clock_hz = *pixel_clock_hz};
  }
  return result;
}

ReferenceProfile SectionOptions::load_reference(const Rig& loaded) const {
  return reference.empty() ? reference_of_plane(loaded) : selfproj::load_reference(loaded, reference);
}

Measure measure_of_rig(const Rig& rig, const std::string& select) {
  Measure measure = rig.measure.of_board();
  if (!select.empty()) {
    measure.select = select_of(select);
    measure.gap = measure.select == Select::all ? 0 : measure.gap;
  }
  return measure;
}

void add_section_options(CLI::App& command, SectionOptions& options) {
  command.add_option("--rig", options.rig, "Built-in rig or YAML file.")->type_name("RIG")->capture_default_str();
  command
      .add_option("--reference", options.reference,
                  "Folder that `selfproj pattern` wrote for the good part whose pattern is projected.")
      ->type_name("DIR")
      ->default_str("the empty plane");
  command
      .add_option("--pixel-clock-hz", options.pixel_clock_hz,
                  "Pixel clock of the board in Hz, which its time stamps count.")
      ->transform(real_number(kMinPixelClockHz, kMaxPixelClockHz))
      ->type_name("HZ")
      ->default_str(fmt::format("the rig's, or {:.0f}", kDefaultPixelClockHz));
}

}  // namespace selfproj
