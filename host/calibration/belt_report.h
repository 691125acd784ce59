// How the belt lies before the camera, and whether the plates over it are where they are said to be.
#ifndef SELFPROJ_HOST_CALIBRATION_BELT_REPORT_H
#define SELFPROJ_HOST_CALIBRATION_BELT_REPORT_H

#include <string>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/bundle_plates.h"
#include "host/calibration/calibration_report.h"

namespace selfproj {

// What is wrong with the plates of a result, for the user; empty if nothing: a plate that is off by more than its
// tolerance and what the camera sees, or a belt that does not move the chessboard as far as it is said to. In the fit
// itself a wrong height looks like noise, so that the camera alone is asked, with the lens found.
std::string fault_of_plates(const std::vector<View>& views, const Plates& plates, const Bundle& found);

// What the drawings say against the distance of the belt, mm, and the focal length of the camera, px, that a fit has
// found, and the likely reason; empty if both are within their tolerances.
std::string fault_of_scale(const DrawnScale& drawn, double distance_mm, double focal_px);

// Puts all lengths of the result into mm of the plates' heights, and tells of the belt.
BeltReport belt_report(const Plates& plates, BundleResult& result);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_BELT_REPORT_H
