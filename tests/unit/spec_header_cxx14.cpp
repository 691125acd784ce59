// This file is compiled as C++14 with all warnings, because HLS tools read the generated header as C++14.
#include "selfproj/model/generated/selfproj_spec.h"

static_assert(selfproj::spec::kHeaderBytes % selfproj::spec::kPacketBeatBytes == 0,
              "the packet header is not a whole number of beats");
static_assert(selfproj::spec::kTrailerBytes % selfproj::spec::kPacketBeatBytes == 0,
              "the packet trailer is not a whole number of beats");
