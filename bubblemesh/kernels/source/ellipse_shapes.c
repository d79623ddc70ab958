/* Shapes of triangles in a metric, and flips of edges that better them; see ellipse_shapes.py. */
#include <math.h>
#include <stdlib.h>

#include "ellipses.h"

/* Shape measures eta (t,) of triangles (t, 3) of nodes x (., 2) in metrics with roots (t, 3); infinite for one that is
   flat or inverted. */
KERNEL int64_t metric_shapes(int64_t t, const int64_t *triangles, const double *x, const double *roots, double *eta)
{
    int64_t k;
    for (k = 0; k < t; k++) {
        const double *a = x + 2 * triangles[3 * k], *b = x + 2 * triangles[3 * k + 1], *c = x + 2 * triangles[3 * k + 2];
        const double *r = roots + 3 * k;
        double ux = r[0] * (b[0] - a[0]) + r[1] * (b[1] - a[1]), uy = r[2] * (b[1] - a[1]);
        double wx = r[0] * (c[0] - a[0]) + r[1] * (c[1] - a[1]), wy = r[2] * (c[1] - a[1]);
        double zx = wx - ux, zy = wy - uy, area = (ux * wy - uy * wx) / 2;
        double squares = (ux * ux + uy * uy) + (wx * wx + wy * wy) + (zx * zx + zy * zy);
        eta[k] = area > 0 ? squares / (6.9282032302755088 * area) : INFINITY;
    }
    return DONE;
}

/* Sides of triangles (t, 3), but along facets (f, 2), whose flips are worth a look: one of the two triangles there is
   fresh (t,), and one has a measure (t,) above what is good. Out come the two triangles of each (2 count,), those after
   the flip (2 count, 3), and the count (1,). */
KERNEL int64_t flips_of_shapes(int64_t n, int64_t t, int64_t *triangles, int64_t f, const int64_t *facets,
                               const double *measures, const char *fresh, double good, int64_t *owners,
                               int64_t *turned, int64_t *count)
{
    Sides s;
    int64_t side, k = 0, status = take_sides(&s, n, t, triangles, f, facets);
    for (side = 0; side < 3 * t && status == DONE; side++) {
        int64_t twin = s.twin[side], one = side / 3, two = twin / 3, *row = turned + 6 * k;
        const int64_t *first = triangles + 3 * one, *second = triangles + 3 * two;
        if (twin < side || s.fixed[side] || !(fresh[one] || fresh[two]) || !(measures[one] > good || measures[two] > good))
            continue;
        owners[2 * k] = one;
        owners[2 * k++ + 1] = two;
        row[0] = first[side % 3], row[1] = row[3] = second[(twin + 2) % 3];
        row[2] = row[5] = first[(side + 2) % 3], row[4] = first[(side + 1) % 3];
    }
    *count = k;
    give_sides_back(&s);
    return status;
}

/* Takes of the flips between two triangles each (2 m,) those that lessen the larger measure by more than a part of it,
   and most of all flips of both triangles. These, their measures (t,) and the roots (t, 3) of the metric in them become
   those after the flip, (2 m, 3), (2 m,) and (2 m, 3). Fresh (t,) are then the triangles with any gain. */
KERNEL int64_t flip_to_shapes(int64_t t, int64_t *triangles, double *measures, double *roots, int64_t m,
                              const int64_t *owners, const int64_t *turned, const double *after, const double *there,
                              double least, char *fresh)
{
    int64_t *best = malloc((size_t)(t + 1) * sizeof *best), k, j;
    double *gain = malloc((size_t)(m + 1) * sizeof *gain);
    int64_t status = best && gain ? DONE : NO_MEMORY;
    for (k = 0; k < t && status == DONE; k++)
        best[k] = -1;
    for (k = 0; k < m && status == DONE; k++) {
        double one = measures[owners[2 * k]], two = measures[owners[2 * k + 1]];
        double larger = after[2 * k] > after[2 * k + 1] ? after[2 * k] : after[2 * k + 1];
        gain[k] = 1 - larger / (one > two ? one : two);
        for (j = 0; j < 2 && gain[k] > least; j++)
            if (best[owners[2 * k + j]] < 0 || gain[k] > gain[best[owners[2 * k + j]]])
                best[owners[2 * k + j]] = k;
    }
    for (k = 0; k < t && status == DONE; k++)
        fresh[k] = best[k] >= 0;
    for (k = 0; k < m && status == DONE; k++) {
        if (best[owners[2 * k]] != k || best[owners[2 * k + 1]] != k)
            continue;
        for (j = 0; j < 6; j++) {
            triangles[3 * owners[2 * k + j / 3] + j % 3] = turned[6 * k + j];
            roots[3 * owners[2 * k + j / 3] + j % 3] = there[6 * k + j];
        }
        measures[owners[2 * k]] = after[2 * k];
        measures[owners[2 * k + 1]] = after[2 * k + 1];
    }
    free(best);
    free(gain);
    return status;
}
