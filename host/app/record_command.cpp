#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

#include "host/app/commands.h"
#include "host/app/receive.h"
#include "host/app/section_run.h"
#include "host/cli/command_line.h"
#include "host/files/input_file.h"
#include "host/files/output_file.h"
#include "host/report/facts.h"
#include "selfproj/driver/counters.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/packet.h"

namespace selfproj::app {
namespace {

struct RecordOptions {
  ReceiveOptions receive;
  std::string out;
  std::string reference;  // folder or file; empty: none
};

// The text of a reference, or an empty one.
std::string reference_text(const std::string& folder_or_file) {
  if (folder_or_file.empty()) {
    return "";
  }
  std::error_code unused;
  const bool folder = std::filesystem::is_directory(folder_or_file, unused);
  const std::string file = folder ? folder_or_file + "/reference.csv" : folder_or_file;
  std::string text = files::read_input(file, files::kMostTableBytes);
  if (!text.starts_with("# selfproj reference")) {
    throw UserError(file, "is not the reference of a light section, which `selfproj pattern` writes");
  }
  return text;
}

void run_record(const RecordOptions& options) {
  const files::OutputFile file(options.out);
  const std::string reference = reference_text(options.reference);
  const std::string beside = light_section::reference_file_of(options.out);
  std::error_code unused;
  if (reference.empty() && std::filesystem::exists(beside, unused)) {
    throw UserError("--out " + options.out, beside +
                                                " lies beside it and would go with these packets; give "
                                                "--reference, or another name");
  }
  std::optional<files::OutputFile> reference_file;
  if (!reference.empty()) {
    reference_file.emplace(beside);
  }
  Receiver receiver(options.receive);
  receiver.open();
  files::OutputStream stream(file);
  std::uint64_t packets = 0;
  std::uint64_t bytes = 0;
  try {
    receiver.run({.packet =
                      [&](const model::PacketView& packet) {
                        stream.append({reinterpret_cast<const char*>(packet.bytes().data()), packet.size});
                        bytes += packet.size;
                        return ++packets;
                      },
                  .status = [&] { return fmt::format("{} bytes", bytes); }});
  } catch (const UserError& error) {  // a full disk, or a device that failed
    if (packets > 0) {
      stream.commit_first(bytes);
      throw UserError(error.what(), fmt::format("the {} packets before are kept in {}", packets, options.out));
    }
    throw;
  }
  if (packets == 0) {
    throw CheckFailed(options.receive.device + ": no packet came, and nothing is written");
  }
  stream.commit();
  if (reference_file) {
    reference_file->write(reference);
  }
  // Also those that are 0: scripts read this line.
  fmt::print("{} packets, {} bytes → {}; {}\n", packets, bytes, options.out,
             driver::counters_text(receiver.counters(), report::kLosses));
  receiver.check();
}

}  // namespace

void add_record_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app, {.name = "record",
            .purpose = "Records the packets of a board, of every kind, in a file.",
            .details = "The file gets the good packets as they came, and can be read as file:PATH. It appears whole at "
                       "the end of the run: after --count packets, after --seconds, at Ctrl-C, or when the device has "
                       "ended. What was lost is printed. Without a packet nothing is written, and the exit status "
                       "is 1.",
            .examples = R"(
# A board in a process of its own, and 500 of its packets.
selfproj-sim board --line 512x96 --ring line1 --count 2000 --wait-for-reader &
selfproj record --device ring:line1 --wait-for-board --count 500 --out part.packets
selfproj inspect --device file:part.packets --check
)"});
  const auto options = std::make_shared<RecordOptions>();
  add_receive_options(*command, options->receive, "packets",
                      ", of whose images this program makes the packets itself.");
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "File for the packets.")->type_name("FILE")->required();
  command
      ->add_option("--reference", options->reference,
                   "Folder that `selfproj pattern` wrote, whose pattern is projected. Its reference is kept as "
                   "FILE.reference.csv, and `selfproj inspect` takes no other with the packets.")
      ->type_name("DIR");
  command->callback([options] { run_record(*options); });
}

}  // namespace selfproj::app
