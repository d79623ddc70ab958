/* Forces between bubbles, and steps of their motion. */
#ifndef BUBBLEMESH_RELAXING_H
#define BUBBLEMESH_RELAXING_H

#include "kernels.h"

/* Force f(q) = 5/4 q^3 - 19/8 q^2 + 9/8 between bubbles at distance q in terms of that at rest, none from the cutoff on. */
static inline double pair_force(double ratio, double cutoff)
{
    double force = ((1.25 * ratio - 2.375) * ratio) * ratio + 1.125;
    return ratio < cutoff ? force : 0.0;
}

/* Pairs (m, 2) of n bubbles, at rest at the distances contact (m,), that act on each other up to cutoff times these. */
typedef struct {
    int64_t n, m;
    int32_t *ends;
    const double *contact;
    const double *strength; /* (n,): factor of the force on each bubble */
    double cutoff;
} Pairs;

/* Bubbles at x (n, 2) with velocities v (n, 2), but for the first ones, which are fixed. */
typedef struct {
    int64_t n, fixed;
    double *x, *v;
    const double *most; /* (n,): no step is longer */
} Motion;

/* Moves bubbles from rest, but for the first ones, so many steps with viscosities c (steps,); their mean speeds (steps,)
   come out. */
SHARED int64_t relax_pairs(const Pairs *pairs, const Motion *motion, double dt, int64_t steps, const double *c,
                           double *speeds);

#endif
