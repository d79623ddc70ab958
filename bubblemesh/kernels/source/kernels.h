/* What all kernels share. Arrays are contiguous; shapes are given in the comments as in NumPy. */
#ifndef BUBBLEMESH_KERNELS_H
#define BUBBLEMESH_KERNELS_H

#include <stdint.h>

#if defined(_WIN32)
#define KERNEL __declspec(dllexport)
#else
#define KERNEL __attribute__((visibility("default")))
#endif

/* A function that other files of the library use, and nobody else. */
#if defined(_WIN32)
#define SHARED
#else
#define SHARED __attribute__((visibility("hidden")))
#endif

/* Marks a function without branches that is compiled for processors with wider registers, too, where the loader can
   choose: each result is the same to the last bit. */
#if defined(__gnu_linux__) && defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define SIDE_BY_SIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define SIDE_BY_SIDE
#endif

enum { DONE = 0, NO_MEMORY = -1 };

#endif
