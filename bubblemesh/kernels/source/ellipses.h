/* Packing in a metric: flips that make triangles Delaunay in it, and motion that inverts none. A tensor is
   (m11, m12, m22). */
#ifndef BUBBLEMESH_ELLIPSES_H
#define BUBBLEMESH_ELLIPSES_H

#include <math.h>

#include "kernels.h"

/* Sides of triangles (t, 3) between n nodes: side 3 * triangle + k goes from the triangle's node k to the next one. */
typedef struct {
    int64_t n, t, *triangles;
    int64_t *twin;         /* (3 t,): the side along each on its other side, or -1 */
    char *fixed, *wrong;   /* (3 t,): whether each stays, and whether it is to be flipped */
    int64_t *chosen;       /* (t,) */
    char *changed;         /* (t,): for work */
} Sides;

/* What decides on flips. */
typedef struct {
    int64_t passes;
    double sure, flattest;
} Circles;

/* What the motion of nodes goes by. */
typedef struct {
    double dt, c, cutoff, most, keep, shortest;
} Moving;

/* Room to move n nodes of t triangles. */
typedef struct {
    double *all;         /* of which the others are parts */
    double *area, *next; /* (t,): doubled areas of the triangles, and those after a move */
    double *places, *share, *v, *move, *first, *second;
    char *marked;
} Room;

/* Finds the twins of the sides and those along facets (f, 2); NO_MEMORY or DONE, and either way the caller gives them
   back. */
SHARED int64_t take_sides(Sides *s, int64_t n, int64_t t, int64_t *triangles, int64_t f, const int64_t *facets);
SHARED void give_sides_back(Sides *s);

/* Flips edges of nodes at x (n, 2) with tensors m (n, 3) until all but the fixed ones pass the circle test, in passes in
   which no triangle changes twice. */
SHARED void flip_wrong(Sides *s, const double *x, const double *m, const Circles *circles);

/* Lists the edges (3 t, 2), and gives their number. */
SHARED int64_t list_side_edges(const Sides *s, int64_t *edges);

SHARED int make_moving_room(Room *room, int64_t n, int64_t t);
SHARED void leave_moving_room(Room *room);

/* Moves nodes x (n, 2) by share * move (n, 2), so that each triangle (t, 3) keeps at least a part of its area. The shares
   (n,) of the room are 1, halved for the nodes of those that do not, down to 1/16, and then 0. */
SHARED void move_guarded(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *move, double keep,
                         Room *room);

/* Steps of the motion of nodes x (n, 2) with tensors m (n, 3) under forces along edges with ends (e, 2); the first
   ``fixed`` nodes stay. The mean speeds in the metric come out (steps,). */
SHARED void relax_ellipses(int64_t n, int64_t t, const int64_t *triangles, int64_t e, const int32_t *ends, double *x,
                           const double *m, int64_t fixed, int64_t steps, const Moving *moving, double *speeds,
                           Room *room);

/* Length of an edge that is a and b long in the metrics of its ends: nearly the logarithmic mean. */
static inline double mean_length(double a, double b)
{
    return (2 * sqrt(a * b) + (a + b) / 2) / 3;
}

#endif
