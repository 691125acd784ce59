// Which lens model the captures support, and whether they support one solution only.
#ifndef SELFPROJ_HOST_CALIBRATION_MODEL_CHOICE_H
#define SELFPROJ_HOST_CALIBRATION_MODEL_CHOICE_H

#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "host/calibration/bundle.h"

namespace selfproj::calibration {

// A step from one model to one with more coefficients, and what spoke for it.
struct ModelStep {
  FreeDistortion free;    // the larger model
  double chi_square = 0;  // of the freed coefficients: their squares over their covariance
  double limit = 0;       // that of five standard deviations, which it has to exceed
  bool taken = false;
};

struct ModelChoice {
  BundleResult result;
  FreeDistortion free;           // numbers, not kByData
  std::vector<Bundle> starts;    // each fitted with a flat chessboard without distortion, where that led anywhere
  std::vector<ModelStep> steps;  // in the order tried; none where both numbers were given
  // Of the starts, how many lead to the result, to a fit that is clearly worse, and nowhere.
  int agreeing = 0, worse = 0, failed = 0;
  std::string refusal;  // why the result must not be used; empty if it may
};

struct ModelSettings {
  cv::Size camera, projector;                       // sizes of the images
  FreeDistortion free;                              // 0, 1, 2, 4 or 5 for each lens, or kByData
  const std::vector<CornerModes>* shape = nullptr;  // of the chessboard; none: it is flat
  const Plates* plates = nullptr;                   // under the chessboards, if there are any
  bool with_projector = true;                       // false: the camera alone; `free.projector` is 0 then
};

// Frees the distortion step by step: none, k1, k2, then p1 and p2, each lens by itself. Where the data decide, a step
// is taken if the freed coefficients differ from 0 by more than five standard deviations. Each model begins at the
// smaller one's solution, so it never fits worse. Throws std::invalid_argument if there are fewer equations than
// unknowns, and std::runtime_error if nothing converges.
ModelChoice choose_model(const std::vector<View>& views, const ModelSettings& settings);

// The fit of a chosen model again, from its own result; `views` may have lost corners, but no view.
void refit(const std::vector<View>& views, const ModelSettings& settings, ModelChoice& choice);

// Repeats the fit of a chosen model from every start with the noise that it found. If one of them fits better, it takes
// the result's place. Sets the numbers of starts, and the refusal if two starts end in different solutions that the
// residuals cannot tell apart, or if a focal length or the distance between the lenses is not determined to 10 %.
void check_starts(const std::vector<View>& views, const ModelSettings& settings, ModelChoice& choice);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_MODEL_CHOICE_H
