// The parts of every page: head, tables, camera images, foot. Each function appends its HTML to `html`.
#ifndef SELFPROJ_HOST_REPORT_PAGE_PARTS_H
#define SELFPROJ_HOST_REPORT_PAGE_PARTS_H

#include <string>
#include <string_view>
#include <vector>

#include "host/report/facts.h"
#include "host/report/frame_picture.h"

namespace selfproj {

// The beginning of the file up to the tiles of `highlights`, which a reader sees first.
void add_head(std::string& html, const std::string& title, const std::string& subtitle,
              const std::vector<Fact>& highlights);

void add_table(std::string& html, const ReportTable& table);

// The image with a path through the centroids of the columns. `axes` says what rows and columns mean.
void add_camera(std::string& html, const CameraPicture& camera, std::string_view axes);

// Counters and settings side by side, and the end of the file.
void add_foot(std::string& html, const std::vector<Fact>& counters, const std::vector<Fact>& settings);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_PAGE_PARTS_H
