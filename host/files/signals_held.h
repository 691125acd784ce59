// The signals that end a program and can be caught.
#ifndef SELFPROJ_HOST_FILES_SIGNALS_HELD_H
#define SELFPROJ_HOST_FILES_SIGNALS_HELD_H

#include <array>
#include <csignal>

namespace selfproj::files {

inline constexpr std::array<int, 5> kEndingSignals{SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU};

inline sigset_t ending_signals() {
  sigset_t set{};
  sigemptyset(&set);
  for (const int number : kEndingSignals) {
    sigaddset(&set, number);
  }
  return set;
}

// Blocks these signals while it lives.
class SignalsHeld {
 public:
  SignalsHeld() {
    const sigset_t set = ending_signals();
    pthread_sigmask(SIG_BLOCK, &set, &before_);
  }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;
  ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_{};
};

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_SIGNALS_HELD_H
