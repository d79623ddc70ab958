/* Forces between bubbles, and steps of their motion; see relaxing.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "relaxing.h"

enum { BLOCK = 64 }; /* pairs whose forces are found side by side */

static const double SURELY = 0.99; /* of the longest step: rounding makes none of these longer */

/* Forces (BLOCK, 2) on the first members of pairs that are apart (BLOCK, 2), as in forces.py. */
SIDE_BY_SIDE static void block_forces(const double *apart, const double *contact, double cutoff, double *force)
{
    int k;
    for (k = 0; k < BLOCK; k++) {
        double dx = apart[2 * k], dy = apart[2 * k + 1];
        double distance = sqrt(dx * dx + dy * dy), least = 1e-12 * contact[k];
        double size = pair_force(distance / contact[k], cutoff) / (distance > least ? distance : least);
        force[2 * k] = size * dx;
        force[2 * k + 1] = size * dy;
    }
}

/* Adds to pushes (n, 2) the forces on the first members of pairs, and to pulls (n, 2) those against the last ones, for
   bubbles at x (n, 2), in the order of the pairs. */
static void add_forces(const Pairs *pairs, const double *restrict x, double *restrict pushes, double *restrict pulls)
{
    double apart[2 * BLOCK] = {0}, rest[BLOCK], force[2 * BLOCK];
    int64_t begin, k;
    for (k = 0; k < BLOCK; k++)
        rest[k] = 1.0;
    for (begin = 0; begin < pairs->m; begin += BLOCK) {
        const int32_t *ends = pairs->ends + 2 * begin;
        const double *contact = pairs->contact + begin;
        int64_t count = pairs->m - begin < BLOCK ? pairs->m - begin : BLOCK;
        for (k = 0; k < count; k++) {
            const double *one = x + 2 * (int64_t)ends[2 * k], *other = x + 2 * (int64_t)ends[2 * k + 1];
            apart[2 * k] = one[0] - other[0];
            apart[2 * k + 1] = one[1] - other[1];
        }
        if (count < BLOCK) /* the last ones, beyond whose contact is nothing to read */
            contact = memcpy(rest, contact, (size_t)count * sizeof *rest);
        block_forces(apart, contact, pairs->cutoff, force);
        for (k = 0; k < count; k++) {
            double *first = pushes + 2 * (int64_t)ends[2 * k], *last = pulls + 2 * (int64_t)ends[2 * k + 1];
            first[0] += force[2 * k];
            first[1] += force[2 * k + 1];
            last[0] += force[2 * k];
            last[1] += force[2 * k + 1];
        }
    }
}

/* Accelerations (n, 2) of bubbles at x (n, 2): what pushes first members, less what pulls the last; pulls (n, 2) are
   for work. */
static void accelerate(const Pairs *pairs, const double *x, double *acceleration, double *pulls)
{
    int64_t k, n = pairs->n;
    for (k = 0; k < 2 * n; k++)
        acceleration[k] = pulls[k] = 0.0;
    add_forces(pairs, x, acceleration, pulls);
    for (k = 0; k < n; k++) {
        acceleration[2 * k] = pairs->strength[k] * (acceleration[2 * k] - pulls[2 * k]);
        acceleration[2 * k + 1] = pairs->strength[k] * (acceleration[2 * k + 1] - pulls[2 * k + 1]);
    }
}

/* Pairs with ends (m, 2) of so many bubbles; the ends are NULL where memory is short or bubbles are too many. */
static Pairs pairs_of(int64_t n, int64_t m, const int64_t *ends, const double *contact, const double *strength,
                      double cutoff)
{
    Pairs pairs = {n, m, NULL, contact, strength, cutoff};
    int64_t k;
    if (n < INT32_MAX)
        pairs.ends = malloc((size_t)(2 * m + 1) * sizeof *pairs.ends);
    for (k = 0; k < 2 * m && pairs.ends; k++)
        pairs.ends[k] = (int32_t)ends[k];
    return pairs;
}

/* Forces (n, 2) between the pairs (m, 2) of bubbles at x (n, 2). */
KERNEL int64_t pair_forces(int64_t n, int64_t m, const int64_t *ends, const double *contact, const double *strength,
                           double cutoff, const double *x, double *force)
{
    Pairs pairs = pairs_of(n, m, ends, contact, strength, cutoff);
    double *pulls = malloc((size_t)(2 * n + 1) * sizeof *pulls);
    int64_t status = NO_MEMORY;
    if (pairs.ends && pulls) {
        accelerate(&pairs, x, force, pulls);
        status = DONE;
    }
    free(pairs.ends);
    free(pulls);
    return status;
}

/* Velocities (count,) after a step with an acceleration (count,), damped implicitly. */
SIDE_BY_SIDE static void speed_up(int64_t count, double dt, double damped, const double *restrict acceleration,
                                  double *restrict v)
{
    int64_t k;
    for (k = 0; k < count; k++)
        v[k] = (v[k] + dt * acceleration[k]) / damped;
}

/* Speeds (n,) of velocities v (n, 2); whether none is so high that a step of dt may be longer than most (n,). */
SIDE_BY_SIDE static int find_speeds(int64_t n, double dt, const double *restrict v, const double *restrict most,
                                    double *restrict speed)
{
    int64_t k, near = 0;
    for (k = 0; k < n; k++) {
        speed[k] = sqrt(v[2 * k] * v[2 * k] + v[2 * k + 1] * v[2 * k + 1]);
        near += dt * speed[k] <= SURELY * most[k];
    }
    return near == n;
}

/* Places x (count,) after a step with velocities v (count,). */
SIDE_BY_SIDE static void go_on(int64_t count, double dt, const double *restrict v, double *restrict x)
{
    int64_t k;
    for (k = 0; k < count; k++)
        x[k] = x[k] + dt * v[k];
}

/* Places x (n, 2) after a step with velocities v (n, 2) of which none is longer than most (n,), as in relaxation.py; no
   velocity is longer then. */
static void go_on_within(int64_t n, double dt, const double *most, double *v, double *x)
{
    int64_t k;
    int far = 0;
    for (k = 0; k < n; k++) {
        double dx = (x[2 * k] + dt * v[2 * k]) - x[2 * k], dy = (x[2 * k + 1] + dt * v[2 * k + 1]) - x[2 * k + 1];
        far |= !(sqrt(dx * dx + dy * dy) <= most[k]);
    }
    if (!far) {
        go_on(2 * n, dt, v, x);
        return;
    }
    for (k = 0; k < n; k++) {
        double dx = (x[2 * k] + dt * v[2 * k]) - x[2 * k], dy = (x[2 * k + 1] + dt * v[2 * k + 1]) - x[2 * k + 1];
        double length = sqrt(dx * dx + dy * dy), share = most[k] / (length > most[k] ? length : most[k]);
        x[2 * k] = x[2 * k] + share * dx;
        x[2 * k + 1] = x[2 * k + 1] + share * dy;
        v[2 * k] = share * v[2 * k];
        v[2 * k + 1] = share * v[2 * k + 1];
    }
}

/* One step with an acceleration (n, 2), of bubbles that are not fixed; the sum of their speeds, with speed (n,) for
   work. */
static double move(const Motion *motion, double dt, double viscosity, const double *acceleration, double *speed)
{
    int64_t k, fixed = motion->fixed, free_ones = motion->n - fixed;
    double *x = motion->x + 2 * fixed, *v = motion->v + 2 * fixed, sum = 0.0;
    const double *most = motion->most + fixed;
    speed_up(2 * free_ones, dt, 1.0 + viscosity * dt, acceleration + 2 * fixed, v);
    if (find_speeds(free_ones, dt, v, most, speed)) {
        go_on(2 * free_ones, dt, v, x);
    } else {
        go_on_within(free_ones, dt, most, v, x);
        find_speeds(free_ones, dt, v, most, speed);
    }
    for (k = 0; k < free_ones; k++)
        sum += speed[k];
    return sum;
}

int64_t relax_pairs(const Pairs *pairs, const Motion *motion, double dt, int64_t steps, const double *c, double *speeds)
{
    int64_t k, step, n = pairs->n, status = NO_MEMORY;
    double *acceleration = malloc((size_t)(2 * n + 1) * sizeof *acceleration);
    double *pulls = malloc((size_t)(2 * n + 1) * sizeof *pulls);
    for (k = 0; k < 2 * n; k++)
        motion->v[k] = 0.0;
    if (acceleration && pulls) {
        for (step = 0; step < steps; step++) {
            accelerate(pairs, motion->x, acceleration, pulls);
            speeds[step] = move(motion, dt, c[step], acceleration, pulls) / (double)n;
        }
        status = DONE;
    }
    free(acceleration);
    free(pulls);
    return status;
}

/* Moves bubbles at x (n, 2) as `relax_pairs` does, by the forces between pairs with ends (m, 2). */
KERNEL int64_t relax(int64_t n, int64_t m, const int64_t *ends, const double *contact, const double *strength,
                     double cutoff, double *x, int64_t fixed, const double *most, double dt, int64_t steps,
                     const double *c, double *speeds)
{
    Pairs pairs = pairs_of(n, m, ends, contact, strength, cutoff);
    const Motion motion = {n, fixed, x, malloc((size_t)(2 * n + 1) * sizeof *x), most};
    int64_t status = NO_MEMORY;
    if (pairs.ends && motion.v)
        status = relax_pairs(&pairs, &motion, dt, steps, c, speeds);
    free(pairs.ends);
    free(motion.v);
    return status;
}
