// The files and the text of `selfproj match`.
#ifndef SELFPROJ_HOST_REPORT_MATCH_OUTPUT_H
#define SELFPROJ_HOST_REPORT_MATCH_OUTPUT_H

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/report/facts.h"
#include "host/rig/rig.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/depth_shares.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_scanner.h"

namespace selfproj {

// How the depth images were measured.
struct MatchReport {
  std::string rig;        // its name or file
  std::string reference;  // its folder
  int bits = 0;           // m of the reference
  MatchSettings settings;
  int threshold = 0;                             // threshold of a pair's difference
  std::size_t images = 0;                        // number of recorded images
  std::vector<OfImage<DepthShares>> all_shares;  // shares of all depth images, at least one; of a device the newest
  std::string device = {};                       // its URI, if there is one
  std::size_t depth_images = 0;
  std::optional<DeviceCounts> counts = {};
  std::vector<Fact> line = {};  // what was counted of the parts of a running line
};

// The newest depth image and its difference from the reference in colours, as PNG.
struct MatchPictures {
  std::string depth;
  std::string difference;
};

// Writes pictures, cloud, tables and summary of the scanner's newest depth image, and returns the pictures. Does not
// commit the folder. Throws UserError as OutputFolder does.
MatchPictures write_match(const Rig& rig, const MatchTable& table, const SelfScanner& scanner,
                          const MatchReport& report, OutputFolder& folder);

// The same for the terminal, in one line. `folder` is where the files are.
std::string match_text(const MatchTable& table, const MatchReport& report, const std::string& folder);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_MATCH_OUTPUT_H
