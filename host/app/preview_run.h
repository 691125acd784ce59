// `selfproj capture --preview`: shows the camera's image in a browser while the user sets up camera and projector.
#ifndef SELFPROJ_HOST_APP_PREVIEW_RUN_H
#define SELFPROJ_HOST_APP_PREVIEW_RUN_H

#include <string>

#include "host/app/capture_options.h"

namespace selfproj {

// Shows white on the projector, and serves a page at `endpoint` with the camera's newest image and figures of its
// exposure. Ends at Esc or Ctrl-C. The camera runs free. Throws UserError.
void run_preview(const CaptureOptions& options, const std::string& endpoint);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_PREVIEW_RUN_H
