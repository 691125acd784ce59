#include "host/files/stop_signal.h"

#include <cerrno>
#include <csignal>
#include <cstddef>

#include "host/files/signals_held.h"
#include "host/files/temporary.h"

namespace selfproj::files {
namespace {

volatile std::sig_atomic_t asked_for = 0;    // NOLINT: a signal handler needs them
volatile std::sig_atomic_t signal_came = 0;  // NOLINT

void on_signal(int number) {
  if (asked_for != 0 && signal_came == 0 && number != SIGQUIT && number != SIGXCPU) {
    signal_came = 1;
    return;
  }
  const int error = errno;
  remove_temporaries();
  errno = error;
  std::signal(number, SIG_DFL);
  std::raise(number);  // the signal comes when this handler returns
}

struct sigaction tidy_action() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_mask = ending_signals();
  return action;
}

}  // namespace

StopSignal::StopSignal() {
  signal_came = 0;
  asked_for = 1;
  const struct sigaction action = tidy_action();
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &action, &before_[i]);
  }
}

StopSignal::~StopSignal() {
  asked_for = 0;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &before_[i], nullptr);
  }
}

bool StopSignal::came() { return signal_came != 0; }

void tidy_up_on_signals() {
  const struct sigaction action = tidy_action();
  for (const int number : kEndingSignals) {
    struct sigaction before {};
    if (sigaction(number, nullptr, &before) == 0 && before.sa_handler == SIG_DFL) {
      sigaction(number, &action, nullptr);
    }
  }
}

}  // namespace selfproj::files
