// selfproj: what runs on the production PC.

#include "host/app/accuracy_command.h"
#include "host/app/calibrate_command.h"
#include "host/app/depth_command.h"
#include "host/app/devices_command.h"
#include "host/app/inspect_command.h"
#include "host/app/pattern_command.h"
#include "host/app/rig_command.h"
#include "host/app/stripes_command.h"
#include "host/io/program_main.h"

int main(int argc, char** argv) {
  return selfproj::program_main(
      "selfproj", "3-D inspection by self-projection: the production PC's side",
      [](CLI::App& app) {
        selfproj::add_rig_command(app);
        selfproj::add_pattern_command(app);
        selfproj::add_calibrate_command(app);
        selfproj::add_depth_command(app);
        selfproj::add_match_command(app);
        selfproj::add_accuracy_command(app);
        selfproj::add_devices_command(app);
        selfproj::add_inspect_command(app);
      },
      argc, argv);
}
