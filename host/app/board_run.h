#ifndef SELFPROJ_HOST_APP_BOARD_RUN_H
#define SELFPROJ_HOST_APP_BOARD_RUN_H

#include <memory>
#include <string>

#include "host/driver/control.h"
#include "host/rig/rig.h"
#include "model/column_runs.h"

namespace selfproj {

// The board of an inspection: set up as the rig says, and running. A board that was stopped before is stopped again at
// the end.
class BoardRun {
 public:
  // `control` is the URI of the board's control, "none", or empty for the one that belongs to `device`, if there is
  // one. The board then measures `measure` in images of the rig's camera. Throws UserError, also if the board was built
  // without what is to be measured.
  BoardRun(const std::string& device, const std::string& control, const RigCamera& camera, const Measure& measure);
  BoardRun(const BoardRun&) = delete;
  BoardRun& operator=(const BoardRun&) = delete;
  ~BoardRun();

 private:
  std::unique_ptr<Control> control_;  // empty: the device has no control
  bool ran_ = true;                   // the board ran before
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_BOARD_RUN_H
