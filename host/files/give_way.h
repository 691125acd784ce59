// Threads of a program that may be late, beside those that may not.
#ifndef SELFPROJ_HOST_FILES_GIVE_WAY_H
#define SELFPROJ_HOST_FILES_GIVE_WAY_H

#include <sched.h>

namespace selfproj::files {

// Makes the calling thread one that interrupts no other when it wakes, and that is not a real-time one if the program
// was started as such (chrt). Its share of the processor stays: the program waits for it at its end.
inline void give_way() {
  const sched_param none{};
  sched_setscheduler(0, SCHED_BATCH, &none);
}

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_GIVE_WAY_H
