/* Forces between bubbles, and steps of their motion; see relaxing.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

enum { BLOCK = 64 }; /* pairs whose forces are found side by side */

/* Pairs (m, 2) of n bubbles, at rest at the distances contact (m,), that act on each other up to cutoff times these. */
typedef struct {
    int64_t n, m;
    const int64_t *ends;
    const double *contact;
    double cutoff;
} Pairs;

/* Forces (BLOCK, 2) on the first members of pairs that are dx and dy apart, as in forces.py. */
SIDE_BY_SIDE static void block_forces(const double *dx, const double *dy, const double *contact, double cutoff,
                                      double *force)
{
    int k;
    for (k = 0; k < BLOCK; k++) {
        double distance = sqrt(dx[k] * dx[k] + dy[k] * dy[k]), least = 1e-12 * contact[k];
        double ratio = distance / contact[k], pushed = ((1.25 * ratio - 2.375) * ratio) * ratio + 1.125, size;
        pushed = ratio < cutoff ? pushed : 0.0;
        size = pushed / (distance > least ? distance : least);
        force[2 * k] = size * dx[k];
        force[2 * k + 1] = size * dy[k];
    }
}

/* Forces (m, 2) on the first members of pairs, for bubbles at x (n, 2). */
static void first_forces(const Pairs *pairs, const double *x, double *force)
{
    double dx[BLOCK] = {0}, dy[BLOCK] = {0}, contact[BLOCK], found[2 * BLOCK];
    int64_t begin, k;
    for (k = 0; k < BLOCK; k++)
        contact[k] = 1.0;
    for (begin = 0; begin < pairs->m; begin += BLOCK) {
        const int64_t *ends = pairs->ends + 2 * begin;
        int64_t count = pairs->m - begin < BLOCK ? pairs->m - begin : BLOCK;
        for (k = 0; k < count; k++) {
            const double *one = x + 2 * ends[2 * k], *other = x + 2 * ends[2 * k + 1];
            dx[k] = one[0] - other[0];
            dy[k] = one[1] - other[1];
            contact[k] = pairs->contact[begin + k];
        }
        block_forces(dx, dy, contact, pairs->cutoff, found);
        memcpy(force + 2 * begin, found, (size_t)(2 * count) * sizeof *force);
    }
}

/* The pairs at each bubble: from begin to middle those of which it is the first member, then up to the next one's
   begin those of which it is the last, both in their order. */
typedef struct {
    int32_t *begin, *middle, *pairs; /* (n + 1,), (n,), (2 m,) */
} Groups;

static void group(const Pairs *pairs, Groups *groups)
{
    int64_t k, n = pairs->n, m = pairs->m;
    int32_t sum = 0, *begin = groups->begin, *middle = groups->middle;
    for (k = 0; k < n; k++)
        begin[k] = middle[k] = 0;
    for (k = 0; k < m; k++) {
        begin[pairs->ends[2 * k]]++;
        middle[pairs->ends[2 * k + 1]]++;
    }
    for (k = 0; k < n; k++) {
        int32_t first = begin[k], last = middle[k];
        begin[k] = sum;
        middle[k] = sum + first + last;
        sum += first + last;
    }
    begin[n] = sum;
    for (k = m - 1; k >= 0; k--) /* middle goes down from the end of the last members to their begin ... */
        groups->pairs[--middle[pairs->ends[2 * k + 1]]] = (int32_t)k;
    for (k = m - 1; k >= 0; k--) /* ... and on to that of the first ones, */
        groups->pairs[--middle[pairs->ends[2 * k]]] = (int32_t)k;
    for (k = 0; k < m; k++) /* from which it comes back. */
        middle[pairs->ends[2 * k]]++;
}

/* Accelerations (n, 2) of the bubbles but the fixed ones: what pushes first members, against what pulls the last. */
static void accelerate(int64_t n, int64_t fixed, const Groups *groups, const double *forces, const double *strength,
                       double *acceleration)
{
    const int32_t *begin = groups->begin, *middle = groups->middle, *pairs = groups->pairs;
    int64_t k, p;
    for (k = fixed; k < n; k++) {
        double ax = 0.0, ay = 0.0, bx = 0.0, by = 0.0;
        for (p = begin[k]; p < middle[k]; p++) {
            ax += forces[2 * (int64_t)pairs[p]];
            ay += forces[2 * (int64_t)pairs[p] + 1];
        }
        for (p = middle[k]; p < begin[k + 1]; p++) {
            bx += forces[2 * (int64_t)pairs[p]];
            by += forces[2 * (int64_t)pairs[p] + 1];
        }
        acceleration[2 * k] = strength[k] * (ax - bx);
        acceleration[2 * k + 1] = strength[k] * (ay - by);
    }
}

/* Forces (n, 2) between the pairs (m, 2) of bubbles at x (n, 2). */
KERNEL int64_t pair_forces(int64_t n, int64_t m, const int64_t *ends, const double *contact, const double *strength,
                           double cutoff, const double *x, double *force)
{
    const Pairs pairs = {n, m, ends, contact, cutoff};
    double *pushes = malloc((size_t)(2 * m + 1) * sizeof *pushes);
    double *against = calloc((size_t)(2 * n + 1), sizeof *against);
    int64_t k, status = NO_MEMORY;
    if (pushes && against) {
        first_forces(&pairs, x, pushes);
        for (k = 0; k < 2 * n; k++)
            force[k] = 0.0;
        for (k = 0; k < m; k++) {
            int64_t i = 2 * ends[2 * k], j = 2 * ends[2 * k + 1];
            force[i] += pushes[2 * k];
            force[i + 1] += pushes[2 * k + 1];
            against[j] += pushes[2 * k];
            against[j + 1] += pushes[2 * k + 1];
        }
        for (k = 0; k < 2 * n; k++)
            force[k] = strength[k / 2] * (force[k] - against[k]);
        status = DONE;
    }
    free(pushes);
    free(against);
    return status;
}

/* Bubbles at x (n, 2) with velocities v (n, 2), but for the first ones, which are fixed. */
typedef struct {
    int64_t n, fixed;
    double *x, *v;
    const double *most; /* (n,): no step is longer */
} Motion;

/* One step with an acceleration (n, 2), of which nothing is left; the sum of the speeds. */
static double move(const Motion *motion, double dt, double viscosity, double *acceleration)
{
    double damped = 1.0 + viscosity * dt, sum = 0.0, *x = motion->x, *v = motion->v, *next = acceleration, *speed = next;
    const double *most = motion->most;
    int64_t k, n = motion->n, fixed = motion->fixed;
    int far = 0;
    for (k = 2 * fixed; k < 2 * n; k++) {
        v[k] = (v[k] + dt * acceleration[k]) / damped;
        next[k] = x[k] + dt * v[k];
    }
    for (k = fixed; k < n; k++) {
        double dx = next[2 * k] - x[2 * k], dy = next[2 * k + 1] - x[2 * k + 1];
        far |= !(sqrt(dx * dx + dy * dy) <= most[k]);
    }
    if (!far)
        for (k = 2 * fixed; k < 2 * n; k++)
            x[k] = next[k];
    else
        for (k = fixed; k < n; k++) {
            double dx = next[2 * k] - x[2 * k], dy = next[2 * k + 1] - x[2 * k + 1], length = sqrt(dx * dx + dy * dy);
            double share = most[k] / (length > most[k] ? length : most[k]);
            x[2 * k] = x[2 * k] + share * dx;
            x[2 * k + 1] = x[2 * k + 1] + share * dy;
            v[2 * k] = share * v[2 * k];
            v[2 * k + 1] = share * v[2 * k + 1];
        }
    for (k = fixed; k < n; k++)
        speed[k] = sqrt(v[2 * k] * v[2 * k] + v[2 * k + 1] * v[2 * k + 1]);
    for (k = fixed; k < n; k++)
        sum += speed[k];
    return sum;
}

/* Moves bubbles at x (n, 2) from rest, but for the first ones, so many steps with viscosities c (steps,); their mean
   speeds (steps,) come out. No step is longer than most (n,). */
KERNEL int64_t relax(int64_t n, int64_t m, const int64_t *ends, const double *contact, const double *strength,
                     double cutoff, double *x, int64_t fixed, const double *most, double dt, int64_t steps,
                     const double *c, double *speeds)
{
    const Pairs pairs = {n, m, ends, contact, cutoff};
    const Motion motion = {n, fixed, x, calloc((size_t)(2 * n + 1), sizeof *x), most};
    Groups groups = {malloc((size_t)(n + 1) * sizeof *groups.begin), malloc((size_t)(n + 1) * sizeof *groups.middle),
                     malloc((size_t)(2 * m + 1) * sizeof *groups.pairs)};
    double *pushes = malloc((size_t)(2 * m + 1) * sizeof *pushes);
    double *acceleration = malloc((size_t)(2 * n + 1) * sizeof *acceleration);
    int64_t step, status = NO_MEMORY;
    if (motion.v && groups.begin && groups.middle && groups.pairs && pushes && acceleration && 2 * m < INT32_MAX) {
        group(&pairs, &groups);
        for (step = 0; step < steps; step++) {
            first_forces(&pairs, x, pushes);
            accelerate(n, fixed, &groups, pushes, strength, acceleration);
            speeds[step] = move(&motion, dt, c[step], acceleration) / (double)n;
        }
        status = DONE;
    }
    free(motion.v);
    free(groups.begin);
    free(groups.middle);
    free(groups.pairs);
    free(pushes);
    free(acceleration);
    return status;
}
