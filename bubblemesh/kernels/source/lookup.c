/* Ranks among ascending numbers, and values in the cells of a quadtree; see lookup.py. */
#include <math.h>

#include "kernels.h"

/* Number of the ascending numbers (n,) that are at most ``wanted``, looked for from a place among them on. */
static int64_t rank_of(int64_t n, const int64_t *ascending, int64_t wanted, int64_t from)
{
    int64_t low = from, high = from, step = 1; /* the rank is from low to high */
    if (from < n && ascending[from] <= wanted) {
        while (high < n && ascending[high] <= wanted) {
            low = high + 1;
            high = step < n - high ? high + step : n;
            step *= 2;
        }
    } else {
        while (low > 0 && ascending[low - 1] > wanted) {
            high = low - 1;
            low = step < low ? low - step : 0;
            step *= 2;
        }
    }
    while (low < high) {
        int64_t middle = low + (high - low) / 2;
        if (ascending[middle] <= wanted)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Ranks (m,) of numbers (m,) among ascending ones (n,): how many of these are below them, or not above them. */
KERNEL int64_t ranks(int64_t n, const int64_t *ascending, int64_t m, const int64_t *numbers, int64_t with_equal,
                     int64_t *result)
{
    int64_t k, last = 0;
    for (k = 0; k < m; k++) {
        if (!with_equal && numbers[k] == INT64_MIN)
            last = 0;
        else
            last = rank_of(n, ascending, with_equal ? numbers[k] : numbers[k] - 1, last);
        result[k] = last;
    }
    return DONE;
}

/* The bits of a number below 2^32, each with a free one above it. */
static uint64_t parted(uint64_t bits)
{
    bits = (bits | bits << 16) & 0x0000FFFF0000FFFFu;
    bits = (bits | bits << 8) & 0x00FF00FF00FF00FFu;
    bits = (bits | bits << 4) & 0x0F0F0F0F0F0F0F0Fu;
    bits = (bits | bits << 2) & 0x3333333333333333u;
    return (bits | bits << 1) & 0x5555555555555555u;
}

/* Column or row of a coordinate in a grid of ``count`` ones; what is no number has the first. */
static uint64_t column(double at, double low, double scale, double count)
{
    double place = (at - low) * scale;
    return place > 0 ? (uint64_t)(place < count - 1 ? place : count - 1) : 0;
}

static double within(double share)
{
    return share < 0 ? 0 : share > 1 ? 1 : share;
}

/* Values (m,) at points (m, 2), bilinear in the cells (n,) that hold them, with the keys of their lower left corners in
   Morton's order, ascending, these corners (n, 2) in columns and rows, of which there are ``count``, and the vertices
   (n, 4) at which they have values; infinite in cells whose first vertex is -1. The grid has its lower left corner at
   x, y, and ``scale`` columns per length, of width ``unit``. */
KERNEL int64_t interpolate(int64_t m, const double *points, double x, double y, double scale, double unit, double count,
                           int64_t n, const int64_t *key, const int64_t *corner, const double *sides,
                           const int64_t *vertices, const double *values, double *result)
{
    int64_t k, cell = 0;
    for (k = 0; k < m; k++) {
        double px = points[2 * k], py = points[2 * k + 1], s, t;
        const int64_t *at;
        uint64_t wanted = parted(column(px, x, scale, count)) | parted(column(py, y, scale, count)) << 1;
        cell = rank_of(n, key, (int64_t)wanted, cell) - 1;
        at = vertices + 4 * cell;
        if (at[0] < 0) {
            result[k] = INFINITY;
            continue;
        }
        s = within((px - (x + (double)corner[2 * cell] * unit)) / sides[cell]);
        t = within((py - (y + (double)corner[2 * cell + 1] * unit)) / sides[cell]);
        result[k] = (1 - t) * ((1 - s) * values[at[0]] + s * values[at[1]]) +
                    t * ((1 - s) * values[at[2]] + s * values[at[3]]);
    }
    return DONE;
}
