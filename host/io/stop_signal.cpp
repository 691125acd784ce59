#include "host/io/stop_signal.h"

#include <csignal>

namespace selfproj {
namespace {

volatile std::sig_atomic_t signal_came = 0;  // NOLINT: a signal handler needs it

void note_signal(int /*number*/) { signal_came = 1; }

}  // namespace

StopSignal::StopSignal() {
  signal_came = 0;
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second one does what it always does
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, &interrupt_);
  sigaction(SIGTERM, &action, &terminate_);
  sigaction(SIGHUP, &action, &hang_up_);
}

StopSignal::~StopSignal() {
  sigaction(SIGINT, &interrupt_, nullptr);
  sigaction(SIGTERM, &terminate_, nullptr);
  sigaction(SIGHUP, &hang_up_, nullptr);
}

bool StopSignal::came() { return signal_came != 0; }

}  // namespace selfproj
