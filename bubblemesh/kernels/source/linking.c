/* Triangles and their edges in an order of their own, and flips of edges that make them Delaunay; see linking.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

enum { UNDECIDED = 1, UNCHANGED = 2, MOST_FLIPS = 20 };
enum { BLOCK = 64 }; /* triangles or edges that are tested side by side */

static const double SHORTEST = 1.0 / 16; /* step of nodes on their way, as a share of it */

/* Of determinants: J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
   Discrete Comput. Geom. 18 (1997), his bounds A. */
static const double TURN_ERROR = 3.3306690738754716e-16, CIRCLE_ERROR = 1.1102230246251577e-15;

/* Side k of a triangle goes from its node k to the next; sides are numbered 3 * triangle + k. */
typedef struct {
    int64_t n, t;
    int32_t *nodes; /* (t, 3) */
    int32_t *twin;  /* (t, 3): the same edge's side in the triangle across, -1 on the rim and on facets; NULL if unknown */
    char *changed;  /* (t,): triangles that are not in order: all of them, or those that flips have changed */
} Mesh;

static int32_t next_side(int32_t side)
{
    return side % 3 == 2 ? side - 2 : side + 1;
}

static int32_t side_before(int32_t side)
{
    return side % 3 == 0 ? side + 2 : side - 1;
}

/* Takes triangles (t, 3), if they are few enough to number their sides. */
static int64_t take(Mesh *mesh, const int64_t *triangles, int in_order)
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

static void give_back(Mesh *mesh)
{
    free(mesh->nodes);
    free(mesh->twin);
    free(mesh->changed);
}

typedef struct {
    int32_t low, high, value;
} Item;

typedef struct {
    Item *items, *spare;
    int64_t *start; /* (n + 1,) */
} Sorting;

/* Sorts items (count,) by their low, which are below n, then by high: those of the same low are few. */
static void sort(const Sorting *sorting, int64_t n, int64_t count)
{
    Item *items = sorting->items, *spare = sorting->spare;
    int64_t k, sum = 0, *start = sorting->start;
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

/* Triangles (t, 3) and edges (m, 2) in order, as they were before some triangles changed; NULL if none were. */
typedef struct {
    const int64_t *triangles, *edges;
    int64_t m;
} Known;

static Item edge(int64_t a, int64_t b)
{
    Item item = {(int32_t)(a < b ? a : b), (int32_t)(a < b ? b : a), 0};
    return item;
}

/* Ascends with the low, then with the high: neither is negative. */
static uint64_t key(int64_t low, int64_t high)
{
    return (uint64_t)low << 32 | (uint64_t)high;
}

static const uint64_t LAST = UINT64_MAX; /* after all keys */

static uint64_t key_of(const Sorting *sorting, int64_t place, int64_t count)
{
    return place < count ? key(sorting->items[place].low, sorting->items[place].high) : LAST;
}

/* Edges that changed triangles had before they changed, in order; how many. */
static int64_t sort_former_edges(const Mesh *mesh, const Known *known, const Sorting *sorting)
{
    int64_t k, count = 0;
    for (k = 0; k < mesh->t && known->triangles; k++)
        if (mesh->changed[k]) {
            const int64_t *node = known->triangles + 3 * k;
            sorting->items[count++] = edge(node[0], node[1]);
            sorting->items[count++] = edge(node[1], node[2]);
            sorting->items[count++] = edge(node[2], node[0]);
        }
    sort(sorting, mesh->n, count);
    return count;
}

/* Whether an edge of a changed triangle is listed by this side of it, and not by its twin. */
static int is_listed(const Mesh *mesh, int64_t side)
{
    int64_t twin = mesh->twin ? mesh->twin[side] : -1;
    return twin < side || !mesh->changed[twin / 3];
}

/* Edges of changed triangles, in order, those between two of them once if twins are known; how many. */
static int64_t sort_new_edges(const Mesh *mesh, const Sorting *sorting)
{
    int64_t k, count = 0;
    int j;
    for (k = 0; k < mesh->t; k++)
        for (j = 0; j < 3 && mesh->changed[k]; j++)
            if (is_listed(mesh, 3 * k + j)) {
                const int32_t *node = mesh->nodes + 3 * k;
                sorting->items[count++] = edge(node[j], node[j == 2 ? 0 : j + 1]);
            }
    sort(sorting, mesh->n, count);
    return count;
}

/* Edges (count, 2) with the lower node first, ascending: those known but for former ones of changed triangles, and new
   ones. No more than 3 t are listed. */
static int64_t list_edges(const Mesh *mesh, const Known *known, const Sorting *former, const Sorting *new_ones,
                          int64_t *edges)
{
    int64_t old = 0, gone = 0, come = 0, count = 0, most = 3 * mesh->t;
    int64_t all_gone = sort_former_edges(mesh, known, former), all_come = sort_new_edges(mesh, new_ones);
    uint64_t leaves = key_of(former, 0, all_gone), comes = key_of(new_ones, 0, all_come), last = LAST;
    for (;;) {
        uint64_t next = leaves < comes ? leaves : comes, mine = LAST;
        while (old < known->m && count < most &&
               (mine = key(known->edges[2 * old], known->edges[2 * old + 1])) < next) {
            edges[2 * count] = known->edges[2 * old];
            edges[2 * count++ + 1] = known->edges[2 * old++ + 1];
            last = mine;
        }
        if (next == LAST || count >= most)
            return count;
        if (old < known->m && mine == next) /* it leaves, or comes where it is already */
            old++;
        if (leaves == next)
            do
                leaves = key_of(former, ++gone, all_gone);
            while (leaves == next);
        if (comes == next) {
            if (last != next) {
                edges[2 * count] = new_ones->items[come].low;
                edges[2 * count++ + 1] = new_ones->items[come].high;
                last = next;
            }
            comes = key_of(new_ones, ++come, all_come);
        }
    }
}

/* Which of its nodes a triangle begins with in order: the lowest, if they differ. */
static int first_of(const int32_t *node)
{
    return node[1] < node[0] && node[1] < node[2] ? 1 : node[2] < node[0] && node[2] < node[1] ? 2 : 0;
}

/* Triangles (t, 3) that begin with their lowest node and ascend, and their twins (t, 3) if these are known; in side
   (3 t,) comes where each side is then. */
static void list_triangles(const Mesh *mesh, const Sorting *sorting, int32_t *side, int64_t *triangles, int32_t *twins)
{
    const int32_t *nodes = mesh->nodes;
    int64_t k, t = mesh->t, old = 0, come = 0, all_come = 0;
    for (k = 0; k < t; k++)
        if (mesh->changed[k]) {
            int first = first_of(nodes + 3 * k);
            Item item = {nodes[3 * k + first], nodes[3 * k + (first + 1) % 3], (int32_t)k};
            sorting->items[all_come++] = item;
        }
    sort(sorting, mesh->n, all_come);
    for (k = 0; k < t; k++) {
        int64_t next, from;
        int first = 0, second, third;
        while (old < t && mesh->changed[old])
            old++;
        if (old == t || key_of(sorting, come, all_come) < key(nodes[3 * old], nodes[3 * old + 1])) {
            next = sorting->items[come++].value;
            first = first_of(nodes + 3 * next);
        } else {
            next = old++;
        }
        second = first == 2 ? 0 : first + 1, third = first == 0 ? 2 : first - 1;
        from = 3 * next;
        triangles[3 * k] = nodes[from + first];
        triangles[3 * k + 1] = nodes[from + second];
        triangles[3 * k + 2] = nodes[from + third];
        side[from + first] = (int32_t)(3 * k);
        side[from + second] = (int32_t)(3 * k + 1);
        side[from + third] = (int32_t)(3 * k + 2);
    }
    for (k = 0; k < 3 * t && twins; k++)
        twins[side[k]] = mesh->twin[k] < 0 ? -1 : side[mesh->twin[k]];
}

/* Puts triangles (t, 3) in order, with their twins (t, 3) if these are known, and their edges into edges (3 t, 2), whose
   number goes into count (1,). */
static int64_t put_in_order(const Mesh *mesh, const Known *known, int64_t *triangles, int32_t *twins, int64_t *edges,
                            int64_t *count)
{
    int64_t k, changed = 0, listed = 0, most, status = NO_MEMORY;
    Sorting former = {NULL, NULL, NULL}, sorting = {NULL, NULL, NULL};
    int32_t *side = malloc((size_t)(3 * mesh->t + 1) * sizeof *side);
    for (k = 0; k < mesh->t; k++)
        if (mesh->changed[k]) {
            changed++;
            listed += is_listed(mesh, 3 * k) + is_listed(mesh, 3 * k + 1) + is_listed(mesh, 3 * k + 2);
        }
    most = known->triangles ? 3 * changed : listed > changed ? listed : changed;
    sorting.items = malloc((size_t)(most + 1) * sizeof *sorting.items);
    sorting.spare = malloc((size_t)(most + 1) * sizeof *sorting.spare);
    sorting.start = malloc((size_t)(mesh->n + 1) * sizeof *sorting.start);
    former = sorting;
    former.items = malloc((size_t)(known->triangles ? most + 1 : 1) * sizeof *former.items);
    if (side && sorting.items && sorting.spare && sorting.start && former.items) {
        *count = list_edges(mesh, known, &former, &sorting, edges);
        list_triangles(mesh, &sorting, side, triangles, twins);
        status = DONE;
    }
    free(side);
    free(sorting.items);
    free(sorting.spare);
    free(sorting.start);
    free(former.items);
    return status;
}

/* Puts triangles (t, 3) of n nodes in order, and their edges into edges (3 t, 2), whose number goes into count (1,). */
KERNEL int64_t order_triangles(int64_t n, int64_t t, const int64_t *triangles, int64_t *ordered, int64_t *edges,
                               int64_t *count)
{
    const Known nothing = {NULL, NULL, 0};
    Mesh mesh = {n, t, NULL, NULL, NULL};
    int64_t status = take(&mesh, triangles, 0);
    if (status == DONE)
        status = put_in_order(&mesh, &nothing, ordered, NULL, edges, count);
    give_back(&mesh);
    return status;
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

/* Finds the twins of sides, of which those along facets (m, 2) then count as rim: they stay. */
static int64_t find_twins(Mesh *mesh, int64_t m, const int64_t *facets)
{
    Lists lists = {malloc((size_t)(mesh->n + 1) * sizeof *lists.begin),
                   malloc((size_t)(3 * mesh->t + 1) * sizeof *lists.after)};
    int64_t k, status = lists.begin && lists.after ? DONE : NO_MEMORY;
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
    for (k = 0; k < m && status == DONE; k++) {
        int64_t a = facets[2 * k], b = facets[2 * k + 1];
        side = known_side(mesh, &lists, a < b ? a : b, a < b ? b : a);
        if (side >= 0 && mesh->twin[side] >= 0) {
            mesh->twin[mesh->twin[side]] = -1;
            mesh->twin[side] = -1;
        }
    }
    free(lists.begin);
    free(lists.after);
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

/* Margins (BLOCK,) by which nodes at places (6, BLOCK), x and y of a, b and c, turn to the left for sure, if positive. */
SIDE_BY_SIDE static void turn_margins(const double *places, double *margin)
{
    const double *ax = places, *ay = ax + BLOCK, *bx = ay + BLOCK, *by = bx + BLOCK, *cx = by + BLOCK, *cy = cx + BLOCK;
    int k;
    for (k = 0; k < BLOCK; k++) {
        double left = (ax[k] - cx[k]) * (by[k] - cy[k]), right = (ay[k] - cy[k]) * (bx[k] - cx[k]);
        margin[k] = (left - right) - TURN_ERROR * (fabs(left) + fabs(right));
    }
}

/* Margins (BLOCK,) by which d is outside of the circle through a, b and c for sure, if negative, at places (8, BLOCK) as
   above: those of `in_circle`. */
SIDE_BY_SIDE static void circle_margins(const double *places, double *margin)
{
    const double *x = places, *y = places + BLOCK, *dx = places + 6 * BLOCK, *dy = places + 7 * BLOCK;
    int k;
    for (k = 0; k < BLOCK; k++) {
        double ax = x[k] - dx[k], ay = y[k] - dy[k], bx = x[2 * BLOCK + k] - dx[k], by = y[2 * BLOCK + k] - dy[k];
        double cx = x[4 * BLOCK + k] - dx[k], cy = y[4 * BLOCK + k] - dy[k];
        double bc = bx * cy, cb = cx * by, ca = cx * ay, ac = ax * cy, ab = ax * by, ba = bx * ay;
        double over_a = ax * ax + ay * ay, over_b = bx * bx + by * by, over_c = cx * cx + cy * cy;
        double value = over_a * (bc - cb) + over_b * (ca - ac) + over_c * (ab - ba);
        double most =
            (fabs(bc) + fabs(cb)) * over_a + (fabs(ca) + fabs(ac)) * over_b + (fabs(ab) + fabs(ba)) * over_c;
        margin[k] = value + CIRCLE_ERROR * most;
    }
}

/* Puts the place of a node into the column k of two rows of places. */
static void put(double *places, int row, int64_t k, const double *x, int64_t node)
{
    places[2 * row * BLOCK + k] = x[2 * node];
    places[(2 * row + 1) * BLOCK + k] = x[2 * node + 1];
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

/* Lawson's flips, until every edge between two triangles is locally Delaunay, but for facets. Where rounding
   decides, that is the end if all must be sure, else the edge stays. */
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
        if ((inside == 0 && sure) || (inside > 0 && left-- == 0))
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

/* Makes triangles Delaunay, as `legalise_triangles`. */
static int64_t flip_all(Mesh *mesh, const double *start, const double *x, int64_t *outcome)
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

/* Makes triangles (t, 3) Delaunay at x (n, 2) within facets (m, 2), by flips as the nodes come there from start (n, 2),
   and puts them in order, with their edges in edges (3 t, 2), the number of these in count (1,), and their twins (t, 3),
   -1 on the rim and on facets. If their edges (known_m, 2) and twins are known already, they are in order: nothing is
   put where there is no flip, and outcome (1,) is 2. Where rounding decides, or triangles are inverted, nothing is
   sure: then it is 1, else 0. */
KERNEL int64_t legalise_triangles(int64_t n, int64_t t, const int64_t *triangles, int64_t known_m,
                                  const int64_t *known_edges, const int32_t *known_twins, const double *start,
                                  const double *x, int64_t m, const int64_t *facets, int64_t *ordered, int32_t *twins,
                                  int64_t *edges, int64_t *count, int64_t *outcome)
{
    const Known known = {known_m ? triangles : NULL, known_edges, known_m};
    Mesh mesh = {n, t, NULL, NULL, NULL};
    int64_t status = take(&mesh, triangles, known_m > 0);
    mesh.twin = malloc((size_t)(3 * t + 1) * sizeof *mesh.twin);
    if (!mesh.twin)
        status = NO_MEMORY;
    if (status == DONE && known_m)
        memcpy(mesh.twin, known_twins, (size_t)(3 * t) * sizeof *mesh.twin);
    else if (status == DONE)
        status = find_twins(&mesh, m, facets);
    if (status == DONE)
        status = flip_all(&mesh, start, x, outcome);
    if (status == DONE && *outcome == DONE && !memchr(mesh.changed, 1, (size_t)t))
        *outcome = UNCHANGED;
    if (status == DONE && *outcome == DONE)
        status = put_in_order(&mesh, &known, ordered, twins, edges, count);
    give_back(&mesh);
    return status;
}
