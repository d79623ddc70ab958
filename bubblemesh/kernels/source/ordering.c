/* Triangles and their edges in an order of their own; see linking.py. */
#include <stdlib.h>
#include <string.h>

#include "triangles.h"

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

/* Room to sort so many items, and to list edges that go; whether there is. */
static int make_room(Sorting *sorting, int64_t n, int64_t most)
{
    sorting->items = malloc((size_t)(most + 1) * sizeof *sorting->items);
    sorting->spare = malloc((size_t)(most + 1) * sizeof *sorting->spare);
    sorting->start = malloc((size_t)(n + 1) * sizeof *sorting->start);
    return sorting->items && sorting->spare && sorting->start;
}

static void leave_room(Sorting *sorting)
{
    free(sorting->items);
    free(sorting->spare);
    free(sorting->start);
}

int64_t put_edges_in_order(const Mesh *mesh, const Known *known, int64_t *edges, int64_t *count)
{
    int64_t k, changed = 0, listed = 0, status = NO_MEMORY;
    Sorting former = {NULL, NULL, NULL}, new_ones = {NULL, NULL, NULL};
    for (k = 0; k < mesh->t; k++)
        if (mesh->changed[k]) {
            changed++;
            listed += is_listed(mesh, 3 * k) + is_listed(mesh, 3 * k + 1) + is_listed(mesh, 3 * k + 2);
        }
    if (make_room(&former, mesh->n, known->triangles ? 3 * changed : 0) && make_room(&new_ones, mesh->n, listed)) {
        *count = list_edges(mesh, known, &former, &new_ones, edges);
        status = DONE;
    }
    leave_room(&former);
    leave_room(&new_ones);
    return status;
}

int64_t put_triangles_in_order(const Mesh *mesh, int64_t *triangles, int32_t *twins)
{
    int64_t k, changed = 0, status = NO_MEMORY;
    Sorting sorting = {NULL, NULL, NULL};
    int32_t *side = malloc((size_t)(3 * mesh->t + 1) * sizeof *side);
    for (k = 0; k < mesh->t; k++)
        changed += mesh->changed[k];
    if (make_room(&sorting, mesh->n, changed) && side) {
        list_triangles(mesh, &sorting, side, triangles, twins);
        status = DONE;
    }
    leave_room(&sorting);
    free(side);
    return status;
}
