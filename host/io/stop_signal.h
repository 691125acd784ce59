#ifndef SELFPROJ_HOST_IO_STOP_SIGNAL_H
#define SELFPROJ_HOST_IO_STOP_SIGNAL_H

#include <csignal>

namespace selfproj {

// While it lives, Ctrl-C (SIGINT), SIGTERM and SIGHUP do not end the program but are to be asked for, so that what runs
// without an end can be ended properly. A second one ends the program. One at a time.
class StopSignal {
 public:
  StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  ~StopSignal();

  [[nodiscard]] static bool came();

 private:
  struct sigaction interrupt_ {};
  struct sigaction terminate_ {};
  struct sigaction hang_up_ {};
};

// From here on, what ends the program by a signal that it can catch (SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU) takes
// what is temporary (temporary.h) away first. A signal that is ignored stays so.
void tidy_up_on_signals();

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_STOP_SIGNAL_H
