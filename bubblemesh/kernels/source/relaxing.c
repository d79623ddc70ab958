/* Forces between bubbles, and steps of their motion; see relaxing.py. */
#include <math.h>
#include <stdlib.h>

#include "kernels.h"

static const double BEYOND_ROUNDING = 1 + 1e-12;

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* Forces (n, 2) between the pairs (m, 2), as in forces.py: apart is what pushes first members, against what pulls. */
static void forces(int64_t n, int64_t m, const int64_t *pairs, const double *contact, const double *strength,
                   double cutoff, const double *x, double *apart, double *against, double *force)
{
    int64_t k;
    for (k = 0; k < 2 * n; k++)
        apart[k] = against[k] = 0.0;
    for (k = 0; k < m; k++) {
        int64_t i = 2 * pairs[2 * k], j = 2 * pairs[2 * k + 1];
        double dx = x[i] - x[j], dy = x[i + 1] - x[j + 1];
        double squared = dx * dx + dy * dy, most = cutoff * contact[k], distance, ratio, size = 0.0;
        if (squared > most * most * BEYOND_ROUNDING) /* no force, which would take most of the time here */
            continue;
        distance = sqrt(squared);
        ratio = distance / contact[k];
        if (ratio < cutoff)
            size = ((1.25 * ratio - 2.375) * ratio) * ratio + 1.125;
        size = size / larger(distance, 1e-12 * contact[k]);
        apart[i] += size * dx;
        apart[i + 1] += size * dy;
        against[j] += size * dx;
        against[j + 1] += size * dy;
    }
    for (k = 0; k < 2 * n; k++)
        force[k] = strength[k / 2] * (apart[k] - against[k]);
}

/* Forces (n, 2) between the pairs (m, 2) of bubbles at x (n, 2). */
KERNEL int64_t pair_forces(int64_t n, int64_t m, const int64_t *pairs, const double *contact, const double *strength,
                           double cutoff, const double *x, double *force)
{
    double *work = malloc((size_t)(4 * n + 1) * sizeof *work);
    if (!work)
        return NO_MEMORY;
    forces(n, m, pairs, contact, strength, cutoff, x, work, work + 2 * n, force);
    free(work);
    return DONE;
}

/* Moves bubbles at x (n, 2) from rest, but for the first ones, so many steps with viscosities c (steps,); their mean
   speeds (steps,) come out. No step is longer than most (n,). */
KERNEL int64_t relax(int64_t n, int64_t m, const int64_t *pairs, const double *contact, const double *strength,
                     double cutoff, double *x, int64_t fixed, const double *most, double dt, int64_t steps,
                     const double *c, double *speeds)
{
    double *work = calloc((size_t)(10 * n + 1), sizeof *work);
    double *apart, *against, *force, *v, *move;
    int64_t step, k;
    if (!work)
        return NO_MEMORY;
    apart = work;
    against = work + 2 * n;
    force = work + 4 * n;
    v = work + 6 * n;
    move = work + 8 * n;
    for (step = 0; step < steps; step++) {
        double damped = 1.0 + c[step] * dt, sum = 0.0;
        int far = 0;
        forces(n, m, pairs, contact, strength, cutoff, x, apart, against, force);
        for (k = 2 * fixed; k < 2 * n; k++) {
            v[k] = (v[k] + dt * force[k]) / damped;
            force[k] = x[k] + dt * v[k]; /* where it moves to */
            move[k] = force[k] - x[k];
        }
        for (k = fixed; k < n; k++) {
            double length = sqrt(move[2 * k] * move[2 * k] + move[2 * k + 1] * move[2 * k + 1]);
            far |= !(length <= most[k]);
        }
        for (k = fixed; k < n; k++) {
            double length, share;
            if (!far) {
                x[2 * k] = force[2 * k];
                x[2 * k + 1] = force[2 * k + 1];
            } else {
                length = sqrt(move[2 * k] * move[2 * k] + move[2 * k + 1] * move[2 * k + 1]);
                share = most[k] / larger(length, most[k]);
                x[2 * k] = x[2 * k] + share * move[2 * k];
                x[2 * k + 1] = x[2 * k + 1] + share * move[2 * k + 1];
                v[2 * k] = share * v[2 * k];
                v[2 * k + 1] = share * v[2 * k + 1];
            }
            sum += sqrt(v[2 * k] * v[2 * k] + v[2 * k + 1] * v[2 * k + 1]);
        }
        speeds[step] = sum / (double)n;
    }
    free(work);
    return DONE;
}
