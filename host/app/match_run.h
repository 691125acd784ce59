// What `selfproj match` and `selfproj scan --self-projected` share: how images under the patterns of a reference become
// depth images.
#ifndef SELFPROJ_HOST_APP_MATCH_RUN_H
#define SELFPROJ_HOST_APP_MATCH_RUN_H

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host/app/line_run.h"
#include "host/driver/device.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "host/report/depth_output.h"
#include "host/rig/rig.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/scan_stream.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "model/packet.h"

namespace selfproj {

struct MatchOptions {
  std::string rig;        // its name or file
  std::string reference;  // folder that `selfproj pattern stripes` wrote
  MatchSettings settings;
  int threshold = -1;  // the rig's if negative
};

// Adds the group of --e, --printed-direction and so on.
void add_search_options(CLI::App& command, MatchOptions& options);

// A rig of kind scanner. Throws UserError.
Rig scanner_rig(const std::string& name);

// Throws UserError about `name` if the image has not the size of the rig's camera.
void check_camera_size(const Rig& rig, const std::string& name, const Image& image);

// A board, or a camera, instead of recorded images.
struct MatchDevice {
  std::string uri;
  bool wait_for_board = false;
  std::size_t count = 0;  // end after so many depth images; 0: any number
  std::size_t save = 0;   // depth images of which depth and difference are written
  LineOptions line;
};

// A table with a line for each depth image: the number of its pair, its pixels with a depth, and the digests of depth
// and difference.
class DepthList {
 public:
  // Throws UserError. An empty name: no table.
  explicit DepthList(const std::string& file);

  void add(std::uint64_t pair, const SelfScanner& scanner);
  void commit();

 private:
  std::optional<OutputFile> file_;
  std::optional<OutputStream> stream_;
};

// What a run tells besides its files.
struct MatchResult {
  std::string text;        // for the terminal, one line
  MatchPictures pictures;  // of the newest depth image, which are among the files
};

// Depth images from images under the patterns of a reference, as `selfproj match` writes them.
class MatchRun {
 public:
  // Reads rig and reference. Throws UserError, also about settings that the reference does not allow.
  explicit MatchRun(const MatchOptions& options);

  [[nodiscard]] const Rig& rig() const { return rig_; }
  [[nodiscard]] int patterns() const { return 2 * reference_.stripes.bits; }
  [[nodiscard]] const SelfReference& reference() const { return reference_; }
  [[nodiscard]] const MatchOptions& options() const { return options_; }

  // Takes all images, patterns() or more and an even number, positive and negative of each bit in turn. Shows progress,
  // and writes into the folder without a commit. Throws UserError about an image of another size.
  MatchResult measure(ImageSequence& images, OutputFolder& folder, DepthList* list = nullptr) const;

  // The same from the codes or images of a device, until it ends, so many depth images have been made, or Ctrl-C.
  // `open` is called when everything else is ready, because a board may begin as soon as somebody listens. Throws
  // UserError if no depth image could be made, or about a size, and about the options of the line.
  MatchResult measure(const MatchDevice& of, const std::function<std::unique_ptr<Device>()>& open, OutputFolder& folder,
                      DepthList* list = nullptr) const;

  // θ_b of (4.15).
  [[nodiscard]] int threshold() const {
    return options_.threshold >= 0 ? options_.threshold : rig_.measure.code_threshold;
  }

 private:
  MatchOptions options_;
  Rig rig_;
  SelfReference reference_;
};

// Depth images from the packets of a device. The constructor takes seconds, for the table of matches.
class MatchStream {
 public:
  // `run` must outlive it.
  explicit MatchStream(const MatchRun& run);

  // Takes a packet; true if it has completed a depth image. Throws UserError, naming `uri`, about an image of another
  // size.
  bool take(const PacketView& packet, const std::string& uri);

  [[nodiscard]] const MatchTable& table() const { return table_; }
  [[nodiscard]] const SelfScanner& scanner() const { return scanner_; }
  [[nodiscard]] const ScanStream& stream() const { return stream_; }

 private:
  const MatchRun& run_;
  MatchTable table_;
  SelfScanner scanner_;
  ScanStream stream_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_MATCH_RUN_H
