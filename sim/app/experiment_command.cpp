#include "sim/app/experiment_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/inspect/report.h"
#include "host/io/output_folder.h"
#include "host/io/program_main.h"
#include "host/io/progress.h"
#include "host/io/rig.h"
#include "sim/experiment/experiment.h"
#include "sim/scene/renderer.h"

namespace selfproj {
namespace {

struct Options {
  std::string name;
  std::string rig = "light-section";
  std::string out;
  std::vector<std::string> off;
  bool no_residual = false;
  bool sources = false;
  int every = 1;
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

void run(const Options& options) {
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  ExperimentOptions experiment;
  experiment.rig = load_rig(options.rig);
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
    result.measurement.by_mode[0].write(*folder, parts);
    folder->commit();
  }
  for (const std::string& line : result.not_reached) {
    fmt::print("not reached: {}\n", line);
  }
  if (!result.not_reached.empty()) {
    throw CheckFailed(
        fmt::format("{}: {} of the figures wanted are not reached", result.name, result.not_reached.size()));
  }
  fmt::print("{}: all figures reached\n", result.name);
}

}  // namespace

void add_experiment_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "experiment", "Run an experiment of the thesis in simulation: published figures beside measured ones");
  command->add_option("NAME", options->name, "A1 (mountain) or A2 (stairs with carved marks)")
      ->required()
      ->check(CLI::IsMember({"A1", "A2"}));
  command->add_option("--rig", options->rig, "Built-in rig or YAML file")->capture_default_str();
  command->add_option("--out", options->out, "Folder for the files of the inspection and the report");
  command->add_option("--every", options->every, "Take every so many frames only")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag("--no-residual", options->no_residual, "Do not measure and remove the reference's residual");
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
  command->callback([options] { run(*options); });
}

}  // namespace selfproj
