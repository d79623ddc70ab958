/* Triangles whose edges get nodes in their middles; see refining.py. */
#include <stdlib.h>

#include "kernels.h"

enum { LEFT_OUT = -1, WHOLE = -2 }; /* numbers of nodes that are left out, and of middles that there are not */

/* Triangles of nodes below n, and their edges (m, 2), which have the lower node first and ascend. */
typedef struct {
    const int64_t *edges;
    int64_t *begin; /* (n + 1,): the first edge of each node */
} Edges;

static void list_begins(const Edges *all, int64_t n, int64_t m)
{
    int64_t node, edge = 0;
    for (node = 0; node <= n; node++) {
        while (edge < m && all->edges[2 * edge] < node)
            edge++;
        all->begin[node] = edge;
    }
}

/* What `middle` (m,) has for the edge between two nodes. */
static int64_t of_edge(const Edges *all, int64_t a, int64_t b, const int64_t *middle)
{
    int64_t low = a < b ? a : b, high = a < b ? b : a, edge = all->begin[low], end = all->begin[low + 1];
    while (edge < end && all->edges[2 * edge + 1] != high)
        edge++;
    return edge < end ? middle[edge] : WHOLE;
}

/* Where triangles go, and the sides of those that are left out with them. */
typedef struct {
    int64_t *kept, *sides;
    int64_t kept_count, side_count;
} Result;

static void add(Result *result, int64_t a, int64_t b, int64_t c)
{
    const int64_t node[3] = {a, b, c};
    int k;
    if (a >= 0 && b >= 0 && c >= 0) {
        for (k = 0; k < 3; k++)
            result->kept[3 * result->kept_count + k] = node[k];
        result->kept_count++;
        return;
    }
    for (k = 0; k < 3; k++)
        if (node[k] >= 0 && node[(k + 1) % 3] >= 0) {
            result->sides[2 * result->side_count] = node[k];
            result->sides[2 * result->side_count++ + 1] = node[(k + 1) % 3];
        }
}

/* Divides a triangle with the nodes v[3] and the middles w[3] of the edges from each to the next. */
static void divide(Result *result, const int64_t *v, const int64_t *w)
{
    int whole = (w[0] == WHOLE) + (w[1] == WHOLE) + (w[2] == WHOLE);
    int first = whole == 2 ? (w[0] != WHOLE ? 0 : w[1] != WHOLE ? 1 : 2) : (w[0] == WHOLE ? 0 : w[1] == WHOLE ? 1 : 2);
    int64_t a = v[first], b = v[(first + 1) % 3], c = v[(first + 2) % 3];
    int64_t ab = w[first], bc = w[(first + 1) % 3], ca = w[(first + 2) % 3];
    if (whole == 3) {
        add(result, a, b, c);
    } else if (whole == 2) { /* only the first edge has a middle */
        add(result, a, ab, c);
        add(result, ab, b, c);
    } else if (whole == 1) { /* only the first one has none */
        add(result, bc, c, ca);
        add(result, a, b, bc);
        add(result, a, bc, ca);
    } else {
        add(result, a, ab, ca);
        add(result, ab, b, bc);
        add(result, ca, bc, c);
        add(result, ab, bc, ca);
    }
}

/* Triangles (t, 3) of n nodes, numbered anew by number (n,), with nodes in the middles of edges (m, 2) by middle (m,),
   go into kept (4 t, 3), and how many into count[0]. Those with a node that is left out go with it; their sides without
   such a node go into sides (4 t, 2), and how many into count[1]. */
KERNEL int64_t refine_triangles(int64_t n, int64_t t, const int64_t *triangles, int64_t m, const int64_t *edges,
                                const int64_t *number, const int64_t *middle, int64_t *kept, int64_t *sides,
                                int64_t *count)
{
    const Edges all = {edges, malloc((size_t)(n + 2) * sizeof *all.begin)};
    Result result = {kept, sides, 0, 0};
    int64_t k;
    int corner;
    if (!all.begin)
        return NO_MEMORY;
    list_begins(&all, n, m);
    for (k = 0; k < t; k++) {
        const int64_t *node = triangles + 3 * k;
        int64_t v[3], w[3];
        for (corner = 0; corner < 3; corner++) {
            v[corner] = number[node[corner]];
            w[corner] = of_edge(&all, node[corner], node[(corner + 1) % 3], middle);
        }
        divide(&result, v, w);
    }
    count[0] = result.kept_count;
    count[1] = result.side_count;
    free(all.begin);
    return DONE;
}
