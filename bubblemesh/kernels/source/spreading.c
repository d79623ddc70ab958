/* Values that spread over the cells of a quadtree: the Eikonal equation; see spreading.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

static const double HALF_ROOT = 0.70710678118654757; /* sqrt(0.5) */
static const double ROOT = 1.4142135623730951;       /* sqrt(2) */
static const double LEAST_RISE = 0.7; /* rises: less than sqrt(0.5), by which no value is passed on less raised */
static const int BESIDE[4][2] = {{1, 2}, {0, 3}, {3, 0}, {2, 1}};

/* The value that a corner takes from the corner beside it and the opposite one. */
static double reached(double beside, double opposite, double rise)
{
    double slant = (beside - opposite) / rise, crossing, straight = opposite + rise * ROOT;
    if (!(slant > 0.0)) /* also where both are infinite */
        slant = 0.0;
    if (slant >= HALF_ROOT)
        return straight;
    crossing = beside + rise * sqrt(1.0 - slant * slant);
    return crossing < straight ? crossing : straight;
}

/* Lowers values (vertices,) in place, sweep by sweep, until no cell of corners (cells, 4) lowers one any more. */
KERNEL int64_t spread(int64_t cells, const int64_t *corners, const double *rise, int64_t vertices, double *values,
                      double kept, int64_t sweeps)
{
    int64_t *around = malloc((size_t)(4 * vertices + 1) * sizeof *around);
    int64_t *active = malloc((size_t)(cells + 1) * sizeof *active), *next = malloc((size_t)(cells + 1) * sizeof *next);
    int64_t *lowered = malloc((size_t)(4 * cells + 1) * sizeof *lowered);
    double *to = malloc((size_t)(4 * cells + 1) * sizeof *to);
    char *waiting = calloc((size_t)(cells + 1), 1);
    int64_t status = NO_MEMORY, count = cells, cell, k;
    if (!around || !active || !next || !lowered || !to || !waiting)
        goto end;
    memset(around, -1, (size_t)(4 * vertices) * sizeof *around);
    for (cell = 0; cell < cells; cell++) {
        active[cell] = cell;
        for (k = 0; k < 4; k++)
            around[4 * corners[4 * cell + k] + k] = cell;
    }
    while (count > 0 && sweeps-- > 0) {
        int64_t found = 0, *swapped, place;
        for (place = 0; place < count; place++) {
            const int64_t *mine = corners + 4 * active[place];
            double v[4], rising = rise[active[place]], passed_on;
            for (k = 0; k < 4; k++)
                v[k] = values[mine[k]];
            passed_on = fmin(fmin(v[0], v[1]), fmin(v[2], v[3])) + LEAST_RISE * rising;
            for (k = 0; k < 4; k++) {
                if (v[k] * kept <= passed_on)
                    continue;
                double first = reached(v[BESIDE[k][0]], v[3 - k], rising);
                double second = reached(v[BESIDE[k][1]], v[3 - k], rising);
                double least = first < second ? first : second;
                if (least < v[k] * kept) {
                    lowered[found] = mine[k];
                    to[found++] = least;
                }
            }
        }
        count = 0;
        for (place = 0; place < found; place++) {
            int64_t vertex = lowered[place];
            if (to[place] < values[vertex])
                values[vertex] = to[place];
            for (k = 0; k < 4; k++) {
                cell = around[4 * vertex + k];
                if (cell >= 0 && !waiting[cell]) {
                    waiting[cell] = 1;
                    next[count++] = cell;
                }
            }
        }
        for (place = 0; place < count; place++)
            waiting[next[place]] = 0;
        swapped = active;
        active = next;
        next = swapped;
    }
    status = DONE;
end:
    free(around);
    free(active);
    free(next);
    free(lowered);
    free(to);
    free(waiting);
    return status;
}
