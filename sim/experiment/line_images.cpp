#include "sim/experiment/line_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/frame_options.h"
#include "host/io/output_folder.h"
#include "host/report/facts_json.h"
#include "host/report/report.h"
#include "sim/experiment/cosim_measurement.h"

namespace selfproj {

void LineImages::add(std::size_t frame, const Moments& moments) {
  append_moments_csv(csv_, frame, moments);
  for (std::size_t column = 0; column < moments.m0.size(); ++column) {
    centroids_.push_back(moments.m0[column] == 0
                             ? std::numeric_limits<float>::quiet_NaN()
                             : static_cast<float>(static_cast<double>(moments.m1[column]) / moments.m0[column]));
  }
}

void LineImages::write(OutputFolder& folder, const CosimFacts& facts, std::size_t frames,
                       const std::vector<CameraPicture>& pictures) const {
  FloatImage image;
  image.columns = columns_;
  image.rows = static_cast<int>(centroids_.size() / static_cast<std::size_t>(columns_));
  image.values = centroids_;
  folder.append("summary.json", summary(facts));
  folder.append("moments.csv", csv_);
  folder.append("centroid.tiff", encode_float_tiff("centroid.tiff", image));
  folder.append("report.html", report_html(report(facts, frames, pictures)));
}

// The facts known without geometry, with the names that an inspection uses.
std::string LineImages::summary(const CosimFacts& facts) const {
  nlohmann::ordered_json json;
  json["title"] = facts.title;
  json["frames"] = centroids_.size() / static_cast<std::size_t>(columns_);
  json["columns"] = columns_;
  json["mode"] = mode_name(measure_.mode);
  json["threshold"] = measure_.threshold;
  json["counters"] = facts_json(facts.counters);
  json["settings"] = facts_json(facts.settings);
  return json.dump(2) + "\n";
}

MomentsReport LineImages::report(const CosimFacts& facts, std::size_t frames,
                                 const std::vector<CameraPicture>& pictures) const {
  const auto unlit = std::count_if(centroids_.begin(), centroids_.end(), [](float c) { return std::isnan(c); });
  const std::size_t lit = centroids_.size() - static_cast<std::size_t>(unlit);
  const double share = static_cast<double>(lit) / static_cast<double>(std::max<std::size_t>(1, centroids_.size()));
  return {.title = facts.title,
          .subtitle = fmt::format("{} × {} px · no rig: moments only · mode {} · threshold {}", rows_, columns_,
                                  mode_name(measure_.mode), measure_.threshold),
          .highlights = {{"frames", "frames", static_cast<std::int64_t>(frames)},
                         {"lit", "columns with light", static_cast<std::int64_t>(lit)},
                         {"lit_share", "of all columns", fmt::format("{:.1f}", 100 * share), "%"}},
          .counters = facts.counters,
          .settings = facts.settings,
          .cameras = pictures};
}

}  // namespace selfproj
