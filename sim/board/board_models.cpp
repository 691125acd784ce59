// This file is empty: the library consists of the Verilated models and their runtime.
#include "Vboard.h"
