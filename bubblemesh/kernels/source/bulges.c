/* Distances from curves that are cubics above chords; see bulges.py. */
#include <math.h>

#include "kernels.h"

static double clipped(double value, double low, double high)
{
    double most = value > low ? value : low;
    return most < high ? most : high;
}

/* Distances (n,) of places (n, 2) from some of the cubics (n,), by so many steps of Newton's method. Of each cubic there
   are (9,): the chord's start, direction and length, the slopes at both ends, and the range of feet along the chord. */
KERNEL int64_t bulge_distances(int64_t n, const double *places, const int64_t *of, const double *cubics, int64_t steps,
                               double flattest, double *distance)
{
    int64_t k, step;
    for (k = 0; k < n; k++) {
        const double *c = cubics + 9 * of[k];
        double x = places[2 * k] - c[0], y = places[2 * k + 1] - c[1], dx = c[2], dy = c[3], length = c[4];
        double linear = c[5], square = -(2 * c[5] + c[6]) / length, cubic = (c[5] + c[6]) / (length * length);
        double along = x * dx + y * dy, above = dx * y - dy * x, at = clipped(along, 0, length), aside, height;
        for (step = 0; step < steps; step++) {
            double slope = linear + at * (2 * square + 3 * cubic * at), steepness;
            height = at * (linear + at * (square + at * cubic)) - above;
            steepness = 1 + slope * slope + height * (2 * square + 6 * cubic * at);
            steepness = steepness > flattest ? steepness : flattest;
            at = clipped(at - (at - along + height * slope) / steepness, c[7], c[8]);
        }
        aside = at - along;
        height = at * (linear + at * (square + at * cubic)) - above;
        distance[k] = sqrt(aside * aside + height * height);
    }
    return DONE;
}
