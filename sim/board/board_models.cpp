// Nothing of its own: the library is the Verilated models and their runtime.
#include "Vboard.h"
