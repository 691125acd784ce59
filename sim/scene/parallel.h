#ifndef SELFPROJ_SIM_SCENE_PARALLEL_H
#define SELFPROJ_SIM_SCENE_PARALLEL_H

#include <functional>

namespace selfproj {

// Calls work(0) .. work(count - 1), each once, in about that order, from several threads (0: one a core). What one of
// them throws ends the work and is thrown here.
void parallel_for(int count, int threads, const std::function<void(int)>& work);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_PARALLEL_H
