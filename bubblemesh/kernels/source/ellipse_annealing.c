/* Cycles of annealing in a metric: displacements where the order is broken, flips, and relaxations; see
   ellipse_annealing.py. */
#include <stdlib.h>

#include "disorder.h"
#include "ellipses.h"

/* Nodes (n, 2) with roots (n, 3) of their tensors, of which the first ones are on the boundary. */
typedef struct {
    int64_t n, fixed;
    double *x;
    const double *roots;
    const char *calm; /* (n,): whether they are not displaced */
} Nodes;

/* Moves (n, 2) of marked nodes by random lengths of standard deviations ``inside``, or ``beside`` the boundary, in the
   metric. */
static void choose_moves(const Nodes *nodes, const char *near, const Chance *chance, double inside, double beside,
                         double *move)
{
    int64_t k;
    for (k = 0; k < nodes->n; k++) {
        const double *root = nodes->roots + 3 * k;
        double size = near[k] & BESIDE_BOUNDARY ? beside : inside;
        uint64_t bits;
        move[2 * k] = move[2 * k + 1] = 0;
        if (k < nodes->fixed || !(near[k] & DISORDERED) || nodes->calm[k])
            continue;
        bits = random_bits(chance, k);
        move[2 * k + 1] = size * deviation(bits >> 32) / root[2];
        move[2 * k] = (size * deviation(bits) - root[1] * move[2 * k + 1]) / root[0];
    }
}

/* Cycles of annealing of nodes at x (n, 2), with tensors m (n, 3) and their roots, of which the first ones are ``fixed``
   and ``calm`` ones (n,) are not displaced, with triangles (t, 3) within facets (f, 2).

   Each cycle displaces by standard deviations of ``inside`` and ``beside`` (cycles,) the boundary, flips, and relaxes by
   so many steps. Its random numbers are those of the seed and of its number, counted on from ``first``. Places,
   triangles, and the edges (3 t, 2) with their number in count (1,) are those in the end. */
KERNEL int64_t metric_anneal(int64_t n, int64_t t, int64_t *triangles, int64_t f, const int64_t *facets, double *x,
                             const double *m, const double *roots, int64_t fixed, const char *calm, int64_t cycles,
                             const double *inside, const double *beside, int64_t seed, int64_t first, int64_t steps,
                             double dt, double c, double cutoff, double most, double keep, double shortest,
                             int64_t passes, double sure, double flattest, int64_t *edges, int64_t *count)
{
    const Circles circles = {passes, sure, flattest};
    const Moving moving = {dt, c, cutoff, most, keep, shortest};
    const Nodes nodes = {n, fixed, x, roots, calm};
    int32_t *ends = malloc((size_t)(6 * t + 1) * sizeof *ends), *valence = malloc((size_t)(n + 1) * sizeof *valence);
    double *speeds = malloc((size_t)(steps + 1) * sizeof *speeds);
    char *near = malloc((size_t)(n + 1));
    Sides sides;
    Room room;
    int64_t cycle, k, status = take_sides(&sides, n, t, triangles, f, facets);
    if (!make_moving_room(&room, n, t) || !ends || !valence || !speeds || !near || n >= INT32_MAX)
        status = NO_MEMORY;
    for (cycle = 0; status == DONE; cycle++) {
        const Chance chance = {(uint64_t)seed, (uint64_t)(first + cycle)};
        *count = list_side_edges(&sides, edges);
        for (k = 0; k < 2 * *count; k++)
            ends[k] = (int32_t)edges[k];
        if (cycle > 0)
            relax_ellipses(n, t, triangles, *count, ends, x, m, fixed, steps, &moving, speeds, &room);
        if (cycle == cycles)
            break;
        mark_disorder(n, fixed, *count, edges, valence, near);
        choose_moves(&nodes, near, &chance, inside[cycle], beside[cycle], room.move);
        move_guarded(n, t, triangles, x, room.move, keep, &room);
        flip_wrong(&sides, x, m, &circles);
    }
    free(ends);
    free(valence);
    free(speeds);
    free(near);
    leave_moving_room(&room);
    give_sides_back(&sides);
    return status;
}
