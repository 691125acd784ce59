// The URI of a camera, with the settings of the camera and of the board in software:
//
//     camera:NAME[?KEY=VALUE[&KEY=VALUE]...]
//
// NAME is a name that `selfproj devices` lists, the network address of a GigE camera, or the path of a V4L2 device.
// Without a name it is the only camera there is.
#ifndef SELFPROJ_HOST_CAMERA_CAMERA_URI_H
#define SELFPROJ_HOST_CAMERA_CAMERA_URI_H

#include <optional>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"

namespace selfproj::camera {

// What is not given stays as the camera has it. Its automatics of exposure and gain are switched off in any case.
struct CameraParameters {
  std::optional<double> exposure_us;
  std::optional<double> gain;
  std::optional<double> rate;               // images a second, where nothing triggers the camera
  std::optional<images::ImagePart> region;  // of the sensor
  std::string format;                       // pixel_format.h; empty: Mono8, or for V4L2 the luminance of what it has
  int bits = spec::kPixelBits;  // of its pixels that count; more than 8: the format has as many, and no colours
  std::optional<images::Channel> channel;  // where the format has colours
  std::string trigger;              // free, software, or the name of the camera's input, such as Line1; empty: free
  std::optional<int> packet_bytes;  // GigE; as the camera has it unless given
  int buffers = 64;                 // images that wait in memory until they are taken
};

// Settings of the board in software, as the registers of a board have them.
struct CameraBoardSettings {
  std::optional<model::Mode> mode = {};
  std::optional<int> threshold = {};
  std::optional<model::Select> select = {};
  std::optional<int> gap = {};
  std::optional<model::RowWindow> window = {};
  std::optional<int> bits = {};  // of a pixel that the moments are of, 8..model::kMaxPixelBits; nothing: 8
  int region_row = 0;            // where on the sensor the images begin, from 1; 0: not said
  int region_column = 0;
  bool compact = false;               // columns in packets of kind compact
  std::optional<int> code_bits = {};  // given: Gray codes are decoded
  std::optional<int> code_threshold = {};
  std::optional<int> patterns = {};  // patterns that follow each other; image k shows pattern k modulo this
  std::optional<int> stream = {};
  std::optional<double> pixel_clock_hz = {};  // in which time stamps count
  bool median = false;
  bool image = false;  // raw images, too
};

struct CameraUri {
  std::string uri;   // without its parameters
  std::string name;  // empty: the only camera
  CameraParameters camera;
  CameraBoardSettings board;
};

// Whether the text begins with "camera:".
bool is_camera_uri(const std::string& text);

// Throws UserError with the URI if it is none, if a key is unknown or comes twice, or if a value is out of its range.
CameraUri parse_camera_uri(const std::string& text);

// A line for each key: "exposure-us=NUMBER" and what it means. For the help of commands.
std::vector<std::string> camera_uri_help();

}  // namespace selfproj::camera

#endif  // SELFPROJ_HOST_CAMERA_CAMERA_URI_H
