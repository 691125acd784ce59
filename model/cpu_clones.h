// SELFPROJ_CLONES before a function compiles it once for each of several instruction sets; the program takes the best
// when it starts. What such a function calls must be inlined into it ([[gnu::always_inline]]) to gain from that.
//
// On x86-64 that is AVX-512, AVX2 and any processor. Elsewhere, and with other compilers than g++ 12 and later, it is
// nothing. Tests define the macro as nothing themselves, to reach each instruction set alone.
#ifndef SELFPROJ_MODEL_CPU_CLONES_H
#define SELFPROJ_MODEL_CPU_CLONES_H

#if defined(SELFPROJ_CLONES)
#elif defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12
#define SELFPROJ_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define SELFPROJ_CLONES
#endif

#endif  // SELFPROJ_MODEL_CPU_CLONES_H
