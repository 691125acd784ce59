#include "sim/app/experiment_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/output_folder.h"
#include "host/io/program_main.h"
#include "host/io/progress.h"
#include "host/io/user_error.h"
#include "host/report/inspection_output.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "sim/experiment/cuboids.h"
#include "sim/experiment/experiment.h"
#include "sim/experiment/moving_things.h"
#include "sim/experiment/structured_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_scan.h"

namespace selfproj {
namespace {

struct ExperimentArguments {
  std::string name;
  std::string rig;  // empty: that of the experiment
  std::string out;
  std::vector<std::string> off;
  bool no_residual = false;
  bool sources = false;
  int every = 1;
  bool gray_scan = false;
  std::optional<int> e;  // that of the experiment
};

// Characters that a text takes on a terminal: its code points.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

void print(const ReportTable& table) {
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

// Ends as every experiment does: what is not reached is said and makes the exit status 1.
void conclude(const std::string& name, const std::vector<std::string>& not_reached) {
  for (const std::string& line : not_reached) {
    fmt::print("not reached: {}\n", line);
  }
  if (!not_reached.empty()) {
    throw CheckFailed(fmt::format("{}: {} of the figures wanted are not reached", name, not_reached.size()));
  }
  fmt::print("{}: all figures reached\n", name);
}

void run_structured_light(const ExperimentArguments& options) {
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  const Rig rig = load_rig(options.rig.empty() ? "scanner" : options.rig);
  if (rig.kind != RigKind::scanner) {
    throw UserError("--rig", fmt::format("{} is no rig of kind scanner", options.rig));
  }
  StructuredLightResult result;
  {
    std::optional<Progress> progress;
    const auto show = [&](std::size_t done, std::size_t all) {
      if (!progress) {
        progress.emplace("image", all);
      }
      progress->update(done);
    };
    const ScanMethod scan = options.gray_scan ? ScanMethod::gray_codes : ScanMethod::lines;
    if (options.name == "B4") {
      CuboidsOptions experiment;
      experiment.rig = rig;
      experiment.render = options_without(options.off);
      experiment.scan = scan;
      experiment.e = options.e.value_or(experiment.e);
      result = run_cuboids(experiment, show);
    } else {
      MovingOptions experiment;
      experiment.rig = rig;
      experiment.render = options_without(options.off);
      experiment.scan = scan;
      experiment.e = options.e.value_or(experiment.e);
      result = run_moving(options.name, experiment, show);
    }
  }
  for (const ReportTable& table : result.tables) {
    print(table);
  }
  if (folder) {
    folder->append("depth.tiff", encode_float_tiff("depth.tiff", result.depth));
    folder->append("difference.tiff", encode_float_tiff("difference.tiff", result.difference));
    folder->append("truth.tiff", encode_float_tiff("truth.tiff", result.truth));
    if (!result.series.empty()) {
      folder->append("series.csv", result.series);
    }
    folder->append("report.html", page_html(result.page));
    folder->commit();
  }
  conclude(options.name, result.not_reached);
}

void run_command(const ExperimentArguments& options) {
  if (options.name.starts_with('B')) {
    run_structured_light(options);
    return;
  }
  if (options.gray_scan || options.e) {
    throw UserError(options.gray_scan ? "--gray-scan" : "--e", "goes with B4, B7, B8");
  }
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  ExperimentOptions experiment;
  experiment.rig = load_rig(options.rig.empty() ? "light-section" : options.rig);
  experiment.residual = !options.no_residual;
  experiment.every = options.every;
  experiment.sources = options.sources;
  experiment.render = options_without(options.off);
  std::optional<Progress> progress;
  ExperimentResult result = run_experiment(options.name, experiment, [&](std::size_t done, std::size_t all) {
    if (!progress) {
      progress.emplace("frame", all);
    }
    progress->update(done);
  });
  progress.reset();
  for (const ReportTable& table : result.tables) {
    print(table);
  }
  if (folder) {
    ReportParts parts;
    parts.title = "Experiment " + result.name;
    parts.tables = result.tables;
    parts.settings = result.conditions;
    parts.camera = result.measurement.camera;
    write_inspection(result.measurement.by_mode[0], *folder, parts);
    folder->commit();
  }
  conclude(result.name, result.not_reached);
}

}  // namespace

void add_experiment_command(CLI::App& app) {
  auto options = std::make_shared<ExperimentArguments>();
  CLI::App* command = app.add_subcommand(
      "experiment", "Run an experiment of the thesis in simulation: published figures beside measured ones");
  command
      ->add_option(
          "NAME", options->name,
          "A1 (mountain), A2 (stairs with carved marks); structured light: B4 (cuboids), B7 (mouse), B8 (hands)")
      ->required()
      ->check(CLI::IsMember({"A1", "A2", "B4", "B7", "B8"}));
  command->add_option("--rig", options->rig, "Built-in rig or YAML file (default: that of the experiment)");
  command->add_option("--out", options->out, "Folder for the files of the inspection and the report");
  command->add_option("--every", options->every, "Take every so many frames only")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag("--no-residual", options->no_residual, "Do not measure and remove the reference's residual");
  command->add_flag("--gray-scan", options->gray_scan,
                    "B4, B7, B8: scan the reference by Gray codes, not line by line");
  command
      ->add_option("--e", options->e,
                   "B4, B7, B8: cells below the reference that are searched [that of the experiment: 8, 0, 0]")
      ->check(CLI::Range(0, (1 << Stripes{}.bits) - 1))
      ->type_name("CELLS");
  std::vector<std::string> sources;
  for (const Disturbance& source : kDisturbances) {
    sources.emplace_back(source.name);
  }
  command->add_option("--off", options->off, "Switch error sources off, comma between")
      ->delimiter(',')
      ->check(CLI::IsMember(sources));
  command->add_flag(
      "--sources", options->sources,
      "Also the table of error sources: the self-projected measurement with each of them off in its turn");
  command->callback([options] { run_command(*options); });
}

}  // namespace selfproj
