/* Patches of a net around some of its triangles; see patches.py. */
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

/* Neighbours of nodes, and the nodes found around a triangle, ring after ring. */
typedef struct {
    int64_t *begin, *others; /* (n + 1,), (2 m,) */
    int64_t *found;          /* (n,) */
    char *known;             /* (n,): those that are found already */
} Rings;

static void join_neighbours(int64_t n, int64_t m, const int64_t *edges, Rings *rings)
{
    int64_t k, sum = 0, *begin = rings->begin;
    for (k = 0; k < 2 * m; k++)
        begin[edges[k]]++;
    for (k = 0; k <= n; k++) { /* to the end of each node's, which goes down to their begin */
        sum += begin[k];
        begin[k] = sum;
    }
    for (k = 0; k < m; k++) {
        rings->others[--begin[edges[2 * k]]] = edges[2 * k + 1];
        rings->others[--begin[edges[2 * k + 1]]] = edges[2 * k];
    }
}

/* Adds nodes next to those found from `first` on, below `count`; how many there are then. */
static int64_t add_ring(Rings *rings, int64_t first, int64_t count)
{
    int64_t k, p, all = count;
    for (k = first; k < count; k++)
        for (p = rings->begin[rings->found[k]]; p < rings->begin[rings->found[k] + 1]; p++) {
            int64_t other = rings->others[p];
            if (!rings->known[other]) {
                rings->known[other] = 1;
                rings->found[all++] = other;
            }
        }
    return all;
}

/* Patches around triangles seeds (k, 3), of n nodes with edges (m, 2): nodes at most `inner` edges away are marked in
   displaced (n,) if they are free (n,), those at most `outer` away get the patch's number in moving (n,). A patch that
   is no more than one edge away from another is left out; count (1,) are the others. */
KERNEL int64_t separate_patches(int64_t n, int64_t m, const int64_t *edges, int64_t k, const int64_t *seeds,
                                const char *free_nodes, int64_t inner, int64_t outer, char *displaced, int64_t *moving,
                                int64_t *count)
{
    Rings rings = {calloc((size_t)(n + 1), sizeof *rings.begin), malloc((size_t)(2 * m + 1) * sizeof *rings.others),
                   malloc((size_t)(n + 1) * sizeof *rings.found), calloc((size_t)(n + 1), 1)};
    char *taken = calloc((size_t)(n + 1), 1);
    int64_t seed, p, status = NO_MEMORY;
    if (!rings.begin || !rings.others || !rings.found || !rings.known || !taken)
        goto end;
    join_neighbours(n, m, edges, &rings);
    *count = 0;
    for (seed = 0; seed < k; seed++) {
        int64_t first = 0, all = 0, core = 0, patch = 0, ring, apart = 1;
        for (p = 0; p < 3; p++)
            if (!rings.known[seeds[3 * seed + p]]) {
                rings.known[seeds[3 * seed + p]] = 1;
                rings.found[all++] = seeds[3 * seed + p];
            }
        for (ring = 0; ring <= outer; ring++) {
            int64_t before = all;
            core = ring == inner ? all : core;
            patch = all;
            all = add_ring(&rings, first, all);
            first = before;
        }
        for (p = 0; p < patch; p++)
            apart &= !taken[rings.found[p]];
        for (p = 0; p < all; p++) {
            int64_t node = rings.found[p];
            rings.known[node] = 0;
            if (!apart)
                continue;
            taken[node] = 1;
            if (p < core && free_nodes[node])
                displaced[node] = 1;
            if (p < patch && free_nodes[node])
                moving[node] = *count;
        }
        *count += apart;
    }
    status = DONE;
end:
    free(rings.begin);
    free(rings.others);
    free(rings.found);
    free(rings.known);
    free(taken);
    return status;
}

/* Makes of the values (n,) of nodes with edges (m, 2) the least ones at most so many edges away. */
KERNEL int64_t least_around(int64_t n, int64_t m, const int64_t *edges, int64_t rings, int64_t *values)
{
    int64_t *before = malloc((size_t)(n + 1) * sizeof *before), k;
    if (!before)
        return NO_MEMORY;
    for (; rings > 0; rings--) {
        memcpy(before, values, (size_t)n * sizeof *values);
        for (k = 0; k < m; k++) {
            int64_t i = edges[2 * k], j = edges[2 * k + 1];
            values[i] = before[j] < values[i] ? before[j] : values[i];
            values[j] = before[i] < values[j] ? before[i] : values[j];
        }
    }
    free(before);
    return DONE;
}
