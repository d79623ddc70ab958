/* Triangles with neighbours, and flips of edges that make them Delaunay; see linking.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "triangles.h"

enum { MOST_FLIPS = 20 };
enum { BLOCK = 64 }; /* triangles or edges that are tested side by side */

static const double SHORTEST = 1.0 / 16; /* step of nodes on their way, as a share of it */

/* Of determinants: J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
   Discrete Comput. Geom. 18 (1997), his bounds A. */
static const double TURN_ERROR = 3.3306690738754716e-16, CIRCLE_ERROR = 1.1102230246251577e-15;

static int32_t next_side(int32_t side)
{
    return side % 3 == 2 ? side - 2 : side + 1;
}

static int32_t side_before(int32_t side)
{
    return side % 3 == 0 ? side + 2 : side - 1;
}

int64_t take(Mesh *mesh, const int64_t *triangles, int in_order)
{
    int64_t k, t = mesh->t;
    if (mesh->n >= INT32_MAX || 3 * t >= INT32_MAX)
        return NO_MEMORY;
    mesh->nodes = malloc((size_t)(3 * t + 1) * sizeof *mesh->nodes);
    mesh->changed = malloc((size_t)(t + 1));
    if (!mesh->nodes || !mesh->changed)
        return NO_MEMORY;
    for (k = 0; k < 3 * t; k++)
        mesh->nodes[k] = (int32_t)triangles[k];
    memset(mesh->changed, !in_order, (size_t)t);
    return DONE;
}

void give_back(Mesh *mesh)
{
    free(mesh->nodes);
    free(mesh->twin);
    free(mesh->changed);
}

/* Of sides, those found so far: a node's list has one of each edge to a higher node. */
typedef struct {
    int32_t *begin; /* (n,): the first one of each node, or -1 */
    int32_t *after; /* (t, 3): the next one in the same list, or -1 */
} Lists;

/* The side in a list between two nodes, or -1. */
static int32_t known_side(const Mesh *mesh, const Lists *lists, int64_t low, int64_t high)
{
    int32_t side = lists->begin[low];
    while (side >= 0 && mesh->nodes[side] != high && mesh->nodes[next_side(side)] != high)
        side = lists->after[side];
    return side;
}

static int64_t sides_on_rim(const Mesh *mesh)
{
    int64_t side, count = 0;
    for (side = 0; side < 3 * mesh->t; side++)
        count += mesh->twin[side] < 0;
    return count;
}

/* Finds the twins of sides, of which those along facets (m, 2) then count as rim: they stay. The outcome is UNDECIDED if
   the rim is not of facets, or one of these is no side. */
static int64_t find_twins(Mesh *mesh, int64_t m, const int64_t *facets, int64_t *outcome)
{
    Lists lists = {malloc((size_t)(mesh->n + 1) * sizeof *lists.begin),
                   malloc((size_t)(3 * mesh->t + 1) * sizeof *lists.after)};
    int64_t k, rim, missing = 0, status = lists.begin && lists.after ? DONE : NO_MEMORY;
    int32_t side, other, sides = (int32_t)(3 * mesh->t);
    for (k = 0; k < mesh->n && status == DONE; k++)
        lists.begin[k] = -1;
    for (side = 0; side < sides && status == DONE; side++) {
        int32_t a = mesh->nodes[side], b = mesh->nodes[next_side(side)], low = a < b ? a : b;
        other = known_side(mesh, &lists, low, a < b ? b : a);
        mesh->twin[side] = other;
        if (other >= 0) {
            mesh->twin[other] = side;
        } else {
            lists.after[side] = lists.begin[low];
            lists.begin[low] = side;
        }
    }
    rim = status == DONE ? sides_on_rim(mesh) : 0;
    for (k = 0; k < m && status == DONE; k++) {
        int64_t a = facets[2 * k], b = facets[2 * k + 1];
        side = known_side(mesh, &lists, a < b ? a : b, a < b ? b : a);
        if (side < 0) {
            missing++;
        } else if (mesh->twin[side] < 0) {
            rim--;
        } else {
            mesh->twin[mesh->twin[side]] = -1;
            mesh->twin[side] = -1;
        }
    }
    *outcome = rim || missing ? UNDECIDED : DONE;
    free(lists.begin);
    free(lists.after);
    return status;
}

int64_t take_with_twins(Mesh *mesh, const int64_t *triangles, const int32_t *twins, int64_t m, const int64_t *facets,
                        int64_t *outcome)
{
    int64_t status = take(mesh, triangles, twins != NULL);
    mesh->twin = malloc((size_t)(3 * mesh->t + 1) * sizeof *mesh->twin);
    *outcome = DONE;
    if (!mesh->twin)
        status = NO_MEMORY;
    if (status == DONE && twins)
        memcpy(mesh->twin, twins, (size_t)(3 * mesh->t) * sizeof *mesh->twin);
    else if (status == DONE)
        status = find_twins(mesh, m, facets, outcome);
    return status;
}

/* 1 if d is in the circle through a, b and c for sure, -1 if it is outside, 0 if rounding decides. */
static int in_circle(const double *a, const double *b, const double *c, const double *d)
{
    double ax = a[0] - d[0], ay = a[1] - d[1], bx = b[0] - d[0], by = b[1] - d[1], cx = c[0] - d[0], cy = c[1] - d[1];
    double bc = bx * cy, cb = cx * by, ca = cx * ay, ac = ax * cy, ab = ax * by, ba = bx * ay;
    double over_a = ax * ax + ay * ay, over_b = bx * bx + by * by, over_c = cx * cx + cy * cy;
    double value = over_a * (bc - cb) + over_b * (ca - ac) + over_c * (ab - ba);
    double most = (fabs(bc) + fabs(cb)) * over_a + (fabs(ca) + fabs(ac)) * over_b + (fabs(ab) + fabs(ba)) * over_c;
    double error = CIRCLE_ERROR * most;
    return value > error ? 1 : value < -error ? -1 : 0;
}

typedef struct {
    int32_t *sides; /* a ring buffer */
    int64_t count, room, first;
    char *waiting;
} Queue;

static void ask(Queue *queue, int32_t side)
{
    int64_t place;
    if (queue->waiting[side])
        return;
    queue->waiting[side] = 1;
    place = queue->first + queue->count++;
    queue->sides[place < queue->room ? place : place - queue->room] = side;
}

static void join(Mesh *mesh, int32_t side, int32_t twin)
{
    mesh->twin[side] = twin;
    if (twin >= 0)
        mesh->twin[twin] = side;
}

/* The edge between two triangles becomes the one between their other nodes; their outer sides are asked again. */
static void flip(Mesh *mesh, Queue *queue, int32_t side)
{
    int32_t *nodes = mesh->nodes, across = mesh->twin[side], one = side - side % 3, two = across - across % 3;
    int32_t ahead = next_side(side), behind = side_before(side);
    int32_t ahead2 = next_side(across), behind2 = side_before(across);
    int32_t u = nodes[side], v = nodes[ahead], w = nodes[behind], w2 = nodes[behind2];
    int32_t outer[4] = {mesh->twin[ahead2], mesh->twin[behind], mesh->twin[behind2], mesh->twin[ahead]};
    int k;
    nodes[one] = u, nodes[one + 1] = w2, nodes[one + 2] = w;
    nodes[two] = w2, nodes[two + 1] = v, nodes[two + 2] = w;
    join(mesh, one, outer[0]), join(mesh, one + 2, outer[1]);
    join(mesh, two, outer[2]), join(mesh, two + 1, outer[3]);
    join(mesh, one + 1, two + 2);
    for (k = 0; k < 3; k++) {
        if (mesh->twin[one + k] >= 0)
            ask(queue, one + k);
        if (mesh->twin[two + k] >= 0)
            ask(queue, two + k);
    }
    mesh->changed[one / 3] = mesh->changed[two / 3] = 1;
}

/* Margins (BLOCK,) by which nodes at places (3, BLOCK, 2), those of a, b and c, turn to the left for sure, if positive. */
SIDE_BY_SIDE static void turn_margins(const double *places, double *margin)
{
    const double *a = places, *b = a + 2 * BLOCK, *c = b + 2 * BLOCK;
    int k;
    for (k = 0; k < BLOCK; k++) {
        double left = (a[2 * k] - c[2 * k]) * (b[2 * k + 1] - c[2 * k + 1]);
        double right = (a[2 * k + 1] - c[2 * k + 1]) * (b[2 * k] - c[2 * k]);
        margin[k] = (left - right) - TURN_ERROR * (fabs(left) + fabs(right));
    }
}

/* Margins (BLOCK,) by which d is outside of the circle through a, b and c for sure, if negative, at places (4, BLOCK, 2)
   as above: those of `in_circle`. */
SIDE_BY_SIDE static void circle_margins(const double *places, double *margin)
{
    const double *a = places, *b = a + 2 * BLOCK, *c = b + 2 * BLOCK, *d = c + 2 * BLOCK;
    int k;
    for (k = 0; k < BLOCK; k++) {
        double x = d[2 * k], y = d[2 * k + 1];
        double ax = a[2 * k] - x, ay = a[2 * k + 1] - y, bx = b[2 * k] - x, by = b[2 * k + 1] - y;
        double cx = c[2 * k] - x, cy = c[2 * k + 1] - y;
        double bc = bx * cy, cb = cx * by, ca = cx * ay, ac = ax * cy, ab = ax * by, ba = bx * ay;
        double over_a = ax * ax + ay * ay, over_b = bx * bx + by * by, over_c = cx * cx + cy * cy;
        double value = over_a * (bc - cb) + over_b * (ca - ac) + over_c * (ab - ba);
        double most =
            (fabs(bc) + fabs(cb)) * over_a + (fabs(ca) + fabs(ac)) * over_b + (fabs(ab) + fabs(ba)) * over_c;
        margin[k] = value + CIRCLE_ERROR * most;
    }
}

/* Puts the place of a node into a row of places (..., BLOCK, 2). */
static void put(double *places, int row, int64_t k, const double *x, int64_t node)
{
    places[2 * (row * BLOCK + k)] = x[2 * node];
    places[2 * (row * BLOCK + k) + 1] = x[2 * node + 1];
}

static int all_turn_left(const Mesh *mesh, const double *x)
{
    double places[6 * BLOCK] = {0}, margin[BLOCK];
    int64_t begin, k, t = mesh->t;
    int corner, all = 1;
    for (begin = 0; begin < t && all; begin += BLOCK) {
        int64_t count = t - begin < BLOCK ? t - begin : BLOCK;
        for (k = 0; k < count; k++)
            for (corner = 0; corner < 3; corner++)
                put(places, corner, k, x, mesh->nodes[3 * (begin + k) + corner]);
        turn_margins(places, margin);
        for (k = 0; k < count; k++)
            all &= margin[k] > 0;
    }
    return all;
}

/* Asks the sides whose edges are not surely Delaunay, one of the two of each. */
static void ask_first(const Mesh *mesh, const double *x, Queue *queue)
{
    double places[8 * BLOCK] = {0}, margin[BLOCK];
    int32_t sides[BLOCK], side = 0, all = (int32_t)(3 * mesh->t);
    while (side < all) {
        int64_t count = 0, k;
        int corner;
        for (; side < all && count < BLOCK; side++) {
            const int32_t *node = mesh->nodes + (side - side % 3);
            if (mesh->twin[side] <= side)
                continue;
            for (corner = 0; corner < 3; corner++)
                put(places, corner, count, x, node[corner]);
            put(places, 3, count, x, mesh->nodes[side_before(mesh->twin[side])]);
            sides[count++] = side;
        }
        circle_margins(places, margin);
        for (k = 0; k < count; k++)
            if (!(margin[k] < 0))
                ask(queue, sides[k]);
    }
}

/* Of the edge at a side with a triangle across, whether that one's other node is in this one's circle: as `in_circle`. */
static int crossed(const Mesh *mesh, const double *x, int32_t side)
{
    const int32_t *nodes = mesh->nodes, *node = nodes + (side - side % 3);
    int64_t other = nodes[side_before(mesh->twin[side])];
    return in_circle(x + 2 * (int64_t)node[0], x + 2 * (int64_t)node[1], x + 2 * (int64_t)node[2], x + 2 * other);
}

static int64_t lower(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* 1 if a, b and c turn to the left for sure. */
static int turn_left(const double *x, int64_t a, int64_t b, int64_t c)
{
    double left = (x[2 * a] - x[2 * c]) * (x[2 * b + 1] - x[2 * c + 1]);
    double right = (x[2 * a + 1] - x[2 * c + 1]) * (x[2 * b] - x[2 * c]);
    return (left - right) - TURN_ERROR * (fabs(left) + fabs(right)) > 0;
}

/* Of the edge at a side whose four nodes lie on a circle, as far as rounding tells: 1 if it has not the lowest node, as
   its flip has, 0 if it has, -1 if a triangle of the flip might be flat. */
static int lacks_lowest(const Mesh *mesh, const double *x, int32_t side)
{
    const int32_t *nodes = mesh->nodes;
    int64_t u = nodes[side], v = nodes[next_side(side)], w = nodes[side_before(side)];
    int64_t other = nodes[side_before(mesh->twin[side])];
    if (lower(u, v) < lower(w, other))
        return 0;
    return turn_left(x, u, other, w) && turn_left(x, other, v, w) ? 1 : -1;
}

/* Lawson's flips, until every edge between two triangles is locally Delaunay, but for facets. Where rounding
   decides, edges end with the lowest node around if all must be sure, else they stay. */
static int64_t legalise(Mesh *mesh, const double *x, Queue *queue, int sure)
{
    int64_t left = MOST_FLIPS * mesh->t;
    ask_first(mesh, x, queue);
    while (queue->count > 0) {
        int32_t side = queue->sides[queue->first];
        int inside;
        queue->first = queue->first + 1 < queue->room ? queue->first + 1 : 0;
        queue->count--;
        queue->waiting[side] = 0;
        if (mesh->twin[side] < 0) /* since another flip has turned its triangle */
            continue;
        inside = crossed(mesh, x, side);
        if (inside == 0 && sure && (inside = lacks_lowest(mesh, x, side)) < 0)
            return UNDECIDED;
        if (inside > 0 && left-- == 0)
            return UNDECIDED;
        if (inside > 0)
            flip(mesh, queue, side);
    }
    return DONE;
}

/* Flips while the nodes go from start (n, 2) to x (n, 2), with a halt wherever a longer step would invert a triangle;
   places (n, 2) are for work. */
static int64_t flip_on_the_way(Mesh *mesh, const double *start, const double *x, double *places, Queue *queue)
{
    double done = 0, step = 1;
    int64_t k;
    for (;;) {
        int last = done + step >= 1;
        for (k = 0; k < 2 * mesh->n && !last; k++)
            places[k] = start[k] + (done + step) * (x[k] - start[k]);
        if (!all_turn_left(mesh, last ? x : places)) {
            step /= 2;
            if (step < SHORTEST)
                return UNDECIDED;
            continue;
        }
        if (legalise(mesh, last ? x : places, queue, last) != DONE)
            return UNDECIDED;
        if (last)
            return DONE;
        done += step;
        step = 1 - done;
    }
}

int64_t flip_all(Mesh *mesh, const double *start, const double *x, int64_t *outcome)
{
    Queue queue = {NULL, 0, 3 * mesh->t + 1, 0, NULL};
    double *places = malloc((size_t)(2 * mesh->n + 1) * sizeof *places);
    int64_t status = NO_MEMORY;
    queue.sides = malloc((size_t)queue.room * sizeof *queue.sides);
    queue.waiting = calloc((size_t)queue.room, 1);
    if (places && queue.sides && queue.waiting) {
        *outcome = flip_on_the_way(mesh, start, x, places, &queue);
        status = DONE;
    }
    free(places);
    free(queue.sides);
    free(queue.waiting);
    return status;
}
