#ifndef SELFPROJ_SIM_SCENE_PARALLEL_H
#define SELFPROJ_SIM_SCENE_PARALLEL_H

#include <functional>

namespace selfproj::sim {

// Calls work(0) .. work(count - 1), each once and in about that order, from several threads (0: one for each core). An
// exception in one of them ends the work and is rethrown here.
void parallel_for(int count, int threads, const std::function<void(int)>& work);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_PARALLEL_H
