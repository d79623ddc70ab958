/* Triangles and their edges in an order of their own, and flips of edges that make them Delaunay; see linking.py. */
#include <string.h>

#include "triangles.h"

enum { UNCHANGED = 2 };

/* Puts triangles (t, 3) of n nodes in order, and their edges into edges (3 t, 2), whose number goes into count (1,). */
KERNEL int64_t order_triangles(int64_t n, int64_t t, const int64_t *triangles, int64_t *ordered, int64_t *edges,
                               int64_t *count)
{
    const Known nothing = {NULL, NULL, 0};
    Mesh mesh = {n, t, NULL, NULL, NULL};
    int64_t status = take(&mesh, triangles, 0);
    if (status == DONE)
        status = put_edges_in_order(&mesh, &nothing, edges, count);
    if (status == DONE)
        status = put_triangles_in_order(&mesh, ordered, NULL);
    give_back(&mesh);
    return status;
}

/* Makes triangles (t, 3) Delaunay at x (n, 2) within facets (m, 2), by flips as the nodes come there from start (n, 2),
   and puts them in order, with their edges in edges (3 t, 2), the number of these in count (1,), and their twins (t, 3),
   -1 on the rim and on facets. If their edges (known_m, 2) and twins are known already, they are in order: nothing is
   put where there is no flip, and outcome (1,) is 2. Where triangles might be flat, are inverted or unknown ones do not
   end at facets, though they are not ``open``, nothing is sure: then it is 1, else 0. */
KERNEL int64_t legalise_triangles(int64_t n, int64_t t, const int64_t *triangles, int64_t known_m,
                                  const int64_t *known_edges, const int32_t *known_twins, const double *start,
                                  const double *x, int64_t m, const int64_t *facets, int64_t open, int64_t *ordered,
                                  int32_t *twins, int64_t *edges, int64_t *count, int64_t *outcome)
{
    const Known known = {known_m ? triangles : NULL, known_edges, known_m};
    Mesh mesh = {n, t, NULL, NULL, NULL};
    int64_t status = take_with_twins(&mesh, triangles, known_m ? known_twins : NULL, m, facets, outcome);
    if (status == DONE && (open || *outcome == DONE))
        status = flip_all(&mesh, start, x, outcome);
    if (status == DONE && *outcome == DONE && !memchr(mesh.changed, 1, (size_t)t))
        *outcome = UNCHANGED;
    if (status == DONE && *outcome == DONE)
        status = put_edges_in_order(&mesh, &known, edges, count);
    if (status == DONE && *outcome == DONE)
        status = put_triangles_in_order(&mesh, ordered, twins);
    give_back(&mesh);
    return status;
}
