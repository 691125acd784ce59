// What the board of `selfproj-sim board` plays: recorded packets, recorded images, or a line that moves.
#ifndef SELFPROJ_SIM_APP_BOARD_SOURCE_H
#define SELFPROJ_SIM_APP_BOARD_SOURCE_H

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "host/images/image_files.h"
#include "sim/board/packet_recording.h"

namespace selfproj::sim {

// Exactly one of replay, images and line is given.
struct BoardSource {
  std::string replay;
  std::vector<std::string> images;
  bool sensor = false;  // the images are of the whole sensor; the registers say what is sent
  images::PixelOptions pixels;
  std::string rig;  // that the images are of; empty: the encoder stands still
  int bits = 0;     // of the Gray code in the images; 0: the images are sent as they are
  std::optional<int> code_threshold;
  std::string line;  // COLUMNSxROWS
  std::string mode;  // empty: the rig's, or grey-over without one
  std::optional<int> threshold;
  cli::SelectOptions select;
  int line_frames = 100;
};

// Adds the group of --replay, --images, --line and what goes with them.
void add_source_options(CLI::App& command, BoardSource& options);

// The bits of the images' pixels: the rig's, or 8 without one. Throws UserError.
int pixel_bits_of(const BoardSource& options);

// How much the encoder counts from image to image: as the rig's belt moves. Throws UserError.
double counts_per_image(const BoardSource& options);

// The images of --images, of one size. Throws UserError.
std::vector<images::SensorImage> read_sensor_images(const BoardSource& options);

// The packets, of which `frames` are to be played. Throws UserError about options and files.
PacketRecording read_source(const BoardSource& options, std::uint64_t frames);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_APP_BOARD_SOURCE_H
