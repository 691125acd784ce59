#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/app/commands.h"
#include "host/app/section_run.h"
#include "host/cli/command_line.h"
#include "host/files/numbers.h"
#include "host/files/output_file.h"
#include "host/production/tolerance.h"
#include "host/production/verdict_file.h"
#include "host/production/verdict_table.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/verdict.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

struct TableOptions {
  SectionOptions section;
  std::string tolerance;
  std::string defect;
  std::string look_for = "either";
  double shift_mm = 0;
  production::VerdictOptions verdict;
  std::string out;
};

// WIDTHxLENGTH in mm.
void read_defect(const std::string& text, production::VerdictOptions& options) {
  const std::size_t cross = text.find('x');
  constexpr double kMost = 1000;
  const auto length = [&](const std::string& part) {
    const std::optional<double> value = files::number_of_text<double>(part);
    if (!value || !(*value > 0) || *value > kMost) {
      throw UserError("--defect " + text, fmt::format("is not WIDTHxLENGTH, two lengths of up to {} mm", kMost));
    }
    return *value;
  };
  options.defect_across_mm = length(text.substr(0, cross));
  options.defect_along_mm = length(cross == std::string::npos ? "" : text.substr(cross + 1));
}

// What decides, in columns, rows, frames and counts.
void print_table(const production::VerdictTable& table) {
  const model::VerdictSettings& settings = table.settings;
  fmt::print("{} of {} columns are judged, in {} section{}; a column is {:.4f} mm, a row {:.4f} mm\n", table.judged(),
             table.columns, table.sections.size(), table.sections.size() == 1 ? "" : "s", table.column_mm,
             table.row_mm);
  const auto [high, low] =
      table.row_mm > 0 ? std::pair(settings.below, settings.above) : std::pair(settings.above, settings.below);
  fmt::print("a defect: {} neighbouring column{} (w) out in {} (m) of {} frame{} (h), {}; too high is {} the band\n",
             settings.width, settings.width == 1 ? "" : "s", settings.hits, settings.history,
             settings.history == 1 ? "" : "s",
             high && low ? "too high or too low"
             : high      ? "too high"
             : low       ? "too low"
                         : "neither too high nor too low",
             table.row_mm > 0 ? "below" : "above");
  if (settings.most_unlit < model::kUnlitNotJudged) {
    fmt::print("a frame lacks light if more than {} judged columns have none\n", settings.most_unlit);
  }
  if (table.rule.by_encoder) {
    fmt::print("parts are judged from count {} on, every {} counts, for {} counts\n", table.rule.start,
               table.rule.pitch, table.rule.length);
  } else {
    fmt::print("a part begins after a frame with {} lit columns, and ends after {} frames with fewer\n", table.rule.lit,
               table.rule.dark_frames);
  }
  if (table.shift_mm) {
    fmt::print("the limits are for parts that lie {} mm across from the reference\n", *table.shift_mm);
  }
  fmt::print("shift of the settings: {} columns (up to {} are allowed), {:.2f} rows\n", settings.shift_columns,
             table.max_shift_columns, static_cast<double>(settings.shift_rows) / model::kRowParts);
}

void run_table(TableOptions options) {
  const rig::Rig rig = options.section.load_rig();
  if (!options.defect.empty()) {
    read_defect(options.defect, options.verdict);
  }
  options.verdict.look_for = options.look_for == "high"  ? production::TooFar::high
                             : options.look_for == "low" ? production::TooFar::low
                                                         : production::TooFar::either;
  if (rig.sources && rig.sources->speed != rig::ValueSource::assumed && !options.verdict.frame_mm) {
    throw UserError("--mm-per-frame",
                    "is needed: nothing says how far the belt moves from frame to frame, as the frame rate of a "
                    "calibrated rig is the drawing's");
  }
  const files::OutputFile out(options.out);
  const production::Tolerance tolerance = production::load_tolerance(options.tolerance);
  if (!(std::abs(options.shift_mm) + options.verdict.max_shift_mm <= tolerance.max_shift_mm)) {
    const bool both = options.shift_mm != 0 && options.verdict.max_shift_mm > 0;
    throw UserError(options.shift_mm == 0 ? "--max-shift" : "--shift",
                    fmt::format("{} {} mm; {} lets parts be shifted by {} mm (max_shift_mm)",
                                both ? "and --max-shift together are" : "is",
                                std::abs(options.shift_mm) + options.verdict.max_shift_mm, options.tolerance,
                                tolerance.max_shift_mm));
  }
  const production::VerdictTables tables(rig, options.section.load_reference(rig, ""), tolerance, options.verdict,
                                         options.tolerance);
  const production::VerdictTable table = tables.table(options.shift_mm);
  const production::VerdictFacts facts = tables.facts(table);
  out.write(fmt::format("# The tolerance {} on rig {}, for parts shifted across by {} mm. Limits are in 1/{} rows.\n",
                        options.tolerance, rig.name, options.shift_mm, model::kRowParts) +
            production::to_yaml(table));
  print_table(table);
  fmt::print("judged: {:.0f} % of the area of the regions\n", 100 * facts.judged);
  fmt::print("bands: ±{:.4f} mm in the best column, ±{:.4f} in the worst; rounded outwards by up to {:.4f} mm\n",
             facts.narrowest_mm, facts.widest_mm, facts.rounding_mm);
  fmt::print("found: {:.2f} mm across × {:.2f} mm along, off by {:.3f} mm; a frame is {:.3f} mm\n",
             facts.found_across_mm, facts.found_along_mm, facts.found_depth_mm, facts.frame_mm);
  fmt::print("noise of a column {:.4f} mm; it makes {:.2g} defects in a good part\n", facts.noise_mm,
             facts.false_alarms);
  if (std::sqrt(tolerance.min_defect_mm2) > (model::kMaxHistory + 1.5) * facts.frame_mm) {
    cli::note_doubt(
        options.tolerance,
        fmt::format("the circuit looks at the last {} frames, {:.2f} mm of the part: a defect need not be longer, "
                    "though the smallest one here has {:.2f} mm",
                    model::kMaxHistory, model::kMaxHistory * facts.frame_mm, std::sqrt(tolerance.min_defect_mm2)));
  }
  if (!table.rule.by_encoder && rig.parts->gap_mm > 1.5 * table.rule.dark_frames * facts.frame_mm) {
    cli::note_doubt(
        options.section.rig,
        fmt::format("parts are {} mm apart, and the circuit ends one after {} dark frames, {:.2f} mm: a hole of "
                    "that length ends it; --start and --pitch do not look at the light",
                    rig.parts->gap_mm, table.rule.dark_frames, table.rule.dark_frames * facts.frame_mm));
  }
  constexpr double kFewJudged = 0.5;
  if (facts.judged < kFewJudged) {
    cli::note_doubt(
        options.tolerance,
        fmt::format("of its regions {:.0f} % are judged: plays of {} mm across and {:.3g} mm along leave out as "
                    "much at each border{}",
                    100 * facts.judged, table.play_across_mm, table.play_along_mm,
                    options.verdict.section_mm ? ""
                                               : "; where columns meet the part one after another, as on a belt "
                                                 "that runs askew, a short --section helps"));
  }
  for (const std::string& what : production::never(table)) {
    cli::note_doubt(options.out, what);
  }
  if (!facts.finds_defect) {
    cli::note_doubt("--defect " + options.defect, "is smaller than what is found for certain");
  }
  if (facts.false_alarms > options.verdict.false_alarms) {
    cli::note_doubt(options.tolerance,
                    fmt::format("noise makes more than {} defects in a good part; a larger --defect or "
                                "--margin helps",
                                options.verdict.false_alarms));
  }
  fmt::print("→ {}\n", options.out);
}

void add_table_command(CLI::App& verdict) {
  CLI::App* command = cli::add_command(
      verdict,
      {.name = "table",
       .purpose = "Computes limits and settings from rig, reference and tolerance.",
       .details =
           "Each camera column gets the band of rows in which a good part's line may be: where the difference from "
           "the reference, as `inspect` computes it, is within the tolerance. Limits are rounded outwards, to 1/128 "
           "of a row. Columns beside walls and edges, without a reference, or where the line would be cut off, are "
           "not judged.\n\n"
           "w, h and m are those of the smallest defect of the tolerance, or of as much more, up to --defect, as "
           "--false-alarms takes.",
       .examples = R"(
# The table of a tolerance, and recorded parts judged by it.
selfproj-sim production --good 5 --parts 3 --out line
selfproj tolerance learn --rig line/rig.yaml --reference line/part \
  --device file:line/good.packets --out tolerance.yaml
selfproj verdict table --rig line/rig.yaml --reference line/part --tolerance tolerance.yaml \
  --defect 2x2 --out verdict.yaml
selfproj inspect --rig line/rig.yaml --reference line/part --device file:line/run.packets \
  --tolerance tolerance.yaml --verdict verdict.yaml --verdict-placed --parts today
)"});
  const auto options = std::make_shared<TableOptions>();
  add_section_options(*command, options->section);
  command->add_option("--tolerance", options->tolerance, "What a good part may be: of `selfproj tolerance learn`.")
      ->type_name("FILE")
      ->required();
  cli::begin_group(*command, "Defects");
  command
      ->add_option("--defect", options->defect, "Extent of the smallest defect that must be found, across and along.")
      ->type_name("MMxMM")
      ->default_str("the square of the tolerance's smallest defect");
  command
      ->add_option("--false-alarms", options->verdict.false_alarms,
                   "Defects that noise may make in a good part, by the rig's section `imaging`.")
      ->transform(cli::number_above_zero(1))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--look-for", options->look_for, "What is too high, too low, or either.")
      ->check(cli::one_of({"high", "low", "either"}))
      ->type_name("WHAT")
      ->capture_default_str();
  command->add_option("--margin", options->verdict.margin_mm, "Make all bands wider by this, on both sides.")
      ->transform(cli::real_number(0, 100))
      ->type_name("MM")
      ->capture_default_str();
  command
      ->add_option("--max-unlit", options->verdict.max_unlit,
                   "A frame lacks light if more judged columns than this have none.")
      ->transform(cli::whole_number(0, 4094))
      ->type_name("N")
      ->default_str("light is not judged");
  command
      ->add_option("--lit-rows", options->verdict.lit_rows,
                   "Rows that the line lights, as `selfproj lines` counts them (n in its table).")
      ->transform(cli::real_number(1, 1000))
      ->type_name("N")
      ->default_str("the middle of the rig's min_lit_px and half of its max_lit_px");
  cli::begin_group(*command, "Where parts lie");
  command->add_option("--shift", options->shift_mm, "Parts lie so far across from where the reference lay.")
      ->transform(cli::real_number(-1000, 1000))
      ->type_name("MM")
      ->capture_default_str();
  command
      ->add_option("--max-shift", options->verdict.max_shift_mm,
                   "Make limits that hold for shifts of the board's settings of up to this, both ways. Fewer columns "
                   "can be judged.")
      ->transform(cli::real_number(0, 1000))
      ->type_name("MM")
      ->capture_default_str();
  command
      ->add_option("--play-across", options->verdict.play_across_mm,
                   "A part may lie so far beside where it is said to lie.")
      ->transform(cli::real_number(0, 100))
      ->type_name("MM")
      ->capture_default_str();
  command->add_option("--play-along", options->verdict.play_along_mm, "A part may begin so much earlier or later.")
      ->transform(cli::real_number(0, 100))
      ->type_name("MM")
      ->default_str("half the width of the line, and a frame");
  command
      ->add_option("--section", options->verdict.section_mm,
                   "Limits change every so many mm along the part, instead of where regions begin and end: for belts "
                   "that run askew, whose columns meet the part one after another.")
      ->transform(cli::real_number(0.01, 1000))
      ->type_name("MM")
      ->default_str("where regions begin and end");
  command
      ->add_option("--mm-per-frame", options->verdict.frame_mm,
                   "How far the belt moves from frame to frame. A calibrated rig does not know it.")
      ->transform(cli::number_above_zero(1000))
      ->type_name("MM")
      ->default_str("by the rig's speed and frame rate");
  CLI::Option* const start =
      command
          ->add_option("--start", options->verdict.start,
                       "Encoder count at which a part's leading edge passes, for parts that come evenly.")
          ->transform(cli::whole_number(0, model::kCountMask))
          ->type_name("COUNT")
          ->default_str("parts begin by their light");
  CLI::Option* const pitch = command->add_option("--pitch", options->verdict.pitch, "Counts from part to part.")
                                 ->transform(cli::whole_number(2, model::kCountMask / 2))
                                 ->type_name("COUNTS")
                                 ->needs(start);
  start->needs(pitch);
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "File for the table.")->type_name("FILE")->required();
  command->callback([options] { run_table(*options); });
}

struct ShowOptions {
  std::string table;
  double across_mm = 0;
  double higher_mm = 0;
};

void run_show(const ShowOptions& options) {
  production::VerdictTable table = production::load_verdict_table(options.table);
  table.settings = production::shifted_settings(table, options.across_mm, options.higher_mm, options.table);
  production::check_rows(table, options.table);
  print_table(table);
  for (const std::string& what : production::never(table)) {
    cli::note_doubt(options.table, what);
  }
}

void add_show_command(CLI::App& verdict) {
  CLI::App* command = cli::add_command(
      verdict, {.name = "show",
                .purpose = "Reads a table, checks every value of it, and says in words what it decides.",
                .details = "With --across and --higher it also says the shift that a part has in the settings.",
                .examples = R"(
# The shift of a part that lies 1.2 mm further right and 0.1 mm higher.
selfproj-sim production --good 5 --parts 1 --out shifted-line
selfproj tolerance learn --rig shifted-line/rig.yaml --reference shifted-line/part \
  --device file:shifted-line/good.packets --out good-parts.yaml
selfproj verdict table --rig shifted-line/rig.yaml --reference shifted-line/part \
  --tolerance good-parts.yaml --max-shift 2 --out shifting.yaml
selfproj verdict show shifting.yaml --across 1.2 --higher 0.1
)"});
  const auto options = std::make_shared<ShowOptions>();
  command->add_option("table", options->table, "The file.")->type_name("FILE")->required();
  command->add_option("--across", options->across_mm, "How far across from the table's place a part lies.")
      ->transform(cli::real_number(-1000, 1000))
      ->type_name("MM")
      ->capture_default_str();
  command->add_option("--higher", options->higher_mm, "How much higher it lies.")
      ->transform(cli::real_number(-1000, 1000))
      ->type_name("MM")
      ->capture_default_str();
  command->callback([options] { run_show(*options); });
}

}  // namespace

void add_verdict_command(CLI::App& app) {
  CLI::App* command =
      cli::add_command(app, {.name = "verdict",
                             .purpose = "Makes and shows the tables by which a board judges parts without a PC.",
                             .details = "",
                             .examples = R"(
# A table for the parts of a simulated line.
selfproj-sim production --good 5 --parts 1 --out good-line
selfproj tolerance learn --rig good-line/rig.yaml --reference good-line/part \
  --device file:good-line/good.packets --out good.yaml
selfproj verdict table --rig good-line/rig.yaml --reference good-line/part --tolerance good.yaml \
  --out good-verdict.yaml
)"});
  command->require_subcommand(1);
  add_table_command(*command);
  add_show_command(*command);
}

}  // namespace selfproj::app
