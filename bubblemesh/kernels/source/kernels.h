/* What all kernels share. Arrays are contiguous; shapes are given in the comments as in NumPy. */
#ifndef BUBBLEMESH_KERNELS_H
#define BUBBLEMESH_KERNELS_H

#include <stdint.h>

#if defined(_WIN32)
#define KERNEL __declspec(dllexport)
#else
#define KERNEL __attribute__((visibility("default")))
#endif

enum { DONE = 0, NO_MEMORY = -1 };

#endif
