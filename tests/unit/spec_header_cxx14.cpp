// Compiled as C++14, with all warnings: the generated header must be fit for HLS tools.
#include "model/spec/generated/selfproj_spec.h"

static_assert(selfproj::spec::kHeaderBytes % selfproj::spec::kPacketBeatBytes == 0, "header is not whole beats");
static_assert(selfproj::spec::kTrailerBytes % selfproj::spec::kPacketBeatBytes == 0, "trailer is not whole beats");
