// A function marked SELFPROJ_CLONES is compiled once for each of several instruction sets, and the program takes the
// best one when it starts. Functions that it calls gain from this only if they are inlined ([[gnu::always_inline]]).
//
// The sets are AVX-512, AVX2 and plain x86-64. On other machines, and with compilers other than g++ 12 and later, the
// macro is empty. Tests define it as empty themselves to reach each instruction set alone.
#ifndef SELFPROJ_MODEL_CPU_CLONES_H
#define SELFPROJ_MODEL_CPU_CLONES_H

#if defined(SELFPROJ_CLONES)
#elif defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12
#define SELFPROJ_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define SELFPROJ_CLONES
#endif

#endif  // SELFPROJ_MODEL_CPU_CLONES_H
