#include "host/report/line_images.h"

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

#include "host/files/json_text.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/prepared_images.h"
#include "host/report/facts.h"
#include "host/report/report.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/strip_moments.h"
#include "selfproj/model/column_runs.h"

namespace selfproj::report {

void LineImages::add(std::size_t frame, model::Runs runs) {
  runs.resize(measure_.of_board().select, columns_);
  append_moments_csv(csv_, frame, runs);
  const model::Moments& moments = runs.moments;
  for (std::size_t column = 0; column < moments.m0.size(); ++column) {
    centroids_.push_back(moments.m0[column] == 0
                             ? std::numeric_limits<float>::quiet_NaN()
                             : static_cast<float>(static_cast<double>(moments.m1[column]) / moments.m0[column]));
  }
  const std::vector<std::uint8_t> marked = ambiguous_of(runs);
  ambiguous_ += std::count(marked.begin(), marked.end(), std::uint8_t{1});
}

std::vector<std::uint8_t> LineImages::ambiguous_of(const model::Runs& runs) const {
  const std::int32_t limit = light_section::sixteenths_that_are_ambiguous(measure_);
  std::vector<std::uint8_t> marked(runs.second.size());
  for (std::size_t i = 0; i < marked.size(); ++i) {
    marked[i] = light_section::second_on_board(measure_.mode, runs.runs[i], runs.second[i]) >= limit ? 1 : 0;
  }
  return marked;
}

CameraPicture LineImages::picture(std::size_t frame, images::Image image, model::Runs runs) const {
  runs.resize(measure_.of_board().select, columns_);
  const std::vector<std::uint8_t> marked = ambiguous_of(runs);
  return {.image = images::with_columns(image, columns_), .moments = runs.moments, .ambiguous = marked, .frame = frame};
}

std::int64_t LineImages::lit() const {
  return std::count_if(centroids_.begin(), centroids_.end(), [](float c) { return !std::isnan(c); });
}

void LineImages::write(files::OutputFolder& folder, const LineFacts& facts, std::size_t frames,
                       const std::vector<CameraPicture>& pictures) const {
  images::FloatImage image;
  image.columns = columns_;
  image.rows = static_cast<int>(centroids_.size() / static_cast<std::size_t>(columns_));
  image.values = centroids_;
  folder.append("summary.json", summary(facts));
  folder.append("moments.csv", csv_);
  folder.append("centroid.tiff", images::encode_float_tiff("centroid.tiff", image));
  folder.append("report.html", report_html(report(facts, frames, pictures)));
}

// The facts known without geometry, with the names that an inspection uses.
std::string LineImages::summary(const LineFacts& facts) const {
  nlohmann::ordered_json json;
  json["title"] = facts.title;
  json["frames"] = centroids_.size() / static_cast<std::size_t>(columns_);
  json["columns"] = columns_;
  json["mode"] = images::mode_name(measure_.mode);
  json["threshold"] = measure_.threshold;
  json["lit"] = lit();
  const model::Measure measure = measure_.of_board();
  if (measure.select == model::Select::strongest) {
    json["select"] = images::select_name(measure.select);
    json["gap"] = measure.gap;
    json["ambiguous"] = ambiguous_;
  }
  if (measure.window != model::RowWindow{}) {
    json["rows"] = {measure.window.first, measure.window.last};
  }
  if (!facts.doubts.empty()) {
    json["doubts"] = facts.doubts;
  }
  json["counters"] = facts_json(facts.counters);
  json["settings"] = facts_json(facts.settings);
  return files::json_text(json, 2) + "\n";
}

MomentsReport LineImages::report(const LineFacts& facts, std::size_t frames,
                                 const std::vector<CameraPicture>& pictures) const {
  const double all = static_cast<double>(std::max<std::size_t>(1, centroids_.size()));
  MomentsReport report{.title = facts.title,
                       .subtitle = fmt::format("{} × {} px · no rig: moments only · mode {} · threshold {}", rows_,
                                               columns_, images::mode_name(measure_.mode), measure_.threshold),
                       .highlights = {{"frames", "frames", static_cast<std::int64_t>(frames)},
                                      {"lit", "columns with light", lit()},
                                      {"lit_share", "of all columns",
                                       fmt::format("{:.1f}", 100 * static_cast<double>(lit()) / all), "%"}},
                       .doubts = facts.doubts,
                       .counters = facts.counters,
                       .settings = facts.settings,
                       .cameras = pictures};
  if (const std::string select = images::select_text(measure_.of_board()); !select.empty()) {
    report.subtitle += " · " + select;
  }
  if (measure_.runs) {
    report.highlights.push_back({"ambiguous", "ambiguous columns, magenta", ambiguous_});
  }
  return report;
}

}  // namespace selfproj::report
