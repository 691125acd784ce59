#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "host/app/capture_run.h"
#include "host/app/commands.h"
#include "host/capture/grey_curve.h"
#include "host/capture/sequence_capture.h"
#include "host/cli/command_line.h"
#include "host/files/output_file.h"

namespace selfproj::app {
namespace {

struct GammaOptions {
  CaptureOptions capture;
  int levels = 18;
  std::string out;
};

void run_gamma(const GammaOptions& options) {
  const files::OutputFile out(options.out);
  const std::vector<int> greys = capture::grey_levels(options.levels);
  const Captured captured = capture_in_memory(options.capture, options.out, [&](const capture::CaptureSizes& sizes) {
    return capture::grey_patterns(greys, sizes.projector_rows, sizes.projector_columns);
  });
  const capture::GreyResponse response = capture::grey_response(greys, captured.images, captured.record.camera);
  out.write(capture::grey_curve_text(response.curve));
  fmt::print(
      "gamma {:.3f}, from {} pixels under {} greys; the light differs from this law by at most {:.1f} % of white, and "
      "from a straight line by at most {:.1f} % → {}\n",
      response.gamma, response.pixels, greys.size(), 100 * response.off_law, 100 * response.off_line, out.name());
}

void add_gamma_command(CLI::App& measure) {
  CLI::App* command = cli::add_command(
      measure,
      {.name = "gamma",
       .purpose = "Measures how much light a projector gives for each grey value.",
       .details =
           "The projector shows greys from black to white, and the camera takes an image of each, in step as `selfproj "
           "capture` does. Camera pixels that white does not light, or saturates, take no part. The camera's own curve "
           "must be straight: set its gamma to 1.\n\n"
           "The file has the columns grey,light. It is for --gamma of `selfproj project`, `selfproj capture` and "
           "`selfproj scan`. With --gamma here, the run checks such a table: the light should then be off a straight "
           "line by about a hundredth of white.",
       .examples = R"(
# Measure the curve, and check it (needs hardware)
selfproj measure gamma --camera camera:192.168.1.20 --display 1 --out gamma.csv
selfproj measure gamma --camera camera:192.168.1.20 --display 1 --gamma gamma.csv --out check.csv
)"});
  const auto options = std::make_shared<GammaOptions>();
  cli::begin_group(*command, "Input");
  add_camera_option(*command, options->capture);
  add_projector_options(*command, options->capture);
  cli::begin_group(*command, "Measurement");
  command->add_option("--levels", options->levels, "Greys to show, evenly spaced from 0 to 255.")
      ->transform(cli::whole_number(3, 256))
      ->type_name("N")
      ->capture_default_str();
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "File for the table.")->type_name("FILE")->required();
  command->callback([options] { run_gamma(*options); });
}

}  // namespace

void add_measure_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "measure", .purpose = "Measures properties of a projector by a camera.", .details = "", .examples = R"(
# The curve of a projector (needs hardware)
selfproj measure gamma --camera camera:192.168.1.20 --display 1 --out gamma.csv
)"});
  command->require_subcommand(1);
  add_gamma_command(*command);
}

}  // namespace selfproj::app
