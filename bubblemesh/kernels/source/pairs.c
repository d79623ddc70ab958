/* Pairs of points that are near for their spacings, by a tree of boxes; see pairs.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

enum { LEAF = 12, DEPTH = 64, FEW = 24 };

typedef struct {
    double low[2], high[2], coarsest; /* bounds of the points, and their largest spacing */
} Box;

typedef struct {
    int64_t node, first, last; /* number of a box, whose branches are 2 node and 2 node + 1, and rows of its points */
} Part;

static int is_leaf(Part part)
{
    return part.last - part.first <= LEAF;
}

static int64_t middle_of(Part part)
{
    return part.first + (part.last - part.first) / 2;
}

static Part lower(Part part)
{
    Part below = {2 * part.node, part.first, middle_of(part)};
    return below;
}

static Part upper(Part part)
{
    Part above = {2 * part.node + 1, middle_of(part), part.last};
    return above;
}

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
    int64_t k;
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
    if (!is_leaf(part)) {
        axis = whole.high[1] - whole.low[1] > whole.high[0] - whole.low[0];
        halve(tree, part.first, middle_of(part), part.last, axis);
        build(tree, lower(part));
        build(tree, upper(part));
    }
}

static double between(double low, double high, double other_low, double other_high)
{
    double under = low - other_high, over = other_low - high, most = under > over ? under : over;
    return most > 0 ? most : 0;
}

/* Whether points of two boxes may be neighbours. None are lost by rounding, which keeps the order of numbers. */
static int may_be_near(const Box *one, const Box *other, double reach)
{
    double dx = between(one->low[0], one->high[0], other->low[0], other->high[0]);
    double dy = between(one->low[1], one->high[1], other->low[1], other->high[1]);
    double most = reach * (one->coarsest + other->coarsest) / 2;
    return dx * dx + dy * dy < most * most;
}

typedef struct {
    int64_t room, count, *members; /* (room, 2), of which count are filled, or would be */
} Pairs;

/* Pairs of two leaves, or of one leaf with itself. */
static void pair_up(const Tree *tree, Part one, Part other, double reach, Pairs *pairs)
{
    int64_t k, m;
    for (k = one.first; k < one.last; k++) {
        int64_t i = tree->order[k];
        double x = tree->x[2 * i], y = tree->x[2 * i + 1], d = tree->d[i];
        for (m = one.first == other.first ? k + 1 : other.first; m < other.last; m++) {
            int64_t j = tree->order[m];
            double dx = x - tree->x[2 * j], dy = y - tree->x[2 * j + 1], most = reach * (d + tree->d[j]) / 2;
            if (dx * dx + dy * dy < most * most) {
                if (pairs->count < pairs->room) {
                    pairs->members[2 * pairs->count] = i < j ? i : j;
                    pairs->members[2 * pairs->count + 1] = i < j ? j : i;
                }
                pairs->count++;
            }
        }
    }
}

/* Pairs of a leaf's points with each other and with those of the leaves behind it. */
static void pairs_of_leaf(const Tree *tree, int64_t n, Part leaf, double reach, Pairs *pairs)
{
    Part stack[DEPTH + 1], part = {1, 0, n};
    int64_t depth = 0;
    stack[depth++] = part;
    while (depth > 0) {
        part = stack[--depth];
        if (part.last <= leaf.first || !may_be_near(tree->boxes + leaf.node, tree->boxes + part.node, reach))
            continue;
        if (is_leaf(part)) {
            pair_up(tree, leaf, part, reach, pairs);
        } else {
            stack[depth++] = lower(part);
            stack[depth++] = upper(part);
        }
    }
}

static void pairs_of_part(const Tree *tree, int64_t n, Part part, double reach, Pairs *pairs)
{
    if (is_leaf(part)) {
        pairs_of_leaf(tree, n, part, reach, pairs);
    } else {
        pairs_of_part(tree, n, lower(part), reach, pairs);
        pairs_of_part(tree, n, upper(part), reach, pairs);
    }
}

static int ascending(const void *one, const void *other)
{
    int64_t a = *(const int64_t *)one, b = *(const int64_t *)other;
    return (a > b) - (a < b);
}

static void sort(int64_t *numbers, int64_t count)
{
    int64_t k;
    if (count > FEW) {
        qsort(numbers, (size_t)count, sizeof *numbers, ascending);
        return;
    }
    for (k = 1; k < count; k++) {
        int64_t number = numbers[k], place = k;
        for (; place > 0 && numbers[place - 1] > number; place--)
            numbers[place] = numbers[place - 1];
        numbers[place] = number;
    }
}

/* Writes pairs of points below n in order; ends (n + 1,) and seconds (pairs,) are for work. */
static void put_in_order(int64_t n, const Pairs *pairs, int64_t *ends, int64_t *seconds, int64_t *ordered)
{
    int64_t i, k, begin = 0, sum = 0;
    memset(ends, 0, (size_t)(n + 1) * sizeof *ends);
    for (k = 0; k < pairs->count; k++)
        ends[pairs->members[2 * k]]++;
    for (i = 0; i <= n; i++) {
        int64_t mine = ends[i];
        ends[i] = sum;
        sum += mine;
    }
    for (k = 0; k < pairs->count; k++)
        seconds[ends[pairs->members[2 * k]]++] = pairs->members[2 * k + 1];
    for (i = 0; i < n; begin = ends[i++]) {
        sort(seconds + begin, ends[i] - begin);
        for (k = begin; k < ends[i]; k++) {
            ordered[2 * k] = i;
            ordered[2 * k + 1] = seconds[k];
        }
    }
}

/* Pairs (count, 2) of points x (n, 2) nearer than reach times the mean of their spacings d (n,), each with the lower
   number first, and in order. Where there are more than room, only their number in count (1,) is right. */
KERNEL int64_t pairs_within(int64_t n, const double *x, const double *d, double reach, int64_t room, int64_t *ordered,
                            int64_t *count)
{
    int64_t depth = 0, status = NO_MEMORY, k;
    size_t many = (size_t)room + 1, most = (size_t)n + 1;
    Tree tree = {x, d, NULL, NULL};
    Pairs pairs = {room, 0, NULL};
    Part whole = {1, 0, n};
    int64_t *ends = malloc(most * sizeof *ends), *seconds = malloc(many * sizeof *seconds);
    while (((n - 1) >> depth) >= LEAF) /* parts of this depth may have more points than a leaf */
        depth++;
    tree.order = malloc(most * sizeof *tree.order);
    tree.boxes = malloc(((size_t)2 << depth) * sizeof *tree.boxes);
    pairs.members = malloc(2 * many * sizeof *pairs.members);
    if (!ends || !seconds || !tree.order || !tree.boxes || !pairs.members)
        goto end;
    for (k = 0; k < n; k++)
        tree.order[k] = k;
    build(&tree, whole);
    pairs_of_part(&tree, n, whole, reach, &pairs);
    *count = pairs.count;
    if (pairs.count <= room)
        put_in_order(n, &pairs, ends, seconds, ordered);
    status = DONE;
end:
    free(ends);
    free(seconds);
    free(tree.order);
    free(tree.boxes);
    free(pairs.members);
    return status;
}
