// A rig: camera, projector, conveyor, and how it is measured and simulated. Rigs are read from YAML and written to it,
// with the units in the names of the keys (light-section.yaml beside this file shows them all).
//
// World frame (docs/rigs.md): origin at the camera's optical centre, z along its optical axis, x the conveying
// direction. Row, line and column numbers count from 0 here.
//     image row (down)     <-> Xc <-> x       projector line   <-> Xp
//     image column (right) <-> Yc <-> y       projector column <-> Yp
#ifndef SELFPROJ_RIG_RIG_H
#define SELFPROJ_RIG_RIG_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/pixel_clock.h"

namespace selfproj::rig {

enum class RigKind : std::uint8_t { light_section, scanner };

// What of its sensor a camera sends while it measures. Rows and columns that lie before it count from 0, as OffsetY and
// OffsetX of GenICam.
struct RigRegion {
  int row_offset = 0;  // rows of the sensor before the first one that is sent
  int rows = 0;
  int column_offset = 0;
  int columns = 0;  // a multiple of 4
  double frame_rate_hz = 0;
  double exposure_s = 0;

  bool operator==(const RigRegion&) const = default;
};

// A pinhole at the origin that looks along z. Pixel (row r, column c) has its centre at
//     Xc = pixel_pitch_mm (r - (rows - 1)/2),  Yc = pixel_pitch_mm (c - (columns - 1)/2)      (3.3)
struct RigCamera {
  int rows = 0;
  int columns = 0;
  double pixel_pitch_mm = 0;
  double focal_length_mm = 0;
  double frame_rate_hz = 0;
  double exposure_s = 0;
  std::optional<RigRegion> region = {};  // while it measures; nothing: the whole sensor

  // What is sent while it measures.
  [[nodiscard]] RigRegion sent() const {
    return region.value_or(RigRegion{.row_offset = 0,
                                     .rows = rows,
                                     .column_offset = 0,
                                     .columns = columns,
                                     .frame_rate_hz = frame_rate_hz,
                                     .exposure_s = exposure_s});
  }

  // Where its frames begin, as packets and boards say it: row and column of the sensor from 1; 0 without a region.
  [[nodiscard]] int region_row() const { return region ? region->row_offset + 1 : 0; }
  [[nodiscard]] int region_column() const { return region ? region->column_offset + 1 : 0; }

  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  }
};

// A pinhole at (x, 0, z) whose axis is tilted by `tilt` from z towards -x. Line l, column c have their centre at
//     Xp = center_xp_mm + line_pitch_mm (l - (lines - 1)/2)
//     Yp = center_yp_mm + column_pitch_mm (c - (columns - 1)/2)
// where Xp grows with theta = tilt + atan(Xp / focal_length_mm) (3.6, 3.7)
//
// A pitch is negative if lines or columns count against Xp or Yp.
struct RigProjector {
  double x_mm = 0;
  double z_mm = 0;
  double tilt_rad = 0;
  double focal_length_mm = 0;
  int lines = 0;
  int columns = 0;
  double line_pitch_mm = 0;
  double column_pitch_mm = 0;
  double center_xp_mm = 0;
  double center_yp_mm = 0;
};

struct RigConveyor {
  double speed_mm_per_s = 0;        // along +x
  double encoder_mm_per_count = 0;  // mm the belt moves for each count of the encoder
};

struct RigBoard {
  double pixel_clock_hz = model::kDefaultPixelClockHz;  // the clock that its time stamps count
};

// The strongest run of each column (include/selfproj/model/column_runs.h), and what is ambiguous.
struct RigRuns {
  int gap_rows = 0;             // dark rows that two lit pixels of one run may have between them
  double ambiguous_from = 0.5;  // a column is invalid if its second run has at least this share of the strongest's M0
};

struct RigMeasure {
  model::Mode mode = model::Mode::grey_over;
  int threshold = 0;                            // light section: a pixel is lit if it is greater than this
  std::optional<int> pixel_bits = {};           // of the pixels that are measured; nothing: 8
  int min_lit_px = 0;                           // a column with fewer lit pixels is invalid
  int max_lit_px = 0;                           // a column with more lit pixels is invalid
  double line_width_px = 0;                     // width of a projected line, in projector lines
  int code_threshold = 0;                       // threshold of the Gray-code binarization (4.15)
  double max_z_per_line_mm = 0;                 // a point is invalid if one projector line is worth more in z
  std::optional<RigRuns> runs = {};             // select the strongest run; nothing: all lit pixels
  std::optional<model::RowWindow> window = {};  // rows that count; nothing: all
  std::optional<bool> compact = {};             // packets hold divided columns; nothing: no

  [[nodiscard]] bool sends_compact() const { return compact.value_or(false); }
  [[nodiscard]] int bits() const { return pixel_bits.value_or(spec::kPixelBits); }
  [[nodiscard]] int values_per_grey() const {
    return 1 << (bits() - spec::kPixelBits);
  }  // of pixels, in a grey of 8 bits

  // What the board measures, as its registers say.
  [[nodiscard]] model::Measure of_board() const {
    return {.mode = mode,
            .threshold = threshold,
            .select = runs ? model::Select::strongest : model::Select::all,
            .gap = runs ? runs->gap_rows : 0,
            .window = window.value_or(model::RowWindow{}),
            .bits = bits()};
  }

  // Makes this what `measure` says, as from options of a command.
  void apply(const model::Measure& measure) {
    mode = measure.mode;
    threshold = measure.threshold;
    pixel_bits = measure.bits == spec::kPixelBits ? std::nullopt : std::optional(measure.bits);
    if (measure.select == model::Select::all) {
      runs.reset();
    } else {
      runs = RigRuns{.gap_rows = measure.gap, .ambiguous_from = runs.value_or(RigRuns{}).ambiguous_from};
    }
    window = measure.window == model::RowWindow{} ? std::nullopt : std::optional(measure.window);
  }
};

// Light and noise, which only the simulation needs. Grey values are those of the 8-bit image; one of b bits has
// 2^(b - 8) values in each.
struct RigImaging {
  double white = 0;               // grey of a white surface, fully lit and facing the projector's light
  double ambient = 0;             // grey of a white surface without projector light
  double dark = 0;                // grey without any light
  double camera_blur_px = 0;      // standard deviation of the camera lens's Gaussian blur
  double projector_blur_px = 0;   // the same for the projector, in its own lines and columns
  double electrons_per_grey = 0;  // electrons that raise the grey value by one: shot noise
  double read_noise = 0;          // standard deviation, in grey values
  std::int64_t seed = 0;
};

// A lens as OpenCV describes it (include/selfproj/rig/calibration.h), in pixels: x along columns, y along rows or
// lines.
struct RigLens {
  double fx_px = 0, fy_px = 0;  // negative for a projector that counts against its axes
  double cx_px = 0, cy_px = 0;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
};

// The full model of a calibrated rig, in the calibration's axes: x along the camera's columns, y along its rows, z
// along its optical axis. x_projector = R x_camera + T. R rotates about the vector rotation_rad by its length.
struct RigCalibration {
  RigLens camera;
  RigLens projector;
  std::array<double, 3> rotation_rad{};
  std::array<double, 3> translation_mm{};
};

// The light plane of a laser line, in the calibration's axes: the points x with normal · x = distance.
struct RigLightPlane {
  std::array<double, 3> normal{};  // of length 1
  double distance_mm = 0;
};

// How the belt lies before the camera, in the calibration's axes. Both vectors have length 1. Without it the belt moves
// along the camera's rows and is parallel to its image.
struct RigBeltPose {
  std::array<double, 3> direction{0, 1, 0};  // the way the belt moves: x of the rig's frame
  std::array<double, 3> normal{0, 0, 1};     // from the camera to the belt: z of the rig's frame
};

// What `selfproj calibrate heights` found: how true heights over the plate differ from those of the geometry
// (include/selfproj/rig/height_correction.h). Only for a light section.
struct RigHeights {
  double min_mm = 0;  // range of the heights, by the geometry, that were calibrated
  double max_mm = 0;
  int order = 0;          // greatest degree of a term
  int order_heights = 0;  // greatest degree of a term in the height
  std::vector<double> corrections_mm;
};

// The greatest order that a rig may have.
inline constexpr int kMaxHeightOrder = 8;

// Degrees of the terms in column, row and height, in the order of RigHeights::corrections_mm: all whose sum is at most
// `order`, and whose degree in the height is at most `order_heights`.
std::vector<std::array<int, 3>> height_terms(int order, int order_heights);

// What tells one part from the next (host/production).
enum class PartCut : std::uint8_t {
  profile,   // a part begins where profiles are higher than above_mm, and ends where they are not any more
  distance,  // every length_mm of the belt is a part
  trigger,   // frames come only while a part is there: a pause of pause_s ends it
  image,     // a scanner: every depth image is a part
};

// How the stream of profiles, or of depth images, is cut into parts, and the grid of their maps. A scanner has cut,
// grid_mm and pause_s only; the rest says nothing.
struct RigParts {
  PartCut cut = PartCut::profile;
  bool by_encoder = true;    // the belt is where the encoder says; otherwise where speed and time stamps say
  double grid_mm = 0;        // distance of neighbouring cells of a map, along and across
  double above_mm = 0;       // what is higher above the plane belongs to a part
  double min_width_mm = 0;   // cut by profile: a profile belongs to a part if so much of it is higher than above_mm
  double gap_mm = 0;         // nothing narrower splits a part; cut by profile: it ends where the belt moves so far
  double pause_s = 0;        // cut by trigger: a pause of the frames that ends a part
  double min_length_mm = 0;  // what is shorter is not a part; cut by distance: without meaning
  double length_mm = 0;      // a part that is longer is cut here; cut by distance: the length of each
};

// Where a value of a rig comes from. Only a drawing's is not to be relied on.
enum class ValueSource : std::uint8_t {
  drawing,   // of the rig that a calibration began with: it was never measured
  measured,  // by a calibration
  assumed,   // the drawing's, and somebody says that it is right
};

// Where the values come from that make millimetres of a light section. A calibration that knows only some of them
// writes this; without it all values count as they stand.
struct RigSources {
  ValueSource camera = ValueSource::drawing;   // its lens
  ValueSource light = ValueSource::drawing;    // projector_lens and projector_pose, or light_plane
  ValueSource belt = ValueSource::drawing;     // plane_z_mm and belt_pose
  ValueSource speed = ValueSource::drawing;    // conveyor.speed_mm_per_s
  ValueSource encoder = ValueSource::drawing;  // conveyor.encoder_mm_per_count
};

struct Rig {
  std::string name;
  RigKind kind = RigKind::light_section;
  double plane_z_mm = 0;  // z of the conveyor or table
  RigCamera camera;
  RigProjector projector;
  RigConveyor conveyor;
  std::optional<RigBoard> board;  // absent if the rig does not say
  RigMeasure measure;
  RigImaging imaging;

  // If present, camera and projector above are the pinholes nearest to it. With a light plane it has a camera alone,
  // and the projector above means nothing.
  std::optional<RigCalibration> calibration;
  std::optional<RigLightPlane> light_plane;  // if present, a laser line takes the place of the projector
  std::optional<RigBeltPose> belt_pose;
  std::optional<RigHeights> heights;
  std::optional<RigParts> parts;
  std::optional<RigSources> sources;  // absent: all values count as they stand

  // Whether light and view follow the pinholes of (3.3) to (3.9), with nothing else to be known.
  [[nodiscard]] bool is_pinholes() const { return !calibration && !light_plane && !belt_pose && !heights; }

  // The board's pixel clock; the default one if the rig does not say.
  [[nodiscard]] double pixel_clock_hz() const { return board.value_or(RigBoard{}).pixel_clock_hz; }
};

// Names of the built-in rigs: light-section (rig A), scanner (rig B), laser (an example of a laser's line).
const std::vector<std::string>& built_in_rigs();

// A built-in rig by its name, or the rig of a YAML file. Throws UserError with file, line, key and reason if the file
// is unreadable or no YAML, or a key is missing, unknown (for example in another unit), doubled, no number, or out of
// range, or if the rig has a laser line in place of the projector.
Rig load_rig(const std::string& name_or_file);

// The same, but a laser line is welcome.
Rig load_any_rig(const std::string& name_or_file);

// Throws UserError about `source`, the rig's name or file, if its pixels have more than 8 bits, which `what` does not
// take.
void need_eight_bits(const Rig& rig, const std::string& source, const std::string& what);

// The same from a text (with a laser line or without); errors name `source`.
Rig parse_rig(const std::string& yaml, const std::string& source);

// What millimetres are taken from: a single section across the belt, or a part whose sections the belt moves past.
enum class Millimetres : std::uint8_t { of_section, of_part };

// Throws UserError, naming `source`, the value and the command that measures it, if the rig says (RigSources) that
// these millimetres would come from a value that was never measured. Of the conveyor's speed and encoder that counts
// which `parts` names; without `parts` one of them is enough.
void expect_measured(const Rig& rig, const std::string& source, Millimetres which = Millimetres::of_part);

// The same for the way of the belt alone, where it is known what it was taken from.
void expect_way_measured(const Rig& rig, bool by_encoder, const std::string& source);

// Takes the named values (camera, light, belt, speed, encoder; commas between them) as they stand in the rig. Throws
// UserError, naming `option`, for another name.
void assume(Rig& rig, const std::string& names, const std::string& option);

// The rig as YAML, which parse_rig reads back to equal values.
std::string to_yaml(const Rig& rig);

// The numbers of a rig that its references depend on, with the names that they have in reference files: camera and
// projector; of a laser line camera and plane; of a calibrated rig also lenses and pose; of corrected heights the
// corrections.
std::vector<std::pair<std::string, double>> geometry_of(const Rig& rig);

// Whether two of these numbers are the same. They are written so that they read back to the same value, but a rig that
// went through its YAML may differ in the last digit.
bool same_geometry(double a, double b);

}  // namespace selfproj::rig

#endif  // SELFPROJ_RIG_RIG_H
