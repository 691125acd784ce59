// `selfproj calibrate --camera`: takes the poses of the chessboard, and leads the user through them.
#ifndef SELFPROJ_HOST_APP_GUIDED_POSES_H
#define SELFPROJ_HOST_APP_GUIDED_POSES_H

#include <vector>

#include "host/app/capture_run.h"
#include "host/calibration/calibrate.h"
#include "host/calibration/capture.h"
#include "host/files/output_folder.h"

namespace selfproj::app {

// Before each pose it prints which to take, and waits for a line on standard input: an empty one captures, `u` takes
// the last pose back, `d` or the end of the input ends. After each capture it prints what was found and what the poses
// cover. The images of each pose go into the folder, pose_01/image_0001.png and so on, so that `selfproj calibrate`
// takes them again. `settings` are completed by the projector's size. Throws UserError, and CheckFailed at Ctrl-C, Esc,
// and where no two poses were taken.
std::vector<calibration::PoseReport> capture_guided_poses(const CaptureOptions& options,
                                                          const calibration::DecodeSettings& decode,
                                                          calibration::CalibrateSettings& settings,
                                                          files::OutputFolder& folder);

}  // namespace selfproj::app

#endif  // SELFPROJ_HOST_APP_GUIDED_POSES_H
