// Selects the mutation of a model that was built with mutations: such a model has an input `mutant`.
//
// The environment variable SELFPROJ_MUTANT names model and number ("Vsp_fifo 17"). Without it, and for every other
// model, the number is 0, which means none. With SELFPROJ_MUTANT_USES the program writes a line "uses: MODEL" for every
// such model that it makes.
#ifndef SELFPROJ_SIM_BOARD_MUTANT_H
#define SELFPROJ_SIM_BOARD_MUTANT_H

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace selfproj {

template <class Model>
void choose_mutant(Model& model) {
  if constexpr (requires { model.mutant; }) {
    model.mutant = 0;
    const char* name = model.modelName();
    if (std::getenv("SELFPROJ_MUTANT_USES") != nullptr) {
      std::printf("uses: %s\n", name);
    }
    const char* chosen = std::getenv("SELFPROJ_MUTANT");
    const std::size_t length = std::strlen(name);
    if (chosen != nullptr && std::strncmp(chosen, name, length) == 0 && chosen[length] == ' ') {
      model.mutant = static_cast<std::uint16_t>(std::strtoul(chosen + length, nullptr, 10));
    }
  }
}

}  // namespace selfproj

#endif  // SELFPROJ_SIM_BOARD_MUTANT_H
