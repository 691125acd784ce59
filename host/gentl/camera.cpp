#include "host/gentl/camera.h"

#include <cctype>
#include <limits>
#include <utility>

#include "host/camera/camera_uri.h"
#include "host/driver/control.h"
#include "host/gentl/answer.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"

namespace selfproj::gentl {
namespace {

constexpr const char* kLocked = "TLParamsLocked";

Feature choice_feature(std::string category, std::string name, std::string tip, std::vector<FeatureEntry> entries,
                       std::function<std::int64_t()> get) {
  return {.kind = FeatureKind::choice,
          .name = std::move(name),
          .category = std::move(category),
          .tip = std::move(tip),
          .get = std::move(get),
          .entries = std::move(entries)};
}

Feature flag_feature(std::string category, std::string name, std::string tip, std::function<std::int64_t()> get,
                     std::function<void(std::int64_t)> set = {}) {
  return {.kind = FeatureKind::flag,
          .name = std::move(name),
          .category = std::move(category),
          .tip = std::move(tip),
          .get = std::move(get),
          .set = std::move(set),
          .max = 1};
}

Feature real_feature(std::string category, std::string name, std::string tip, double value, std::string unit = {}) {
  return {.kind = FeatureKind::real,
          .name = std::move(name),
          .category = std::move(category),
          .tip = std::move(tip),
          .get_real = [value] { return value; },
          .unit = std::move(unit)};
}

Feature command_feature(std::string name, std::string tip, std::function<void()> act) {
  return {.kind = FeatureKind::command,
          .name = std::move(name),
          .category = "AcquisitionControl",
          .tip = std::move(tip),
          .get = [] { return 0; },
          .set =
              [act = std::move(act)](std::int64_t value) {
                if (value != 0) {
                  act();
                }
              }};
}

// The key of a counter without underscores, each word with a capital.
std::string camel_case(const std::string& key) {
  std::string out;
  bool upper = true;
  for (const char c : key) {
    if (c == '_') {
      upper = true;
      continue;
    }
    out += upper ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    upper = false;
  }
  return out;
}

struct NamedCount {
  std::string name;
  std::string tip;
};

// The counters, in the order of their chunk.
std::vector<NamedCount> counts_of_source() {
  std::vector<NamedCount> names;
  for (const driver::CounterName& counter : driver::kCounterNames) {
    names.push_back({camel_case(counter.key), counter.label});
  }
  names.push_back({"OtherSize", "frames of another size, or of pixels of other bits, than the rig's camera"});
  names.push_back({"NotMoments", "packets of images and codes"});
  return names;
}

std::int64_t count_at(const SourceCounts& counts, std::size_t index) {
  const std::uint64_t value = index < driver::kCounterNames.size()
                                  ? counts.driver.*driver::kCounterNames.at(index).field
                              : index == driver::kCounterNames.size() ? counts.other_size
                                                                      : counts.not_moments;
  return static_cast<std::int64_t>(value);
}

}  // namespace

Camera::Camera(const DeviceEntry& entry, bool writable)
    : Module("Device", entry.id), entry_(entry), writable_(writable), source_(entry) {
  open_board(entry);
}

// A control that was named must answer. Without one that belongs to the device the settings can only be read.
void Camera::open_board(const DeviceEntry& entry) {
  if (!entry.control.empty()) {
    control_ = driver::open_control(entry.control);
    return;
  }
  if (camera::is_camera_uri(entry.id)) {
    control_problem_ = "none: " + entry.id + " is a camera without a board; its settings stand behind '?'";
    return;
  }
  const std::string control = driver::control_uri(entry.id);
  if (control.empty()) {
    control_problem_ = "none: " + entry.id + " has no control of a board beside it";
    return;
  }
  try {
    control_ = driver::open_control(control);
  } catch (const UserError& error) {
    control_problem_ = std::string("none: ") + error.what();
  }
}

FrameLayout Camera::layout() const {
  return {.columns = source_.rig().camera.columns,
          .height = height_,
          .range = range_,
          .intensity = intensity_,
          .abc = abc_,
          .chunks = chunks_};
}

void Camera::set_running(bool running) {
  {
    const std::lock_guard lock(gate_.mutex);
    gate_.running = running;
  }
  gate_.changed.notify_all();
}

void Camera::enable(bool on) {
  const bool other = component_ == kRangeId ? intensity_ : range_;
  require(on || other, GC_ERR_INVALID_VALUE, "ComponentEnable: at least one component must be enabled");
  enabled() = on;
}

std::int64_t Camera::format() const {
  return static_cast<std::int64_t>(component_ == kIntensityId ? kMono16 : abc_ ? kCoord3dAbc32f : kCoord3dC32f);
}

void Camera::set_format(std::int64_t format) {
  if (component_ == kRangeId) {
    abc_ = format == static_cast<std::int64_t>(kCoord3dAbc32f);
  }
}

void Camera::add_setting(FeatureSet& features, Feature feature, const std::string& part,
                         std::function<std::int64_t(const model::Measure&)> reported) {
  feature.category = "Measurement";
  feature.standard = false;
  feature.locked_by = "BoardControlMissing";
  feature.get = [this, part, reported = std::move(reported)] {
    return control_ != nullptr ? std::int64_t{control_->read(part)} : reported(source_.newest());
  };
  feature.set = [this, part](std::int64_t value) { control_->write(part, static_cast<std::uint32_t>(value)); };
  features.add(std::move(feature));
}

// The features. Names and meanings are those of the GenICam Standard Features Naming Convention 2.7, except for those
// that are marked as not standard.

void Camera::describe(FeatureSet& features) {
  describe_device(features);
  describe_image(features);
  describe_acquisition(features);
  describe_scan3d(features);
  describe_measurement(features);
  describe_counters(features);
  describe_chunks(features);
}

void Camera::describe_device(FeatureSet& features) {
  const char* const category = "DeviceControl";
  features.add(choice_feature(category, "DeviceType", "The kind of device.", {{"Transmitter", 0}}, [] { return 0; }));
  features.add(choice_feature(category, "DeviceScanType", "The camera gives lines of a 3-D scan.", {{"Linescan3D", 3}},
                              [] { return 3; }));
  features.add(text_feature(category, "DeviceVendorName", "Who made the device.", [] { return kVendor; }));
  features.add(text_feature(category, "DeviceModelName", "The rig, by its name.", [this] { return model(); }));
  features.add(text_feature(category, "DeviceID", "The URI from which packets come.", [this] { return entry_.id; }));
  features.add(text_feature(category, "DeviceUserID", "The name that SELFPROJ_GENTL_DEVICES gives to the device.",
                            [this] { return entry_.display_name(); }));
  features.add(
      number_feature(category, "DeviceSFNCVersionMajor", "Version of the standard's names.", [] { return 2; }));
  features.add(
      number_feature(category, "DeviceSFNCVersionMinor", "Version of the standard's names.", [] { return 7; }));
  features.add(
      number_feature(category, "DeviceSFNCVersionSubMinor", "Version of the standard's names.", [] { return 0; }));
}

void Camera::describe_image(FeatureSet& features) {
  const char* const category = "ImageFormatControl";
  const auto columns = [this] { return std::int64_t{source_.rig().camera.columns}; };
  features.add(number_feature(category, "SensorWidth", "Columns of the camera.", columns));
  features.add(number_feature(category, "SensorHeight", "Rows of the camera, of which each line is measured.",
                              [this] { return std::int64_t{source_.rig().camera.rows}; }));
  features.add(number_feature(category, "WidthMax", "Columns of a line.", columns));
  features.add(number_feature(category, "HeightMax", "Most lines in a buffer.", [] { return kMaxLines; }));
  features.add(number_feature(category, "Width", "Columns of a line.", columns));
  Feature height = number_feature(category, "Height", "Lines in a buffer.", [this] { return std::int64_t{height_}; });
  height.set = [this](std::int64_t value) { height_ = static_cast<int>(value); };
  height.min = 1;
  height.max = kMaxLines;
  height.locked_by = kLocked;
  features.add(height);

  Feature selector = choice_feature(category, "ComponentSelector", "The component that the features below describe.",
                                    {{"Intensity", kIntensityId}, {"Range", kRangeId}}, [this] { return component_; });
  selector.set = [this](std::int64_t value) { component_ = value; };
  selector.selects = {"ComponentEnable", "ComponentIDValue", "PixelFormat"};
  features.add(selector);
  Feature enable_one = flag_feature(
      category, "ComponentEnable", "Whether the component is in the buffers. Two components are parts of a buffer.",
      [this] { return enabled() ? 1 : 0; }, [this](std::int64_t value) { enable(value != 0); });
  enable_one.locked_by = kLocked;
  features.add(enable_one);
  features.add(
      number_feature(category, "ComponentIDValue", "The number of the component.", [this] { return component_; }));
  Feature pixel_format = choice_feature(
      category, "PixelFormat", "Points with A = x, B = y and C = z in mm, or C alone; for intensity, lit pixels.",
      {{"Mono16", static_cast<std::int64_t>(kMono16), "IntensityIsSelected"},
       {"Coord3D_C32f", static_cast<std::int64_t>(kCoord3dC32f), "RangeIsSelected"},
       {"Coord3D_ABC32f", static_cast<std::int64_t>(kCoord3dAbc32f), "RangeIsSelected"}},
      [this] { return format(); });
  pixel_format.set = [this](std::int64_t value) { set_format(value); };
  pixel_format.locked_by = kLocked;
  features.add(pixel_format);
  features.add(number_feature("", "RangeIsSelected", "1: ComponentSelector is Range.",
                              [this] { return component_ == kRangeId ? 1 : 0; }));
  features.add(number_feature("", "IntensityIsSelected", "1: ComponentSelector is Intensity.",
                              [this] { return component_ == kIntensityId ? 1 : 0; }));
}

void Camera::describe_acquisition(FeatureSet& features) {
  features.add(choice_feature("AcquisitionControl", "AcquisitionMode", "Buffers follow each other until the stop.",
                              {{"Continuous", 0}}, [] { return 0; }));
  features.add(command_feature("AcquisitionStart", "Begins to take lines.", [this] { set_running(true); }));
  features.add(command_feature("AcquisitionStop", "Ends it. A buffer that is not full is delivered with its lines.",
                               [this] { set_running(false); }));
  features.add(number_feature("TransportLayerControl", "PayloadSize", "Bytes of a buffer.",
                              [this] { return static_cast<std::int64_t>(layout().payload_bytes()); }));
  Feature locked = number_feature("TransportLayerControl", kLocked, "1: what changes the size of buffers is locked.",
                                  [this] { return locked_ ? 1 : 0; });
  locked.set = [this](std::int64_t value) { locked_ = value != 0; };
  locked.max = 1;
  features.add(locked);
}

void Camera::describe_scan3d(FeatureSet& features) {
  const char* const category = "Scan3dControl";
  features.add(choice_feature(category, "Scan3dOutputMode", "What the pixel format holds.",
                              {{"CalibratedABC_Grid", 1}, {"CalibratedC", 5}}, [this] { return abc_ ? 1 : 5; }));
  features.add(choice_feature(category, "Scan3dDistanceUnit", "Unit of the coordinates.", {{"Millimeter", 0}},
                              [] { return 0; }));
  features.add(
      choice_feature(category, "Scan3dCoordinateSystem", "Axes: x, y, z.", {{"Cartesian", 0}}, [] { return 0; }));
  features.add(choice_feature(category, "Scan3dCoordinateSystemReference", "Coordinates are those of the rig's camera.",
                              {{"Anchor", 0}}, [] { return 0; }));
  Feature selector =
      choice_feature(category, "Scan3dCoordinateSelector", "The coordinate that those below describe.",
                     {{"CoordinateA", 0}, {"CoordinateB", 1}, {"CoordinateC", 2}}, [this] { return coordinate_; });
  selector.set = [this](std::int64_t value) { coordinate_ = value; };
  selector.selects = {"Scan3dCoordinateScale", "Scan3dCoordinateOffset", "Scan3dInvalidDataFlag",
                      "Scan3dInvalidDataValue"};
  features.add(selector);
  features.add(real_feature(category, "Scan3dCoordinateScale", "Coordinates need no scale.", 1));
  features.add(real_feature(category, "Scan3dCoordinateOffset", "Coordinates need no offset.", 0, "mm"));
  features.add(flag_feature(category, "Scan3dInvalidDataFlag", "Pixels without a point have a value of their own.",
                            [] { return 1; }));
  features.add(real_feature(category, "Scan3dInvalidDataValue", "The value of pixels without a point: not a number.",
                            std::numeric_limits<double>::quiet_NaN()));
  Feature carried = flag_feature(
      category, "BeltCarriedBack", "Coordinate A is carried back by the way of the belt since the acquisition began.",
      [this] { return belt_carried_ ? 1 : 0; }, [this](std::int64_t value) { belt_carried_ = value != 0; });
  carried.standard = false;
  carried.locked_by = kLocked;
  features.add(carried);
}

void Camera::describe_measurement(FeatureSet& features) {
  features.add(number_feature("", "BoardControlMissing", "1: the board's settings can only be read.",
                              [this] { return control_ == nullptr ? 1 : 0; }));
  Feature board = text_feature("Measurement", "BoardControl", "Where the board's settings are written, or why not.",
                               [this] { return control_ != nullptr ? control_->uri() : control_problem_; });
  board.standard = false;
  features.add(board);
  add_setting(
      features,
      {.kind = FeatureKind::choice,
       .name = "MomentsMode",
       .tip = "What a lit pixel weighs.",
       .entries = {{"Binary", spec::kModeBinary}, {"Grey", spec::kModeGrey}, {"GreyOver", spec::kModeGreyOver}}},
      "measure.mode", [](const model::Measure& measure) { return static_cast<std::int64_t>(measure.mode); });
  const std::int64_t brightest = (std::int64_t{1} << source_.rig().measure.bits()) - 1;
  add_setting(features,
              {.name = "Threshold", .tip = "A pixel is lit where its grey value is greater.", .max = brightest},
              "measure.threshold", [](const model::Measure& measure) { return std::int64_t{measure.threshold}; });
  add_setting(features,
              {.kind = FeatureKind::choice,
               .name = "MomentsSelect",
               .tip = "Whether all lit pixels of a column count, or its strongest run.",
               .entries = {{"All", spec::kSelectAll}, {"Strongest", spec::kSelectStrongest}}},
              "measure.select",
              [](const model::Measure& measure) { return static_cast<std::int64_t>(measure.select); });
  add_setting(features,
              {.name = "RunGap", .tip = "Dark rows between two lit pixels of one run.", .max = model::kMaxGap},
              "measure.gap", [](const model::Measure& measure) { return std::int64_t{measure.gap}; });
  add_setting(features,
              {.name = "WindowFirstRow", .tip = "First row that counts, from 1; 0: the first.", .max = spec::kRowLimit},
              "window.first", [](const model::Measure& measure) { return std::int64_t{measure.window.first}; });
  add_setting(features,
              {.name = "WindowLastRow", .tip = "Last row that counts, from 1; 0: the last.", .max = spec::kRowLimit},
              "window.last", [](const model::Measure& measure) { return std::int64_t{measure.window.last}; });
}

void Camera::describe_counters(FeatureSet& features) {
  const std::vector<NamedCount> names = counts_of_source();
  for (std::size_t i = 0; i < names.size(); ++i) {
    Feature count =
        number_feature("DriverCounters", "Count" + names[i].name, "Since the device was opened: " + names[i].tip + ".",
                       [this, i] { return count_at(source_.counts(), i); });
    count.standard = false;
    features.add(count);
  }
}

void Camera::describe_chunks(FeatureSet& features) {
  const char* const category = "ChunkDataControl";
  Feature active = flag_feature(
      category, "ChunkModeActive", "Whether chunks follow the image in a buffer.", [this] { return chunks_ ? 1 : 0; },
      [this](std::int64_t value) { chunks_ = value != 0; });
  active.locked_by = kLocked;
  features.add(active);
  const auto chunk = [&](const std::string& name, const std::string& tip, std::uint32_t id, std::size_t offset,
                         bool standard, std::size_t stride = 0) {
    features.add({.kind = FeatureKind::chunk,
                  .name = name,
                  .category = category,
                  .tip = tip,
                  .standard = standard,
                  .chunk_id = id,
                  .chunk_offset = offset,
                  .stride = stride});
  };
  chunk("ChunkFrameID", "Number of the buffer since the acquisition began, from 0.", kFrameChunk, 0, true);
  chunk("ChunkTimestamp", "Time stamp of the first line by the board's clock, in ns.", kFrameChunk, 8, true);
  chunk("ChunkHeight", "Lines in the buffer.", kFrameChunk, 16, true);
  chunk("ChunkLineFrameNumber", "The board's number of the frame of which the line was made.", kLinesChunk, 0, false,
        kLineBytes);
  chunk("ChunkLineTimestamp", "Time stamp of the line by the board's clock, in ns.", kLinesChunk, 8, false, kLineBytes);
  chunk("ChunkEncoderValue", "Encoder count at the line.", kLinesChunk, 16, true, kLineBytes);
  const std::vector<NamedCount> names = counts_of_source();
  for (std::size_t i = 0; i < names.size(); ++i) {
    chunk("ChunkCount" + names[i].name, "At the end of the buffer: " + names[i].tip + ".", kCountersChunk, 8 * i,
          false);
  }
}

}  // namespace selfproj::gentl
