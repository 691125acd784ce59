// A library needs a source. CMake adds the Verilated models that only tests use.
#include "Vboard_original.h"
