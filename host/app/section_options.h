// The options of commands that measure by light section: the rig, its pixel clock, the reference.
#ifndef SELFPROJ_HOST_APP_SECTION_OPTIONS_H
#define SELFPROJ_HOST_APP_SECTION_OPTIONS_H

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "host/camera/camera_device.h"
#include "host/light_section/reference.h"
#include "host/rig/rig.h"
#include "model/column_runs.h"

namespace selfproj {

struct SectionOptions {
  std::string rig = "light-section";
  std::string reference;                 // empty: the plane
  std::optional<double> pixel_clock_hz;  // empty: the rig's

  // The rig, with the pixel clock. Throws UserError if it is none of kind light-section.
  [[nodiscard]] Rig load_rig() const;

  // The reference of the folder, or the rig's empty table or conveyor. Throws UserError.
  [[nodiscard]] ReferenceProfile load_reference(const Rig& loaded) const;
};

// What the board is told to measure: as the rig says, except for what --select says, if it is not empty.
Measure measure_of_rig(const Rig& rig, const std::string& select = {});

// Adds --rig, --reference and --pixel-clock-hz.
void add_section_options(CLI::App& command, SectionOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_SECTION_OPTIONS_H
