/* The nearest chord of each point, among runs of chords in a binary tree of boxes; see nearest.py. */
#include <math.h>

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

/* The nearest chord of one run, if it is nearer than what was found, or as near with a smaller number. */
static void look_at(const Runs *runs, int64_t run, double px, double py, Found *found)
{
    const double *at = runs->points + 2 * (runs->length + 1) * run;
    int64_t count = runs->count[run], rank = 0, k;
    double x = at[0] - px, y = at[1] - py, from_start = x * x + y * y, least = INFINITY;
    for (k = 0; k < count; k++) {
        double ux = at[2 * k + 2] - at[2 * k], uy = at[2 * k + 3] - at[2 * k + 1], across = ux * y - uy * x;
        double length = ux * ux + uy * uy, from_end, squared;
        x = at[2 * k + 2] - px;
        y = at[2 * k + 3] - py;
        from_end = x * x + y * y;
        if (fabs(from_start - from_end) < length)
            squared = across * (across / length);
        else
            squared = from_start < from_end ? from_start : from_end;
        if (squared < least) {
            least = squared;
            rank = k;
        }
        from_start = from_end;
    }
    if (count < runs->length && from_start < least) { /* the last point is repeated in shorter runs */
        least = from_start;
        rank = count - 1;
    }
    if (least < found->squared || (least == found->squared && runs->first[run] + rank < found->chord)) {
        found->squared = least;
        found->chord = runs->first[run] + rank;
    }
}

/* Chords (n,) nearest to places (n, 2). The tree has boxes (2 * leaves, 4), the root's being the second; its leaves
   are the runs with points (runs, length + 1, 2), first chord and number of chords (runs,) and rectangles (runs, 6). */
KERNEL int64_t nearest_chords(int64_t n, const double *places, int64_t count, int64_t leaves, int64_t length,
                              const double *boxes, const double *points, const double *rectangles,
                              const int64_t *first, const int64_t *counts, double slack, int64_t *nearest)
{
    Runs runs = {points, rectangles, first, counts, length};
    int64_t k, last = 0;
    for (k = 0; k < n; k++) {
        double x = places[2 * k], y = places[2 * k + 1];
        Found found = {INFINITY, INT64_MAX};
        int64_t stack[DEPTH], depth = 0, node;
        look_at(&runs, last, x, y, &found); /* places mostly lie near to the one before */
        stack[depth++] = 1;
        while (depth > 0) {
            node = stack[--depth];
            if (from_box(boxes + 4 * node, x, y) > found.squared * slack)
                continue;
            if (node < leaves) {
                double left = from_box(boxes + 8 * node, x, y), right = from_box(boxes + 8 * node + 4, x, y);
                stack[depth++] = 2 * node + (left < right); /* the farther one waits below the nearer one */
                stack[depth++] = 2 * node + !(left < right);
            } else if (node - leaves < count) {
                int64_t run = node - leaves, before = found.chord;
                if (from_rectangle(rectangles + 6 * run, x, y) <= found.squared * slack)
                    look_at(&runs, run, x, y, &found);
                last = found.chord == before ? last : run;
            }
        }
        nearest[k] = found.chord;
    }
    return DONE;
}
