/* Pairs of points that are near for their spacings, by a tree of boxes; see pairs.py. */
#include <math.h>
#include <stdlib.h>

#include "kernels.h"

enum { LEAF = 8, DEPTH = 64 };

typedef struct {
    double low[2], high[2], coarsest; /* bounds of the points, and their largest spacing */
} Box;

typedef struct {
    int64_t node, first, last; /* number of a box, whose branches are 2 node and 2 node + 1, and rows of its points */
} Part;

typedef struct {
    const double *x, *d; /* (n, 2), (n,) */
    int64_t *order;      /* (n,) */
    Box *boxes;
} Tree;

/* Rows from first to before last, so that those from middle on are not below the others along an axis. */
static void halve(const Tree *tree, int64_t first, int64_t middle, int64_t last, int axis)
{
    int64_t *order = tree->order, low = first, high = last - 1;
    while (low < high) {
        double pivot = tree->x[2 * order[(low + high) / 2] + axis];
        int64_t i = low - 1, j = high + 1, spare;
        for (;;) {
            do
                i++;
            while (tree->x[2 * order[i] + axis] < pivot);
            do
                j--;
            while (tree->x[2 * order[j] + axis] > pivot);
            if (i >= j)
                break;
            spare = order[i], order[i] = order[j], order[j] = spare;
        }
        if (middle <= j)
            high = j;
        else
            low = j + 1;
    }
}

static void build(Tree *tree, Part part)
{
    Box *box = tree->boxes + part.node;
    int64_t k, middle = part.first + (part.last - part.first) / 2;
    int axis;
    Box whole = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}, 0.0};
    for (k = part.first; k < part.last; k++) {
        const double *at = tree->x + 2 * tree->order[k], mine = tree->d[tree->order[k]];
        for (axis = 0; axis < 2; axis++) {
            if (at[axis] < whole.low[axis])
                whole.low[axis] = at[axis];
            if (at[axis] > whole.high[axis])
                whole.high[axis] = at[axis];
        }
        if (mine > whole.coarsest)
            whole.coarsest = mine;
    }
    *box = whole;
    if (part.last - part.first > LEAF) {
        Part below = {2 * part.node, part.first, middle}, above = {2 * part.node + 1, middle, part.last};
        axis = whole.high[1] - whole.low[1] > whole.high[0] - whole.low[0];
        halve(tree, part.first, middle, part.last, axis);
        build(tree, below);
        build(tree, above);
    }
}

static double beyond(double low, double value, double high)
{
    double under = low - value, over = value - high, most = under > over ? under : over;
    return most > 0 ? most : 0;
}

/* Whether a box may hold a neighbour of a point. None is lost by rounding, which keeps the order of numbers. */
static int may_hold(const Box *box, const double *at, double d, double reach)
{
    double dx = beyond(box->low[0], at[0], box->high[0]), dy = beyond(box->low[1], at[1], box->high[1]);
    double most = reach * (d + box->coarsest) / 2;
    return dx * dx + dy * dy < most * most;
}

static int ascending(const void *one, const void *other)
{
    int64_t a = *(const int64_t *)one, b = *(const int64_t *)other;
    return (a > b) - (a < b);
}

/* Neighbours of point i with higher numbers, in order, as far as there is room for them; gives how many there are. */
static int64_t neighbours(const Tree *tree, int64_t n, int64_t i, double reach, int64_t *found, int64_t room)
{
    const double *at = tree->x + 2 * i;
    double d = tree->d[i];
    Part stack[DEPTH + 1], part = {1, 0, n};
    int64_t depth = 0, count = 0, k;
    stack[depth++] = part;
    while (depth > 0) {
        part = stack[--depth];
        if (!may_hold(tree->boxes + part.node, at, d, reach))
            continue;
        if (part.last - part.first > LEAF) {
            int64_t middle = part.first + (part.last - part.first) / 2;
            Part below = {2 * part.node, part.first, middle}, above = {2 * part.node + 1, middle, part.last};
            stack[depth++] = below;
            stack[depth++] = above;
            continue;
        }
        for (k = part.first; k < part.last; k++) {
            int64_t j = tree->order[k];
            double dx = at[0] - tree->x[2 * j], dy = at[1] - tree->x[2 * j + 1];
            double most = reach * (d + tree->d[j]) / 2;
            if (j > i && dx * dx + dy * dy < most * most) {
                if (count < room)
                    found[count] = j;
                count++;
            }
        }
    }
    qsort(found, (size_t)(count < room ? count : room), sizeof *found, ascending);
    return count;
}

/* Pairs (count, 2) of points x (n, 2) nearer than reach times the mean of their spacings d (n,), each with the lower
   number first, and in order. Where there are more than room, only their number in count (1,) is right. */
KERNEL int64_t pairs_within(int64_t n, const double *x, const double *d, double reach, int64_t room, int64_t *pairs,
                            int64_t *count)
{
    int64_t depth = 0, status = NO_MEMORY, i, k, most = n > 0 ? n : 1;
    Tree tree = {x, d, NULL, NULL};
    Part whole = {1, 0, n};
    int64_t *found = malloc((size_t)most * sizeof *found);
    while (((n - 1) >> depth) >= LEAF) /* parts of this depth may have more points than a leaf */
        depth++;
    tree.order = malloc((size_t)most * sizeof *tree.order);
    tree.boxes = malloc(((size_t)2 << depth) * sizeof *tree.boxes);
    if (!found || !tree.order || !tree.boxes)
        goto end;
    for (i = 0; i < n; i++)
        tree.order[i] = i;
    build(&tree, whole);
    *count = 0;
    for (i = 0; i < n; i++) {
        int64_t mine = neighbours(&tree, n, i, reach, found, n);
        for (k = 0; k < mine && *count + k < room; k++) {
            pairs[2 * (*count + k)] = i;
            pairs[2 * (*count + k) + 1] = found[k];
        }
        *count += mine;
    }
    status = DONE;
end:
    free(found);
    free(tree.order);
    free(tree.boxes);
    return status;
}
