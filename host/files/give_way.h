// Threads of a program that may be late, beside those that may not.
#ifndef SELFPROJ_HOST_FILES_GIVE_WAY_H
#define SELFPROJ_HOST_FILES_GIVE_WAY_H

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

namespace selfproj::files {

// Makes the calling thread give way to the others of its program: it is 10 nicer, and not a real-time one if the
// program was started as such (chrt).
inline void give_way() {
  constexpr int kNicer = 10;
  constexpr int kNicest = 19;
  const sched_param none{};
  sched_setscheduler(0, SCHED_OTHER, &none);
  const auto thread = static_cast<id_t>(gettid());
  setpriority(PRIO_PROCESS, thread, std::min(kNicest, getpriority(PRIO_PROCESS, thread) + kNicer));
}

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_GIVE_WAY_H
