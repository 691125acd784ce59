// Moves the region of the sensor that a board's camera sends, beside the thread that measures.
#ifndef SELFPROJ_HOST_APP_REGION_MOVER_H
#define SELFPROJ_HOST_APP_REGION_MOVER_H

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "host/driver/control.h"

namespace selfproj::app {

// Writes the register `region`, which a board takes over at a frame start. With a command, a camera that does not obey
// that register is moved: the register is set to 0 (the place is not said), the command runs with the row, from 0, as
// its last word, and when it has ended with status 0 the register gets the row. A move that fails ends the run then;
// without a command it is noted, because each packet says where its frame begins.
class RegionMover {
 public:
  // Until it is destroyed, the control belongs to it.
  RegionMover(driver::Control& control, std::string command);
  RegionMover(const RegionMover&) = delete;
  RegionMover& operator=(const RegionMover&) = delete;
  ~RegionMover();

  // Asks for the region to begin at this row, from 0. Does not wait; the newest row counts. Throws as check().
  void move(int row);

  // Throws UserError if a move by the command has failed: where the camera's region lies is then not known.
  void check();

  // Waits for a move that is under way, and checks. Later ones are not carried out.
  void finish();

 private:
  void end();
  void run();
  void carry_out(int row);

  driver::Control& control_;
  std::string command_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<int> wanted_;
  bool ends_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace selfproj::app

#endif  // SELFPROJ_HOST_APP_REGION_MOVER_H
