#include "lab/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/cli/progress.h"
#include "host/files/output_folder.h"
#include "host/files/results_file.h"
#include "host/report/inspection_output.h"
#include "host/report/report.h"
#include "lab/cuboid_remedies.h"
#include "lab/cuboids.h"
#include "lab/disturbed_measurements.h"
#include "lab/gray_motion.h"
#include "lab/moving_things.h"
#include "lab/part_detection.h"
#include "lab/robustness.h"
#include "lab/section_experiment.h"
#include "lab/structured_light.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/renderer.h"

namespace selfproj::lab {
namespace {

// The number of characters that a text takes on a terminal: its code points.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

void print(const report::ReportTable& table) {
  std::vector<std::vector<std::string>> rows = {table.header};
  rows.insert(rows.end(), table.rows.begin(), table.rows.end());
  std::vector<std::size_t> widths(table.header.size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], width_of(row[i]));
    }
  }
  fmt::print("{}\n", table.title);
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - width_of(row[i]), ' ');
      line += i == 0 ? "  " + row[i] + space : "  " + space + row[i];
    }
    fmt::print("{}\n", line);
  }
  fmt::print("\n");
}

nlohmann::ordered_json json_of(const std::vector<report::ReportTable>& tables) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const report::ReportTable& table : tables) {
    all.push_back({{"title", table.title}, {"header", table.header}, {"rows", table.rows}, {"note", table.note}});
  }
  return all;
}

// The tables and what is not reached, as results/experiment_NAME.json; with --sources, --gray-scan, --pool-seed and
// --path-seed under a different name.
void keep_results(const ExperimentOptions& options, const std::vector<report::ReportTable>& tables,
                  const std::vector<std::string>& not_reached) {
  files::write_results(
      "experiment_" + options.name + (options.null_test ? "_null_test" : "") + (options.sources ? "_sources" : "") +
          (options.scan == sim::ScanMethod::gray_codes ? "_gray_scan" : "") +
          (options.pool_seed > 0 || options.path_seed > 0 ? "_drawn" : ""),
      "Experiment " + options.name + " in simulation", {{"tables", json_of(tables)}, {"not_reached", not_reached}});
}

// A line on the terminal that counts images or frames.
class ShownProgress {
 public:
  explicit ShownProgress(std::string what) : what_(std::move(what)) {}
  void operator()(std::size_t done, std::size_t all) {
    if (!progress_) {
      progress_.emplace(what_, all);
    }
    progress_->update(done);
  }

 private:
  std::string what_;
  std::optional<cli::Progress> progress_;
};

// Copies the options that B4, B7 and B8 have in common.
template <class Options>
Options structured_light_options(const ExperimentOptions& options, const rig::Rig& rig) {
  Options experiment;
  experiment.rig = rig;
  experiment.render = options.render();
  experiment.scan = options.scan;
  experiment.e = options.e.value_or(experiment.e);
  return experiment;
}

bool is_gray_motion(const ExperimentOptions& options) {
  return options.name == "B1" || options.name == "B2" || options.name == "B3";
}

// Both functions return what was not reached.
std::vector<std::string> run_structured_light(const ExperimentOptions& options,
                                              std::optional<files::OutputFolder>& folder) {
  const rig::Rig rig = rig::load_rig(options.rig.empty() ? "scanner" : options.rig);
  if (rig.kind != rig::RigKind::scanner) {
    throw UserError("--rig", fmt::format("{} is not a rig of kind scanner", options.rig));
  }
  if (!rig.is_pinholes()) {  // the conventional scanner beside it codes the central lines only
    throw UserError("--rig", fmt::format("{} is calibrated; {} takes a rig of pinholes, and `cosim` any", options.rig,
                                         options.name));
  }
  StructuredLightResult result;
  {
    ShownProgress progress("image");
    result = is_gray_motion(options) ? run_gray_motion(options.name,
                                                       {.rig = rig,
                                                        .render = options.render(),
                                                        .paths = options.paths,
                                                        .path_seed = options.path_seed,
                                                        .pools = options.pools,
                                                        .pool_seed = options.pool_seed},
                                                       std::ref(progress))
             : options.name == "B4"
                 ? run_cuboids(structured_light_options<CuboidsOptions>(options, rig), std::ref(progress))
                 : run_moving(options.name, structured_light_options<MovingOptions>(options, rig), std::ref(progress));
  }
  for (const report::ReportTable& table : result.tables) {
    print(table);
  }
  keep_results(options, result.tables, result.not_reached);
  if (folder) {
    if (!result.depth.values.empty()) {
      folder->append("depth.tiff", images::encode_float_tiff("depth.tiff", result.depth));
      folder->append("difference.tiff", images::encode_float_tiff("difference.tiff", result.difference));
      folder->append("truth.tiff", images::encode_float_tiff("truth.tiff", result.truth));
    }
    if (!result.series.empty()) {
      folder->append("series.csv", result.series);
    }
    folder->append("report.html", report::page_html(result.page));
    folder->commit();
  }
  return result.not_reached;
}

std::vector<std::string> run_light_section(const ExperimentOptions& options,
                                           std::optional<files::OutputFolder>& folder) {
  SectionOptions experiment;
  experiment.rig = rig::load_rig(options.rig.empty() ? "light-section" : options.rig);
  experiment.route = options.null_test ? Route::null_test : Route::learned;
  experiment.perturbed_rig_seed = options.perturbed_rig_seed;
  experiment.residual = options.residual;
  experiment.every = options.every.value_or(1);
  experiment.sources = options.sources;
  experiment.render = options.render();
  SectionResult result;
  {
    ShownProgress progress("image");
    result = run_section_experiment(options.name, experiment, std::ref(progress));
  }
  for (const report::ReportTable& table : result.tables) {
    print(table);
  }
  keep_results(options, result.tables, result.not_reached);
  if (folder) {
    report::ReportParts parts;
    parts.title = "Experiment " + result.name;
    parts.tables = result.tables;
    parts.settings = result.conditions;
    parts.camera = result.measurement.camera;
    report::write_inspection(result.measurement.by_mode[0], *folder, parts);
    folder->commit();
  }
  return result.not_reached;
}

// Throws CheckFailed unless nothing was missed.
void conclude(const std::string& name, const std::vector<std::string>& not_reached) {
  for (const std::string& line : not_reached) {
    fmt::print("not reached: {}\n", line);
  }
  if (!not_reached.empty()) {
    throw CheckFailed(fmt::format("{}: {} of the wanted figures are not reached", name, not_reached.size()));
  }
  fmt::print("{}: all figures reached\n", name);
}

// Prints the tables of a page, keeps figures and further JSON as results/NAME.json, and writes the page.
void keep_study(const std::string& name, const std::string& title, nlohmann::ordered_json figures,
                const std::string& data, const report::ReportPage& page, std::optional<files::OutputFolder>& folder) {
  for (const report::ReportTable& table : page.tables) {
    print(table);
  }
  figures.update(nlohmann::ordered_json::parse(data));
  files::write_results(name, title, figures);
  if (folder) {
    folder->append("report.html", report::page_html(page));
    folder->commit();
  }
}

std::vector<std::string> run_worlds(const ExperimentOptions& options, std::optional<files::OutputFolder>& folder) {
  RobustnessOptions experiment;
  experiment.world = options.parameters;
  experiment.every = options.every.value_or(experiment.every);
  experiment.cameras = options.cameras;
  experiment.strengths = static_cast<std::size_t>(options.strengths);
  experiment.coarser = options.coarser;
  RobustnessResult result;
  {
    ShownProgress progress("world");
    result = run_robustness(experiment, std::ref(progress));
  }
  keep_study("robustness", "A2 and B4 under each disturbance of the world",
             {{"tables", json_of(result.tables)}, {"not_reached", result.not_reached}}, result.data, result.page,
             folder);
  return result.not_reached;
}

std::vector<std::string> run_remedies(const ExperimentOptions& options, std::optional<files::OutputFolder>& folder) {
  const DisturbedCuboids cuboids(coarser_rig(rig::load_rig("scanner"), options.coarser));
  std::vector<TriedRemedy> tried;
  {
    ShownProgress progress("world");
    tried = try_cuboid_remedies(cuboids, options.parameters, options.seeds, std::ref(progress));
  }
  report::ReportPage page;
  page.title = "Experiment remedies";
  page.subtitle = "What helps B4 in a world that is not ideal";
  page.tables = {remedies_table(tried, options.seeds)};
  keep_study("remedies", "What helps B4 against the disturbances that break it", {{"tables", json_of(page.tables)}},
             remedies_data(tried), page, folder);
  return {};
}

void write_line(const PartLine& line, files::OutputFolder& folder) {
  folder.append("rig.yaml", line.rig_yaml);
  folder.append("tolerance.yaml", line.tolerance_yaml);
  folder.append("part/reference.csv", line.reference_csv);
  const auto write = [&folder](const char* name, const std::vector<images::Image>& frames) {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      folder.append(fmt::format("{}/image_{:05}.png", name, i + 1), images::encode_png(frames[i]));
    }
  };
  write("good", line.good);
  write("bad", line.bad);
}

std::vector<std::string> run_parts(const ExperimentOptions& options, std::optional<files::OutputFolder>& folder) {
  if (options.line_parts > 0 && !folder) {
    throw UserError("--line-parts", "needs --out, the folder for the line's files");
  }
  PartDetectionOptions experiment;
  experiment.render = options.render();
  experiment.parts = options.parts;
  experiment.good_parts = options.good_parts;
  experiment.seed = options.parts_seed;
  experiment.perturbed_rig_seed = options.perturbed_rig_seed;
  experiment.null_test = options.null_test;
  experiment.verdict = options.verdict;
  experiment.line_parts = options.line_parts;
  PartDetectionResult result;
  {
    ShownProgress progress("image or part");
    result = run_part_detection(experiment, std::ref(progress));
  }
  if (folder && options.line_parts > 0) {
    write_line(result.line, *folder);
  }
  keep_study(options.verdict ? "verdict_detection" : "parts_detection",
             options.verdict ? "Planted defects on a running line: found by moments, of those that the host finds"
                             : "Planted defects on a running line: found, missed, and false alarms",
             {{"tables", json_of(result.tables)}, {"not_reached", result.not_reached}}, result.data, result.page,
             folder);
  return result.not_reached;
}

}  // namespace

void run_experiment(const ExperimentOptions& options) {
  const bool structured_light = options.name.starts_with('B');
  std::optional<files::OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  conclude(options.name, options.name == "robustness" ? run_worlds(options, folder)
                         : options.name == "remedies" ? run_remedies(options, folder)
                         : options.name == "parts"    ? run_parts(options, folder)
                         : structured_light           ? run_structured_light(options, folder)
                                                      : run_light_section(options, folder));
}

}  // namespace selfproj::lab
