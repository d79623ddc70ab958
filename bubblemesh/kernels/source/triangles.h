/* Triangles with neighbours: edges are flipped in flipping.c, triangles and edges put in order in ordering.c. */
#ifndef BUBBLEMESH_TRIANGLES_H
#define BUBBLEMESH_TRIANGLES_H

#include "kernels.h"

enum { UNDECIDED = 1 };

/* Side k of a triangle goes from its node k to the next; sides are numbered 3 * triangle + k. */
typedef struct {
    int64_t n, t;
    int32_t *nodes; /* (t, 3) */
    int32_t *twin;  /* (t, 3): the same edge's side in the triangle across, -1 on the rim and on facets; NULL if unknown */
    char *changed;  /* (t,): triangles that are not in order: all of them, or those that flips have changed */
} Mesh;

/* Triangles (t, 3) and edges (m, 2) in order, as they were before some triangles changed; NULL if none were. */
typedef struct {
    const int64_t *triangles, *edges;
    int64_t m;
} Known;

/* Takes triangles (t, 3), if they are few enough to number their sides. */
SHARED int64_t take(Mesh *mesh, const int64_t *triangles, int in_order);

/* Takes triangles (t, 3) with their twins (t, 3), which are found where they are NULL: sides along facets (m, 2) then
   count as rim. The outcome is UNDECIDED if the rim is not of facets, or one of these is no side, else DONE. */
SHARED int64_t take_with_twins(Mesh *mesh, const int64_t *triangles, const int32_t *twins, int64_t m,
                               const int64_t *facets, int64_t *outcome);

SHARED void give_back(Mesh *mesh);

/* Makes triangles Delaunay by flips while the nodes go from start (n, 2) to x (n, 2), with a halt wherever a longer step
   would invert a triangle. Of nodes on a circle, as far as rounding tells, edges have the lowest one. The outcome is
   UNDECIDED where triangles might be flat, or one stays inverted, else DONE. */
SHARED int64_t flip_all(Mesh *mesh, const double *start, const double *x, int64_t *outcome);

/* Lists the edges of all triangles in order in edges (3 t, 2), and their number in count (1,). */
SHARED int64_t put_edges_in_order(const Mesh *mesh, const Known *known, int64_t *edges, int64_t *count);

/* Puts triangles (t, 3) in order, with their twins (t, 3) if these are known. */
SHARED int64_t put_triangles_in_order(const Mesh *mesh, int64_t *triangles, int32_t *twins);

#endif
