// From the image of a line to its profile, as `selfproj inspect` has it of a camera's images.
#ifndef SELFPROJ_LAB_IMAGE_PROFILER_H
#define SELFPROJ_LAB_IMAGE_PROFILER_H

#include "host/camera/software_board.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/rig/rig.h"

namespace selfproj::lab {

class ImageProfiler {
 public:
  // Measures as the rig says. Throws as DifferentialProfiler does.
  ImageProfiler(const rig::Rig& rig, const light_section::ReferenceProfile& reference);

  // Makes the board's packet of an image of the camera's size, and the packet's profile.
  void profile(const model::ImageView& image, const light_section::ProfileView& to) { profile(image, to, nullptr); }

  // The same, and the packet's moments.
  void profile(const model::ImageView& image, const light_section::ProfileView& to, model::Moments* moments);

 private:
  camera::SoftwareBoard board_;
  light_section::DifferentialProfiler profiler_;
};

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_IMAGE_PROFILER_H
