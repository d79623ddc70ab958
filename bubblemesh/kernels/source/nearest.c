/* The nearest chord of each point, among runs of chords in a binary tree of boxes; see nearest.py. */
#include <math.h>
#include <stdlib.h>

#include "kernels.h"

enum { DEPTH = 64 };

typedef struct {
    const double *points, *rectangles;
    const int64_t *first, *count;
    int64_t length; /* chords of the longest run */
} Runs;

typedef struct {
    double squared;
    int64_t chord;
} Found;

static double beyond(double low, double value, double high)
{
    double under = low - value, over = value - high, most = under > over ? under : over;
    return most > 0 ? most : 0;
}

/* Squared distance of a point from a box: low x and y, high x and y. */
static double from_box(const double *box, double x, double y)
{
    double dx = beyond(box[0], x, box[2]), dy = beyond(box[1], y, box[3]);
    return dx * dx + dy * dy;
}

/* Squared distance of a point from a run's rectangle: centre, axis, half its length and half its width. */
static double from_rectangle(const double *of, double x, double y)
{
    double dx = x - of[0], dy = y - of[1], along = dx * of[2] + dy * of[3], aside = dy * of[2] - dx * of[3];
    along = beyond(-of[4], along, of[4]);
    aside = beyond(-of[5], aside, of[5]);
    return along * along + aside * aside;
}

/* Squared distances (count,) of a place from the chords between points (count + 1,) and (count + 1,). */
SIDE_BY_SIDE static void from_chords(const double *restrict xs, const double *restrict ys, int64_t count, double px,
                                     double py, double *restrict squared)
{
    int64_t k;
    for (k = 0; k < count; k++) {
        double x = xs[k] - px, y = ys[k] - py, next_x = xs[k + 1] - px, next_y = ys[k + 1] - py;
        double ux = xs[k + 1] - xs[k], uy = ys[k + 1] - ys[k], across = ux * y - uy * x, length = ux * ux + uy * uy;
        double from_start = x * x + y * y, from_end = next_x * next_x + next_y * next_y;
        double nearer = from_start < from_end ? from_start : from_end, beside = across * (across / length);
        squared[k] = fabs(from_start - from_end) < length ? beside : nearer;
    }
}

/* The nearest chord of one run, if it is nearer than what was found, or as near with a smaller number. There is room
   for squared distances (length,). */
static void look_at(const Runs *runs, int64_t run, double px, double py, double *squared, Found *found)
{
    const double *xs = runs->points + 2 * (runs->length + 1) * run, *ys = xs + runs->length + 1;
    int64_t count = runs->count[run], rank = 0, k;
    double least = INFINITY;
    from_chords(xs, ys, count, px, py, squared);
    for (k = 0; k < count; k++)
        if (squared[k] < least) {
            least = squared[k];
            rank = k;
        }
    if (count < runs->length) { /* the last point is repeated in shorter runs */
        double x = xs[count] - px, y = ys[count] - py, from_last = x * x + y * y;
        if (from_last < least) {
            least = from_last;
            rank = count - 1;
        }
    }
    if (least < found->squared || (least == found->squared && runs->first[run] + rank < found->chord)) {
        found->squared = least;
        found->chord = runs->first[run] + rank;
    }
}

/* Chords (n,) nearest to places (n, 2). The tree has boxes (2 * leaves, 4), the root's being the second; its leaves
   are the runs with points (runs, 2, length + 1), first chord and number of chords (runs,) and rectangles (runs, 6). */
KERNEL int64_t nearest_chords(int64_t n, const double *places, int64_t count, int64_t leaves, int64_t length,
                              const double *boxes, const double *points, const double *rectangles,
                              const int64_t *first, const int64_t *counts, double slack, int64_t *nearest)
{
    Runs runs = {points, rectangles, first, counts, length};
    int64_t k, last = 0;
    double *squared = malloc((size_t)length * sizeof *squared);
    if (squared == NULL)
        return NO_MEMORY;
    for (k = 0; k < n; k++) {
        double x = places[2 * k], y = places[2 * k + 1];
        Found found = {INFINITY, INT64_MAX};
        int64_t stack[DEPTH], depth = 0, up, best = last;
        double away[DEPTH]; /* squared distances of the boxes on the stack */
        look_at(&runs, last, x, y, squared, &found); /* places mostly lie near to the one before */
        for (up = leaves + last; up > 1; up /= 2) {  /* so the search goes up from there, to what is beside */
            away[depth] = from_box(boxes + 4 * (up ^ 1), x, y);
            stack[depth++] = up ^ 1;
            while (depth > 0) {
                int64_t node = stack[--depth];
                if (away[depth] > found.squared * slack)
                    continue;
                if (node < leaves) { /* the nearer branch comes first, so that more of the other one is left out */
                    double one = from_box(boxes + 8 * node, x, y), other = from_box(boxes + 8 * node + 4, x, y);
                    int nearer = other < one;
                    away[depth] = nearer ? one : other;
                    stack[depth++] = 2 * node + !nearer;
                    away[depth] = nearer ? other : one;
                    stack[depth++] = 2 * node + nearer;
                } else if (node - leaves < count) {
                    int64_t run = node - leaves, before = found.chord;
                    if (from_rectangle(rectangles + 6 * run, x, y) <= found.squared * slack)
                        look_at(&runs, run, x, y, squared, &found);
                    best = found.chord == before ? best : run;
                }
            }
        }
        last = best;
        nearest[k] = found.chord;
    }
    free(squared);
    return DONE;
}
