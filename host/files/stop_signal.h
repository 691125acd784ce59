#ifndef SELFPROJ_HOST_FILES_STOP_SIGNAL_H
#define SELFPROJ_HOST_FILES_STOP_SIGNAL_H

#include <array>
#include <csignal>

namespace selfproj::files {

// While it lives, Ctrl-C (SIGINT), SIGTERM and SIGHUP only set a flag instead of ending the program, so that an endless
// run can end properly. A second signal ends the program. Only one such object can exist.
class StopSignal {
 public:
  StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  ~StopSignal();

  [[nodiscard]] static bool came();

 private:
  static constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, kSignals.size()> before_{};
};

// From this call on, a signal that ends the program and can be caught (SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU) first
// removes temporary files (temporary.h). Ignored signals stay ignored.
void tidy_up_on_signals();

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_STOP_SIGNAL_H
