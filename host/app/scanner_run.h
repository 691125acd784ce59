// What commands share that measure by structured light: their options, and how images under the patterns of a reference
// become depth images.
#ifndef SELFPROJ_HOST_APP_SCANNER_RUN_H
#define SELFPROJ_HOST_APP_SCANNER_RUN_H

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "host/camera/camera_device.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "host/report/depth_output.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/scan_stream.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "host/structured_light/sequence_check.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/depth_geometry.h"
#include "selfproj/structured_light/scanner.h"

namespace selfproj::app {

// Add --rig and --calibration; --threshold, whose default the help calls `by_default`; --strict, to the group that is
// open.
void add_geometry_options(CLI::App& command, structured_light::DepthGeometry& geometry);
void add_threshold_option(CLI::App& command, int& threshold, const std::string& by_default);
void add_strict_option(CLI::App& command, structured_light::ScannerSettings& scanner);

// Adds the group of --min-z, --max-z, --max-z-per-line and --max-residual.
void add_limit_options(CLI::App& command, structured_light::DepthGeometry& geometry);

// What the images of a device are, for add_receive_options.
inline constexpr const char* kImagesOfPatterns =
    " that the projector triggers. A board sends codes, or images, which are decoded here. Image k, by the board's or "
    "the "
    "camera's own number, shows pattern k modulo 2m.";

struct MatchOptions {
  std::string rig;                           // its name or file
  std::string reference;                     // folder that `selfproj pattern stripes` wrote
  structured_light::MatchSettings settings;  // its e is that of `e`
  std::optional<int> e;                      // nothing: half of the codes
  int threshold = -1;                        // the rig's if negative
};

// Adds the group of --e, --printed-direction and so on.
void add_search_options(CLI::App& command, MatchOptions& options);

// A rig of kind scanner. Throws UserError.
rig::Rig scanner_rig(const std::string& name);

// Throws UserError about `name` if the image has not the size of the rig's camera.
void check_camera_size(const rig::Rig& rig, const std::string& name, const images::Image& image);

// A table with a line for each depth image: the number of its pair, its pixels with a depth, and the digests of depth
// and difference.
class DepthList {
 public:
  // Throws UserError. An empty name: no table.
  explicit DepthList(const std::string& file);

  void add(std::uint64_t pair, const structured_light::SelfScanner& scanner);
  void commit();

 private:
  std::optional<files::OutputFile> file_;
  std::optional<files::OutputStream> stream_;
};

// Why a cloud that is compared with `other` seems to have other axes; empty: it does not. `prefix` is that of the
// options that exchange them, "--".
std::string doubt_about_axes(const structured_light::NearestPoint& nearest,
                             const std::vector<structured_light::Point3f>& cloud, const std::string& other,
                             const std::string& prefix);

// What a run gives besides its files.
struct MatchResult {
  std::string text;                // for the terminal, one line
  std::string page;                // report.html of `selfproj match`
  report::MatchPictures pictures;  // of the newest depth image, which are among the files
  std::string contradiction;       // of the images and the reference: the first; empty: none
  std::string doubt;               // likewise, of the newest depth image
};

// Depth images from images under the patterns of a reference, as `selfproj match` writes them.
class MatchRun {
 public:
  // Reads rig and reference. Throws UserError, also about settings that the reference does not allow.
  explicit MatchRun(const MatchOptions& options);

  [[nodiscard]] const rig::Rig& rig() const { return rig_; }
  [[nodiscard]] int patterns() const { return 2 * reference_.stripes.bits; }
  [[nodiscard]] const structured_light::SelfReference& reference() const { return reference_; }
  [[nodiscard]] const MatchOptions& options() const { return options_; }

  // Takes all images, patterns() or more and an even number, positive and negative of each bit in turn. Shows progress,
  // and writes into the folder without a commit. Throws UserError about an image of another size.
  MatchResult measure(images::ImageSequence& images, files::OutputFolder& folder, DepthList* list = nullptr) const;

  // How a camera's images are decoded, where a device is one.
  [[nodiscard]] camera::CameraDefaults decoder() const {
    return {.board = {.code_bits = patterns() / 2, .code_threshold = threshold()}};
  }

  // What a run says besides its shares.
  [[nodiscard]] report::MatchReport report() const;

  // θ_b of (4.15).
  [[nodiscard]] int threshold() const {
    return options_.threshold >= 0 ? options_.threshold : rig_.measure.code_threshold;
  }

 private:
  MatchOptions options_;
  rig::Rig rig_;
  structured_light::SelfReference reference_;
};

// Writes depth and difference of the scanner's newest image into the folder.
void append_maps(const structured_light::SelfScanner& scanner, std::size_t pair, files::OutputFolder& folder);

// Depth images from the packets of a device. The constructor takes seconds, for the table of matches.
class MatchStream {
 public:
  // `run` must outlive it. `uri` is the device's name for messages.
  MatchStream(const MatchRun& run, std::string uri);

  // Returns whether the packet has completed a depth image. Throws UserError about an image of another size.
  bool add(const model::PacketView& packet);

  [[nodiscard]] const structured_light::MatchTable& table() const { return table_; }
  [[nodiscard]] const structured_light::SelfScanner& scanner() const { return scanner_; }
  [[nodiscard]] const structured_light::ScanStream& stream() const { return stream_; }

  // Between the newest images of all patterns, which a board that decodes does not send (sequence_check.h), or between
  // the newest codes and the reference; empty: none.
  [[nodiscard]] std::string contradiction() const;

 private:
  const MatchRun& run_;
  std::string uri_;
  structured_light::MatchTable table_;
  structured_light::SelfScanner scanner_;
  structured_light::ScanStream stream_;
  structured_light::SequenceCheck check_;
};

}  // namespace selfproj::app

#endif  // SELFPROJ_HOST_APP_SCANNER_RUN_H
