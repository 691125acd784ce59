#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/app/commands.h"
#include "host/calibration/chessboard_drawing.h"
#include "host/cli/command_line.h"
#include "host/files/output_file.h"
#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"

namespace selfproj::app {
namespace {

struct ChessboardOptions {
  std::string chessboard = "9x6";
  std::optional<double> square_mm;
  std::string paper = "A4";
  std::string out;
};

void make_chessboard(const ChessboardOptions& options) {
  constexpr int kMaxCorners = 200;
  constexpr int kMinCorners = 3;
  const images::FrameSize corners = images::size_of_text("--chessboard", options.chessboard, kMaxCorners);
  if (std::min(corners.columns, corners.rows) < kMinCorners) {
    throw UserError("--chessboard", fmt::format("is {}; calibration needs {} inner corners along both sides",
                                                options.chessboard, kMinCorners));
  }
  const auto paper = std::find_if(calibration::papers().begin(), calibration::papers().end(),
                                  [&](const calibration::Paper& candidate) { return candidate.name == options.paper; });
  calibration::Chessboard chessboard{.columns = std::max(corners.columns, corners.rows),
                                     .rows = std::min(corners.columns, corners.rows)};
  const std::optional<double> largest = calibration::largest_square(chessboard, *paper);
  if (!largest) {
    throw UserError("--chessboard", fmt::format("{} is too many corners for {}: the squares would be smaller than 1 mm",
                                                options.chessboard, paper->name));
  }
  if (options.square_mm.value_or(0) > *largest) {
    throw UserError("--square", fmt::format("{:g} mm is too large; on {} the squares of {} can have {:g} mm",
                                            *options.square_mm, paper->name, options.chessboard, *largest));
  }
  chessboard.square_mm = options.square_mm.value_or(*largest);
  const files::OutputFile file(options.out);
  file.write(calibration::chessboard_svg(chessboard, *paper));
  fmt::print(
      "{}: {} x {} inner corners, squares of {:g} mm, on {}; give selfproj calibrate --chessboard {}x{} "
      "--square {:g}\n",
      options.out, chessboard.columns, chessboard.rows, chessboard.square_mm, paper->name, chessboard.columns,
      chessboard.rows, chessboard.square_mm);
}

}  // namespace

CLI::App* add_chessboard_command(CLI::App& pattern) {
  CLI::App* command = cli::add_command(
      pattern,
      {.name = "chessboard",
       .purpose = "Draws a chessboard to print, for calibration.",
       .details =
           "The file is an SVG drawing in millimetres, which browsers and drawing programs print. Print it at 100 %, "
           "not fitted to the page, and measure the line of 100 mm below the board. If it has another length, give "
           "`selfproj calibrate` the side of the squares as they are. Glue the print onto something flat and stiff, "
           "such as glass or a composite panel.\n\n"
           "An odd and an even number of inner corners tell one end of the board from the other.",
       .examples = R"(
# A board for A4, and one with more and smaller squares for A3.
selfproj pattern chessboard --out board.svg
selfproj pattern chessboard --chessboard 14x11 --square 20 --paper A3 --out board_a3.svg
)"});
  const auto options = std::make_shared<ChessboardOptions>();
  std::vector<std::string> names;
  for (const calibration::Paper& paper : calibration::papers()) {
    names.push_back(paper.name);
  }
  command->add_option("--chessboard", options->chessboard, "Inner corners along the two sides of the chessboard.")
      ->type_name("NxM")
      ->capture_default_str();
  command->add_option("--square", options->square_mm, "Side of a square in mm.")
      ->transform(cli::number_above_zero())
      ->type_name("MM")
      ->default_str("the largest that fits");
  command->add_option("--paper", options->paper, "Paper to print on.")
      ->check(cli::one_of(names))
      ->type_name("SIZE")
      ->capture_default_str();
  command->add_option("--out", options->out, "Drawing to write.")->type_name("FILE.svg")->required();
  command->callback([options] { make_chessboard(*options); });
  return command;
}

}  // namespace selfproj::app
