/* Where the order of bubbles is broken, and random displacements there: what annealing takes in any metric. */
#ifndef BUBBLEMESH_DISORDER_H
#define BUBBLEMESH_DISORDER_H

#include "kernels.h"

enum { DISORDERED = 1, BESIDE_BOUNDARY = 2 }; /* of a bubble, or next to it */

/* Random numbers of a seed: each bubble has its own in each cycle. */
typedef struct {
    uint64_t seed, cycle;
} Chance;

/* Marks near (n,) bubbles without six of the edges (m, 2), those next to them, and those next to the boundary, on which
   the first ones are; valence (n,) is for work. */
SHARED void mark_disorder(int64_t n, int64_t fixed, int64_t m, const int64_t *edges, int32_t *valence, char *near);

/* 64 random bits for a bubble, by SplitMix64: G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number
   generators", OOPSLA 2014. */
static inline uint64_t random_bits(const Chance *chance, int64_t bubble)
{
    uint64_t z = chance->seed + (chance->cycle << 32 | (uint64_t)bubble) * 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
}

/* A random number of unit deviation, at most sqrt(6): the sum of two that are uniform, from 16 bits each. */
static inline double deviation(uint64_t bits)
{
    const double unit = 3.737624729588589e-05; /* sqrt(6) / 65536 */
    return (double)((int64_t)(bits & 0xFFFF) + (int64_t)(bits >> 16 & 0xFFFF) - 0xFFFF) * unit;
}

#endif
