// Projectors: displays of this machine that show patterns pixel by pixel.
#ifndef SELFPROJ_HOST_CAPTURE_PROJECTOR_H
#define SELFPROJ_HOST_CAPTURE_PROJECTOR_H

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/images/image_files.h"

namespace selfproj::capture {

struct DisplayEntry {
  int number = 0;    // for --display
  std::string name;  // as the system has it
  int columns = 0;
  int rows = 0;
  double rate_hz = 0;  // 0 if the system does not say
};

// The displays there are; none if no screen can be reached.
std::vector<DisplayEntry> list_displays();

// What is sent to the display for each grey value of a pattern.
using GreyTable = std::array<std::uint8_t, 256>;

// Every grey value as it is.
GreyTable plain_greys();

// A window without border over the whole display, black when it opens and before it closes. Only one can be open.
class Projector {
 public:
  // Opens it on this display. Throws UserError about `--display N` if there is no such display or no screen, or the
  // window does not get all of its pixels.
  explicit Projector(int display, const GreyTable& greys = plain_greys());
  Projector(const Projector&) = delete;
  Projector& operator=(const Projector&) = delete;
  ~Projector();

  [[nodiscard]] int rows() const;
  [[nodiscard]] int columns() const;

  // Shows the pattern, a pixel a pixel, and returns when the system has taken it. What light leaves the projector when
  // is the display's own affair (settle.h measures it). `name` is what the message calls it: throws UserError
  // if it has not the size of the display.
  void show(const images::Image& pattern, const std::string& name);

  // One grey value everywhere.
  void show(std::uint8_t grey);

  // Takes note of keys, and draws again what was uncovered; to be called several times a second. Returns true once Esc
  // was pressed or the window was closed.
  bool stopped();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace selfproj::capture

#endif  // SELFPROJ_HOST_CAPTURE_PROJECTOR_H
