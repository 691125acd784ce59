#include "host/app/match_run.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/app/line_run.h"
#include "host/app/packet_run.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/driver/clock.h"
#include "host/files/stop_signal.h"
#include "host/files/user_error.h"
#include "host/images/float_image.h"
#include "host/images/frame_options.h"
#include "host/report/depth_output.h"
#include "host/report/facts.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/scan_stream.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {
namespace {

// Writes depth and difference of the scanner's newest image into the folder.
void append_maps(const SelfScanner& scanner, std::size_t pair, OutputFolder& folder) {
  for (const auto& [name, map] : {std::pair{"depth", &scanner.depth()}, {"difference", &scanner.difference()}}) {
    const std::string file = fmt::format("{}_{:04}.tiff", name, pair);
    folder.append(file, encode_float_tiff(file, *map));
  }
}

// Passes all images to the scanner, and returns the shares of each depth image. If there are several, depth and
// difference of each are written into the folder.
std::vector<OfImage<DepthShares>> match_images(const Rig& rig, std::size_t patterns, ImageSequence& images,
                                               SelfScanner& scanner, OutputFolder& folder, DepthList* list) {
  std::array<Image, 2> pair;  // the scanner reads the positive when its negative comes
  std::vector<PointState> states;
  std::vector<OfImage<DepthShares>> all_shares;
  Progress progress("image", images.count());
  for (std::size_t i = 0; i < images.count(); ++i) {
    Image& image = pair.at(i % 2);
    image = images.read(i);
    check_camera_size(rig, images.files()[i], image);
    if (scanner.add_frame(image.view(), static_cast<int>(i % patterns))) {
      scanner.explain(states);
      all_shares.push_back({i / 2, count_states(states)});
      if (images.count() > patterns) {
        append_maps(scanner, i / 2, folder);
      }
      if (list != nullptr) {
        list->add(i / 2, scanner);
      }
    }
    progress.update(i + 1);
  }
  return all_shares;
}

// Depth images a second since the last question.
class ImageRate {
 public:
  double of(std::size_t images) {
    const std::int64_t now = now_ns();
    const double seconds = static_cast<double>(now - last_ns_) * 1e-9;
    const double rate = last_ns_ > 0 && seconds > 0 ? static_cast<double>(images - images_) / seconds : 0;
    last_ns_ = now;
    images_ = images;
    return rate;
  }

 private:
  std::int64_t last_ns_ = 0;
  std::size_t images_ = 0;
};

// What the page of a line shows of the stream.
std::vector<Fact> stream_facts(std::size_t images, double rate, const DeviceCounts& counts) {
  std::vector<Fact> facts = {{"depth_images", "depth images", static_cast<std::int64_t>(images)},
                             {"depth_images_per_second", "depth images a second", rate},
                             {"incomplete", "incomplete images", static_cast<std::int64_t>(counts.incomplete)}};
  const std::vector<Fact> driver = counter_facts(counts.counters);
  facts.insert(facts.end(), driver.begin(), driver.end());
  return facts;
}

}  // namespace

void add_search_options(CLI::App& command, MatchOptions& options) {
  begin_group(command, "Search");
  command
      .add_option(
          "--e", options.settings.e,
          "Codes that are searched below the reference, less than 2^m. The other 2^m - e are searched above it.")
      ->transform(whole_number(0, (1 << Stripes::kMaxBits) - 1))
      ->type_name("E")
      ->capture_default_str();
  command.add_flag("--printed-direction", options.settings.printed_direction,
                   "Search along Xp at constant Yp, as printed in (4.19), instead of along the epipolar line.");
  command.add_flag("--printed-window", options.settings.printed_window,
                   "Search a window of projector lines, as printed in (4.20), instead of one of codes.");
  command
      .add_option("--line-width", options.settings.line_width, "Projector lines of a code in the printed window, a'.")
      ->transform(number_above_zero())
      ->type_name("LINES")
      ->capture_default_str();
}

Rig scanner_rig(const std::string& name) {
  Rig rig = load_rig(name);
  if (rig.kind != RigKind::scanner) {
    throw UserError("--rig", fmt::format("{} is not a rig of kind scanner", name));
  }
  return rig;
}

void check_camera_size(const Rig& rig, const std::string& name, const Image& image) {
  if (image.rows != rig.camera.rows || image.columns != rig.camera.columns) {
    throw UserError(name, fmt::format("is {}; the rig's camera has {}", size_text(image.rows, image.columns),
                                      size_text(rig.camera.rows, rig.camera.columns)));
  }
}

MatchRun::MatchRun(const MatchOptions& options)
    : options_(options), rig_(scanner_rig(options.rig)), reference_(read_self_reference(rig_, options.reference)) {
  const int bits = reference_.stripes.bits;
  const int codes = 1 << bits;
  if (options.settings.e < 0 || options.settings.e >= codes) {
    throw UserError("--e",
                    fmt::format("is {}; a reference of {} bits allows 0 to {}", options.settings.e, bits, codes - 1));
  }
  if (!(options.settings.line_width > 0) || options.settings.line_width > rig_.projector.lines) {
    throw UserError("--line-width", fmt::format("is {}; it must be above 0, and at most the {} lines of the projector",
                                                options.settings.line_width, rig_.projector.lines));
  }
}

DepthList::DepthList(const std::string& file) {
  if (!file.empty()) {
    file_.emplace(file);
    stream_.emplace(*file_);
    stream_->append("pair,pixels,depth,difference\n");
  }
}

void DepthList::add(std::uint64_t pair, const SelfScanner& scanner) {
  if (stream_) {
    const std::vector<float>& depth = scanner.depth().values;
    const auto pixels = std::count_if(depth.begin(), depth.end(), [](float z) { return !std::isnan(z); });
    stream_->append(
        fmt::format("{},{},{:016x},{:016x}\n", pair, pixels, digest(scanner.depth()), digest(scanner.difference())));
  }
}

void DepthList::commit() {
  if (stream_) {
    stream_->commit();
  }
}

MatchResult MatchRun::measure(ImageSequence& images, OutputFolder& folder, DepthList* list) const {
  const MatchTable table(rig_, reference_, options_.settings);
  SelfScanner scanner(rig_, reference_, table, threshold());
  MatchReport report{options_.rig,
                     options_.reference,
                     reference_.stripes.bits,
                     options_.settings,
                     threshold(),
                     images.count(),
                     match_images(rig_, static_cast<std::size_t>(patterns()), images, scanner, folder, list)};
  report.depth_images = report.all_shares.size();
  MatchPictures pictures = write_match(rig_, table, scanner, report, folder);
  return {.text = match_text(table, report, folder.name()), .pictures = std::move(pictures)};
}

MatchStream::MatchStream(const MatchRun& run)
    : run_(run),
      table_(run.rig(), run.reference(), run.options().settings),
      scanner_(run.rig(), run.reference(), table_, run.threshold()) {}

bool MatchStream::take(const PacketView& packet, const std::string& uri) {
  const ScanStream::Got got = stream_.add(packet);
  if (got == ScanStream::Got::nothing) {
    return false;
  }
  const RigCamera& camera = run_.rig().camera;
  check_size("the rig's camera", camera.rows, camera.columns,
             {"an image of " + uri, stream_.header().rows, stream_.header().columns});
  if (got == ScanStream::Got::codes) {
    scanner_.add_codes(stream_.codes().data());
    return true;
  }
  if (!stream_.follows()) {
    scanner_.restart();
  }
  return scanner_.add_frame(stream_.image(), stream_.pattern(run_.patterns()));
}

MatchResult MatchRun::measure(const MatchDevice& of, const std::function<std::unique_ptr<Device>()>& open,
                              OutputFolder& folder, DepthList* list) const {
  MatchStream images(*this);
  const StopSignal stop;  // before the line can be seen
  std::optional<DepthLineRun> line;
  if (of.line.any()) {
    line.emplace(of.line, rig_, images.scanner().reference_depth(), patterns(),
                 fmt::format("{}: {}", rig_.name, of.uri));
  }
  MatchReport report{options_.rig, options_.reference, reference_.stripes.bits, options_.settings, threshold(), 0, {}};
  report.device = of.uri;
  std::uint64_t pair = 0;
  const std::unique_ptr<Device> device = open();
  ImageRate rate;
  const auto take = [&](const PacketView& packet) {
    if (line) {
      line->camera(packet);
    }
    if (!images.take(packet, of.uri)) {
      return report.depth_images;
    }
    pair = images.stream().pair();
    if (report.depth_images < of.save) {
      append_maps(images.scanner(), pair, folder);
    }
    if (list != nullptr) {
      list->add(pair, images.scanner());
    }
    if (line) {
      line->line().add(images.stream().header(), device->arrival_ns(), images.scanner().depth(),
                       images.scanner().difference());
    }
    return ++report.depth_images;
  };
  const auto counts = [&] { return DeviceCounts{device->counters(), images.stream().incomplete()}; };
  PacketRunOptions end;
  end.count = of.count;
  end.stop_held = true;
  run_packets(
      *device, end, take,
      [&] {
        return fmt::format("{} depth images, {}{}", report.depth_images, losses_of(counts()),
                           line ? line->text() : std::string());
      },
      [&] {
        if (line) {
          line->seen(device->counters(), stream_facts(report.depth_images, rate.of(report.depth_images), counts()));
        }
      });
  if (report.depth_images == 0) {
    throw UserError(of.uri, "delivered no complete code image, nor images enough for one");
  }
  if (line) {
    line->seen(device->counters(), stream_facts(report.depth_images, rate.of(report.depth_images), counts()));
    line->finish();
    report.line = line->facts();
  }
  std::vector<PointState> states;
  images.scanner().explain(states);
  report.all_shares.push_back({pair, count_states(states)});
  report.counts = counts();
  MatchPictures pictures = write_match(rig_, images.table(), images.scanner(), report, folder);
  std::string text = match_text(images.table(), report, folder.name());
  return {.text = text + (line ? line->end_text() : std::string()), .pictures = std::move(pictures)};
}

}  // namespace selfproj
