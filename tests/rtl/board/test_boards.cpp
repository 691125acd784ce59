// A library needs a source. This one has the Verilated models that only tests use, which CMake adds.
#include "Vboard_original.h"
