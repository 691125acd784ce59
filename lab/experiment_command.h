#ifndef SELFPROJ_LAB_EXPERIMENT_COMMAND_H
#define SELFPROJ_LAB_EXPERIMENT_COMMAND_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// selfproj-lab experiment: the experiments of the thesis, published figures beside measured ones.
void add_experiment_command(CLI::App& app);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_EXPERIMENT_COMMAND_H
