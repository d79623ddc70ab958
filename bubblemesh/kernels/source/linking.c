/* Triangles and their edges in an order of their own, and flips of edges that make them Delaunay; see linking.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

enum { UNDECIDED = 1, MOST_FLIPS = 20 };

static const double SHORTEST = 1.0 / 16; /* step of nodes on their way, as a share of it */

/* Of determinants: J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
   Discrete Comput. Geom. 18 (1997), his bounds A. */
static const double TURN_ERROR = 3.3306690738754716e-16, CIRCLE_ERROR = 1.1102230246251577e-15;

/* Side k of a triangle goes from its node k to the next; sides are numbered 3 * triangle + k. */
static int64_t next_side(int64_t side)
{
    return side % 3 == 2 ? side - 2 : side + 1;
}

typedef struct {
    int32_t low, high, value; /* nodes */
} Item;

/* Sorts items (count,) by their low, which are below n, then by high: those of the same low are few. */
static void sorted(int64_t n, int64_t count, Item *items, Item *spare, int64_t *start)
{
    int64_t k, sum = 0;
    memset(start, 0, (size_t)(n + 1) * sizeof *start);
    for (k = 0; k < count; k++)
        start[items[k].low]++;
    for (k = 0; k <= n; k++) {
        int64_t mine = start[k];
        start[k] = sum;
        sum += mine;
    }
    for (k = 0; k < count; k++)
        spare[start[items[k].low]++] = items[k];
    for (k = 0; k < count; k++) {
        Item item = spare[k];
        int64_t place = k;
        while (place > 0 && items[place - 1].low == item.low && items[place - 1].high > item.high) {
            items[place] = items[place - 1];
            place--;
        }
        items[place] = item;
    }
}

typedef struct {
    int64_t n, t, *triangles; /* (t, 3) */
    int32_t *twin;            /* (t, 3): the same edge's side in the triangle across, -1 on the rim; NULL if not known */
    int32_t *after;           /* (t, 3): next side in a list of those at the same node */
    Item *items, *spare;      /* as many as there are edges, and no fewer than triangles */
    int64_t *start;           /* (n + 1,): where a node's items, or its list, begins */
} Mesh;

/* Triangles begin with their lowest node and ascend; edges (count, 2) with the lower node first ascend. Where twins are
   known each edge is taken of one of its sides only. */
static int64_t in_order(Mesh *mesh, int64_t *edges)
{
    int64_t k, side, sides = 0, count = 0, *triangles = mesh->triangles;
    for (side = 0; side < 3 * mesh->t; side++)
        if (!mesh->twin || mesh->twin[side] < side) {
            int64_t a = triangles[side], b = triangles[next_side(side)];
            Item item = {(int32_t)(a < b ? a : b), (int32_t)(a < b ? b : a), 0};
            mesh->items[sides++] = item;
        }
    sorted(mesh->n, sides, mesh->items, mesh->spare, mesh->start);
    for (k = 0; k < sides; k++)
        if (k == 0 || mesh->items[k].low != mesh->items[k - 1].low || mesh->items[k].high != mesh->items[k - 1].high) {
            edges[2 * count] = mesh->items[k].low;
            edges[2 * count++ + 1] = mesh->items[k].high;
        }
    for (k = 0; k < mesh->t; k++) {
        int32_t a = (int32_t)triangles[3 * k], b = (int32_t)triangles[3 * k + 1], c = (int32_t)triangles[3 * k + 2];
        Item item = {a, b, c};
        if (b < a && b < c)
            item.low = b, item.high = c, item.value = a;
        else if (c < a && c < b)
            item.low = c, item.high = a, item.value = b;
        mesh->items[k] = item;
    }
    sorted(mesh->n, mesh->t, mesh->items, mesh->spare, mesh->start);
    for (k = 0; k < mesh->t; k++) {
        triangles[3 * k] = mesh->items[k].low;
        triangles[3 * k + 1] = mesh->items[k].high;
        triangles[3 * k + 2] = mesh->items[k].value;
    }
    return count;
}

/* First side known so far of the edge between two nodes, or -1: a node's list has sides of the edges to higher ones. */
static int64_t known_side(const Mesh *mesh, int64_t low, int64_t high)
{
    int64_t side = mesh->start[low];
    while (side >= 0 && mesh->triangles[side] != high && mesh->triangles[next_side(side)] != high)
        side = mesh->after[side];
    return side;
}

static void find_twins(Mesh *mesh)
{
    int64_t k, side, other;
    for (k = 0; k < mesh->n; k++)
        mesh->start[k] = -1;
    for (side = 0; side < 3 * mesh->t; side++) {
        int64_t a = mesh->triangles[side], b = mesh->triangles[next_side(side)], low = a < b ? a : b;
        other = known_side(mesh, low, a < b ? b : a);
        mesh->twin[side] = (int32_t)other;
        if (other >= 0) {
            mesh->twin[other] = (int32_t)side;
        } else {
            mesh->after[side] = (int32_t)mesh->start[low];
            mesh->start[low] = side;
        }
    }
}

/* Marks sides (t, 3) on facets (m, 2), which stay; the lists still are those of `find_twins`. */
static void fix(const Mesh *mesh, int64_t m, const int64_t *facets, char *fixed)
{
    int64_t k;
    for (k = 0; k < m; k++) {
        int64_t a = facets[2 * k], b = facets[2 * k + 1], side = known_side(mesh, a < b ? a : b, a < b ? b : a);
        if (side >= 0) {
            fixed[side] = 1;
            if (mesh->twin[side] >= 0)
                fixed[mesh->twin[side]] = 1;
        }
    }
}

/* 1 if the nodes turn to the left for sure, else 0. */
static int turns_left(const double *a, const double *b, const double *c)
{
    double left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]);
    return left - right > TURN_ERROR * (fabs(left) + fabs(right));
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

static void ask(Queue *queue, int64_t side)
{
    int64_t place;
    if (queue->waiting[side])
        return;
    queue->waiting[side] = 1;
    place = queue->first + queue->count++;
    queue->sides[place < queue->room ? place : place - queue->room] = (int32_t)side;
}

static void join(Mesh *mesh, int64_t side, int64_t twin)
{
    mesh->twin[side] = (int32_t)twin;
    if (twin >= 0)
        mesh->twin[twin] = (int32_t)side;
}

/* The edge between two triangles becomes the one between their other nodes; their outer sides are asked again. */
static void flip(Mesh *mesh, char *fixed, Queue *queue, int64_t side)
{
    int64_t *triangles = mesh->triangles, across = mesh->twin[side];
    int64_t one = side - side % 3, two = across - across % 3, k;
    int64_t ahead = next_side(side), behind = next_side(ahead), ahead2 = next_side(across), behind2 = next_side(ahead2);
    int64_t u = triangles[side], v = triangles[ahead], w = triangles[behind], w2 = triangles[behind2];
    int64_t outer[4] = {mesh->twin[ahead2], mesh->twin[behind], mesh->twin[behind2], mesh->twin[ahead]};
    char held[4] = {fixed[ahead2], fixed[behind], fixed[behind2], fixed[ahead]};
    triangles[one] = u, triangles[one + 1] = w2, triangles[one + 2] = w;
    triangles[two] = w2, triangles[two + 1] = v, triangles[two + 2] = w;
    join(mesh, one, outer[0]), join(mesh, one + 2, outer[1]);
    join(mesh, two, outer[2]), join(mesh, two + 1, outer[3]);
    join(mesh, one + 1, two + 2);
    fixed[one] = held[0], fixed[one + 2] = held[1], fixed[two] = held[2], fixed[two + 1] = held[3];
    fixed[one + 1] = fixed[two + 2] = 0;
    for (k = 0; k < 3; k++) {
        if (mesh->twin[one + k] >= 0 && !fixed[one + k])
            ask(queue, one + k);
        if (mesh->twin[two + k] >= 0 && !fixed[two + k])
            ask(queue, two + k);
    }
}

static int all_turn_left(const Mesh *mesh, const double *x)
{
    const int64_t *triangles = mesh->triangles;
    int64_t k;
    for (k = 0; k < mesh->t; k++)
        if (!turns_left(x + 2 * triangles[3 * k], x + 2 * triangles[3 * k + 1], x + 2 * triangles[3 * k + 2]))
            return 0;
    return 1;
}

/* Of the edge at a side with a triangle across, whether that one's other node is in this one's circle: as `in_circle`. */
static int crossed(const Mesh *mesh, const double *x, int64_t side)
{
    const int64_t *triangles = mesh->triangles;
    int64_t ahead = next_side(side), other = next_side(next_side(mesh->twin[side]));
    return in_circle(x + 2 * triangles[side], x + 2 * triangles[ahead], x + 2 * triangles[next_side(ahead)],
                     x + 2 * triangles[other]);
}

/* Lawson's flips, until every edge between two triangles is locally Delaunay, but for fixed sides. Where rounding
   decides, that is the end if all must be sure, else the edge stays. */
static int64_t legalise(Mesh *mesh, const double *x, char *fixed, Queue *queue, int sure)
{
    int64_t side, left = MOST_FLIPS * mesh->t;
    for (side = 0; side < 3 * mesh->t; side++)
        if (mesh->twin[side] > side && !fixed[side] && crossed(mesh, x, side) >= 0)
            ask(queue, side);
    while (queue->count > 0) {
        int inside;
        side = queue->sides[queue->first];
        queue->first = queue->first + 1 < queue->room ? queue->first + 1 : 0;
        queue->count--;
        queue->waiting[side] = 0;
        if (mesh->twin[side] < 0 || fixed[side]) /* since another flip has turned its triangle */
            continue;
        inside = crossed(mesh, x, side);
        if ((inside == 0 && sure) || (inside > 0 && left-- == 0))
            return UNDECIDED;
        if (inside > 0)
            flip(mesh, fixed, queue, side);
    }
    return DONE;
}

/* Flips while the nodes go from start (n, 2) to x (n, 2), with a halt wherever a longer step would invert a triangle;
   places (n, 2) are for work. */
static int64_t flip_on_the_way(Mesh *mesh, const double *start, const double *x, double *places, char *fixed,
                               Queue *queue)
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
        if (legalise(mesh, last ? x : places, fixed, queue, last) != DONE)
            return UNDECIDED;
        if (last)
            return DONE;
        done += step;
        step = 1 - done;
    }
}

/* The quads (count, 4) of two triangles each that the flips may turn: the ends of their edge, and their other nodes. */
static int64_t list_quads(const Mesh *mesh, const char *fixed, int32_t *quads)
{
    const int64_t *triangles = mesh->triangles;
    int64_t side, count = 0;
    for (side = 0; side < 3 * mesh->t; side++)
        if (mesh->twin[side] > side && mesh->twin[mesh->twin[side]] == side && !fixed[side]) {
            int64_t ahead = next_side(side);
            int32_t *quad = quads + 4 * count++;
            quad[0] = (int32_t)triangles[side];
            quad[1] = (int32_t)triangles[ahead];
            quad[2] = (int32_t)triangles[next_side(ahead)];
            quad[3] = (int32_t)triangles[next_side(next_side(mesh->twin[side]))];
        }
    return count;
}

/* Says in outcome (1,) whether triangles (t, 3) need no flips for nodes x (n, 2): 0 if all turn left and all quads
   (count, 4) of them are Delaunay for sure, else 1. */
KERNEL int64_t check_quads(int64_t t, const int64_t *triangles, int64_t count, const int32_t *quads, const double *x,
                           int64_t *outcome)
{
    int64_t k;
    *outcome = UNDECIDED;
    for (k = 0; k < t; k++, triangles += 3)
        if (!turns_left(x + 2 * triangles[0], x + 2 * triangles[1], x + 2 * triangles[2]))
            return DONE;
    for (k = 0; k < count; k++, quads += 4)
        if (in_circle(x + 2 * quads[0], x + 2 * quads[1], x + 2 * quads[2], x + 2 * quads[3]) >= 0)
            return DONE;
    *outcome = DONE;
    return DONE;
}

/* Flips that make triangles Delaunay at x (n, 2) within facets (m, 2), as `link_triangles`; what takes memory only
   meanwhile goes again, but the twins. */
static int64_t flipped(Mesh *mesh, const double *start, const double *x, int64_t m, const int64_t *facets,
                       int32_t *quads, int64_t *count, int64_t *outcome)
{
    Queue queue = {NULL, 0, 3 * mesh->t + 1, 0, NULL};
    char *fixed = calloc((size_t)queue.room, 1);
    double *places = malloc((size_t)(2 * mesh->n + 1) * sizeof *places);
    int64_t status = NO_MEMORY;
    mesh->twin = malloc((size_t)queue.room * sizeof *mesh->twin);
    mesh->after = malloc((size_t)queue.room * sizeof *mesh->after);
    queue.sides = malloc((size_t)queue.room * sizeof *queue.sides);
    queue.waiting = calloc((size_t)queue.room, 1);
    if (fixed && places && mesh->twin && mesh->after && queue.sides && queue.waiting) {
        find_twins(mesh);
        fix(mesh, m, facets, fixed);
        *outcome = flip_on_the_way(mesh, start, x, places, fixed, &queue);
        if (*outcome == DONE)
            *count = list_quads(mesh, fixed, quads);
        status = DONE;
    }
    free(fixed);
    free(places);
    free(mesh->after);
    free(queue.sides);
    free(queue.waiting);
    return status;
}

/* Puts triangles (t, 3) of n nodes in order, and their edges into edges (3 t, 2), with their number in counts (2,); if
   flips are wanted, after those that make them Delaunay at x (n, 2) within facets (m, 2), as the nodes come there from
   start (n, 2), and with what more flips could turn in quads (3 t / 2, 4). Where rounding decides, or triangles are
   inverted, nothing is sure: then outcome (1,) is 1, else 0. */
KERNEL int64_t link_triangles(int64_t n, int64_t t, int64_t *triangles, int64_t flips, const double *start,
                              const double *x, int64_t m, const int64_t *facets, int64_t *edges, int32_t *quads,
                              int64_t *counts, int64_t *outcome)
{
    Mesh mesh = {n, t, triangles, NULL, NULL, NULL, NULL, NULL};
    int64_t status = n < INT32_MAX && 3 * t < INT32_MAX ? DONE : NO_MEMORY, side, most = 0;
    *outcome = DONE;
    mesh.start = malloc((size_t)(n + 1) * sizeof *mesh.start);
    if (!mesh.start)
        status = NO_MEMORY;
    if (status == DONE && flips)
        status = flipped(&mesh, start, x, m, facets, quads, counts + 1, outcome);
    if (status == DONE && *outcome == DONE) {
        for (side = 0; side < 3 * t; side++)
            most += !mesh.twin || mesh.twin[side] < side;
        most = most < t ? t : most;
        mesh.items = malloc((size_t)(most + 1) * sizeof *mesh.items);
        mesh.spare = malloc((size_t)(most + 1) * sizeof *mesh.spare);
        if (mesh.items && mesh.spare)
            counts[0] = in_order(&mesh, edges);
        else
            status = NO_MEMORY;
    }
    free(mesh.twin);
    free(mesh.items);
    free(mesh.spare);
    free(mesh.start);
    return status;
}
