#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/app/commands.h"
#include "host/app/receive.h"
#include "host/cli/command_line.h"
#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/report/facts.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/image_assembler.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/packet.h"

namespace selfproj::app {
namespace {

struct ImagesOptions {
  ReceiveOptions receive;
  std::string out;
  int stream = 0;
};

// The files of complete images. Names have the number of the frame, and the number of the restart after one.
class ImageFiles {
 public:
  ImageFiles(const std::string& folder, int stream)
      : folder_(folder), images_(spec::kKindImage, stream), codes_(spec::kKindCodes, stream) {}

  // Returns how many images were written so far.
  std::uint64_t add(const model::PacketView& packet, std::uint64_t restarts) {
    if (images_.add(packet)) {
      const model::PacketHeader& header = images_.header();
      folder_.append(name("image", header, restarts),
                     images::encode_png({header.rows, header.columns, images_.pixels()}));
    } else if (codes_.add(packet)) {
      add_codes(codes_.header(), restarts);
    }
    return written();
  }

  void commit() { folder_.commit(); }

  [[nodiscard]] std::uint64_t written() const { return images_.complete() + codes_.complete(); }
  [[nodiscard]] std::uint64_t raw() const { return images_.complete(); }
  [[nodiscard]] std::uint64_t codes() const { return codes_.complete(); }
  [[nodiscard]] std::uint64_t incomplete() const { return images_.incomplete() + codes_.incomplete(); }

 private:
  static std::string name(const char* what, const model::PacketHeader& header, std::uint64_t restarts) {
    const std::string after = restarts == 0 ? "" : fmt::format("_{}", restarts);
    return fmt::format("{}{}_{:08}.png", what, after, header.sequence);
  }

  void add_codes(const model::PacketHeader& header, std::uint64_t restarts) {
    const std::vector<std::uint16_t>& words = codes_.codes();
    std::vector<std::uint16_t> codes(words.size());
    images::Image measurable{header.rows, header.columns, std::vector<std::uint8_t>(words.size())};
    for (std::size_t i = 0; i < words.size(); ++i) {
      const bool good = model::is_measurable(words[i]);
      codes[i] = static_cast<std::uint16_t>(good ? model::code_of(words[i]) : 0);
      measurable.pixels[i] = good ? UINT8_MAX : 0;
    }
    folder_.append(name("code", header, restarts), images::encode_png16(header.rows, header.columns, codes));
    folder_.append(name("measurable", header, restarts), images::encode_png(measurable));
  }

  files::OutputFolder folder_;
  driver::ImageAssembler images_;
  driver::ImageAssembler codes_;
};

void run_images(const ImagesOptions& options) {
  ImageFiles files(options.out, options.stream);
  Receiver receiver(options.receive);
  receiver.open();
  const auto text = [&] {
    return fmt::format("{} raw images, {} code images, {} incomplete", files.raw(), files.codes(), files.incomplete());
  };
  receiver.run(
      {.packet = [&](const model::PacketView& packet) { return files.add(packet, receiver.counters().restarts); },
       .status = text});
  if (files.written() == 0) {
    throw CheckFailed(fmt::format("{}: no complete image came, and nothing is written; {} incomplete",
                                  options.receive.device, files.incomplete()));
  }
  files.commit();
  fmt::print("{} → {}; {}\n", text(), options.out,
             report::losses_text(receiver.counters(), {&driver::Counters::lost_board, &driver::Counters::lost_ring,
                                                       &driver::Counters::lost_network, &driver::Counters::bad}));
  receiver.check(files.incomplete());
}

}  // namespace

void add_images_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "images",
       .purpose = "Writes the raw images and code images in a board's packets as PNG files.",
       .details =
           "The folder gets image_K.png (8 bits) for each raw image, and for each code image code_K.png (16 bits, 0 "
           "where not measurable) and measurable_K.png (0 or 255); K is the number of the frame, eight digits. Images "
           "of which a line is missing are counted and left out. Without an image nothing is written, and the exit "
           "status is 1.",
       .examples = R"(
# The code images of a simulated scanner.
selfproj-sim cosim --engine model --rig scanner --scene fist --bits 2 --count 6 \
  --packets codes.packets
selfproj images --device file:codes.packets --out codes
)"});
  const auto options = std::make_shared<ImagesOptions>();
  add_receive_options(*command, options->receive, "images", ", of whose images this program makes the packets itself.");
  command->add_option("--stream", options->stream, "Take the images of this stream number.")
      ->transform(cli::whole_number(0, UINT8_MAX))
      ->type_name("N")
      ->group("Device")
      ->capture_default_str();
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the images.")->type_name("DIR")->required();
  command->callback([options] { run_images(*options); });
}

}  // namespace selfproj::app
