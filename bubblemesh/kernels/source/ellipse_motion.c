/* Motion in a metric that inverts no triangle; see ellipse_motion.py. */
#include <stdlib.h>
#include <string.h>

#include "ellipses.h"
#include "relaxing.h"

enum { HALVINGS = 4, MOST_TRIES = 40 };
enum { BLOCK = 64 }; /* edges whose forces are found side by side */

static double cross(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

int make_moving_room(Room *room, int64_t n, int64_t t)
{
    const Room none = {NULL};
    double *all = malloc((size_t)(2 * t + 11 * n + 1) * sizeof *all), *of_nodes;
    *room = none;
    if (!all)
        return 0;
    of_nodes = all + 2 * t;
    room->all = room->area = all;
    room->next = all + t;
    room->places = of_nodes;
    room->share = of_nodes + 2 * n;
    room->v = of_nodes + 3 * n;
    room->move = of_nodes + 5 * n;
    room->first = of_nodes + 7 * n;
    room->second = of_nodes + 9 * n;
    room->marked = malloc((size_t)(n + 1));
    return room->marked != NULL;
}

void leave_moving_room(Room *room)
{
    free(room->all);
    free(room->marked);
}

/* Whether triangles have smaller areas (t,) than they are to keep of those before; 1 if any has. */
SIDE_BY_SIDE static int any_smaller(int64_t t, const double *next, const double *area, double keep)
{
    int64_t k, found = 0;
    for (k = 0; k < t; k++)
        found |= next[k] < keep * area[k];
    return found != 0;
}

/* Doubled areas (t,) of triangles (t, 3) with nodes at x (n, 2). */
static void find_areas(int64_t t, const int64_t *triangles, const double *x, double *area)
{
    int64_t k;
    for (k = 0; k < t; k++)
        area[k] = cross(x + 2 * triangles[3 * k], x + 2 * triangles[3 * k + 1], x + 2 * triangles[3 * k + 2]);
}

/* Moves nodes as `move_guarded` where the areas of the triangles are known, which are so again after it. */
static void move_by_areas(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *move, double keep,
                          Room *room)
{
    double *share = room->share, *area = room->area, *next = room->next, *places = room->places;
    int64_t k, j, tries;
    for (k = 0; k < n; k++)
        share[k] = 1;
    for (tries = 0; tries < MOST_TRIES; tries++) {
        for (k = 0; k < n; k++) {
            places[2 * k] = x[2 * k] + share[k] * move[2 * k];
            places[2 * k + 1] = x[2 * k + 1] + share[k] * move[2 * k + 1];
        }
        find_areas(t, triangles, places, next);
        if (!any_smaller(t, next, area, keep)) {
            memcpy(x, places, (size_t)(2 * n) * sizeof *x);
            room->area = next;
            room->next = area;
            return;
        }
        memset(room->marked, 0, (size_t)n);
        for (k = 0; k < t; k++)
            if (next[k] < keep * area[k])
                for (j = 0; j < 3; j++)
                    room->marked[triangles[3 * k + j]] = 1;
        for (k = 0; k < n; k++)
            if (room->marked[k])
                share[k] = tries < HALVINGS ? share[k] / 2 : 0;
    }
    for (k = 0; k < n; k++)
        share[k] = 0;
}

void move_guarded(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *move, double keep, Room *room)
{
    find_areas(t, triangles, x, room->area);
    move_by_areas(n, t, triangles, x, move, keep, room);
}

/* Moves nodes as `move_guarded`; shares (n,) are written. */
KERNEL int64_t guarded_move(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *move, double keep,
                            double *share)
{
    Room room;
    int64_t status = make_moving_room(&room, n, t) ? DONE : NO_MEMORY;
    if (status == DONE) {
        move_guarded(n, t, triangles, x, move, keep, &room);
        memcpy(share, room.share, (size_t)n * sizeof *share);
    }
    leave_moving_room(&room);
    return status;
}

static double length_in(const double *m, double dx, double dy)
{
    double squared = m[0] * dx * dx + 2 * (m[1] * dx * dy) + m[2] * dy * dy;
    return sqrt(squared > 0 ? squared : 0);
}

/* Edges side by side: from their first ends to their last ones, with the tensors there, and the force along each. */
typedef struct {
    double dx[BLOCK], dy[BLOCK], first[3][BLOCK], last[3][BLOCK], fx[BLOCK], fy[BLOCK];
} Edges;

/* Forces along edges. */
SIDE_BY_SIDE static void pull(Edges *edges, double cutoff, double shortest)
{
    int k;
    for (k = 0; k < BLOCK; k++) {
        double dx = edges->dx[k], dy = edges->dy[k];
        double a = edges->first[0][k] * dx * dx + 2 * (edges->first[1][k] * dx * dy) + edges->first[2][k] * dy * dy;
        double b = edges->last[0][k] * dx * dx + 2 * (edges->last[1][k] * dx * dy) + edges->last[2][k] * dy * dy;
        double l, force;
        a = sqrt(a > 0 ? a : 0), b = sqrt(b > 0 ? b : 0);
        a = a > shortest ? a : shortest, b = b > shortest ? b : shortest;
        l = mean_length(a, b);
        force = pair_force(l, cutoff) / l;
        edges->fx[k] = force * dx;
        edges->fy[k] = force * dy;
    }
}

/* Adds to first (n, 2) the forces on the first ends of edges (e, 2), and to second (n, 2) those against the last ones. */
static void add_forces(int64_t e, const int32_t *ends, const double *x, const double *m, const Moving *moving,
                       double *first, double *second)
{
    Edges edges;
    int64_t begin, k;
    int j;
    memset(&edges, 0, sizeof edges);
    for (begin = 0; begin < e; begin += BLOCK) {
        const int32_t *end = ends + 2 * begin;
        int64_t count = e - begin < BLOCK ? e - begin : BLOCK;
        for (k = 0; k < count; k++) {
            int64_t one = end[2 * k], other = end[2 * k + 1];
            edges.dx[k] = x[2 * other] - x[2 * one];
            edges.dy[k] = x[2 * other + 1] - x[2 * one + 1];
            for (j = 0; j < 3; j++) {
                edges.first[j][k] = m[3 * one + j];
                edges.last[j][k] = m[3 * other + j];
            }
        }
        pull(&edges, moving->cutoff, moving->shortest);
        for (k = 0; k < count; k++) {
            double *on = first + 2 * (int64_t)end[2 * k], *against = second + 2 * (int64_t)end[2 * k + 1];
            on[0] += edges.fx[k];
            on[1] += edges.fy[k];
            against[0] += edges.fx[k];
            against[1] += edges.fy[k];
        }
    }
}

void relax_ellipses(int64_t n, int64_t t, const int64_t *triangles, int64_t e, const int32_t *ends, double *x,
                    const double *m, int64_t fixed, int64_t steps, const Moving *moving, double *speeds, Room *room)
{
    double *v = room->v, *move = room->move, *first = room->first, *second = room->second, dt = moving->dt;
    int64_t step, k;
    for (k = 0; k < 2 * n; k++)
        v[k] = 0;
    find_areas(t, triangles, x, room->area);
    for (step = 0; step < steps; step++) {
        double sum = 0;
        for (k = 0; k < 2 * n; k++)
            first[k] = second[k] = 0;
        add_forces(e, ends, x, m, moving, first, second);
        for (k = 0; k < n; k++) {
            double vx = (v[2 * k] + dt * (second[2 * k] - first[2 * k])) / (1 + moving->c * dt);
            double vy = (v[2 * k + 1] + dt * (second[2 * k + 1] - first[2 * k + 1])) / (1 + moving->c * dt);
            double far, part;
            if (k < fixed)
                vx = vy = 0;
            far = length_in(m + 3 * k, dt * vx, dt * vy);
            part = moving->most / (far > moving->most ? far : moving->most);
            v[2 * k] = part * vx;
            v[2 * k + 1] = part * vy;
            move[2 * k] = dt * v[2 * k];
            move[2 * k + 1] = dt * v[2 * k + 1];
        }
        move_by_areas(n, t, triangles, x, move, moving->keep, room);
        for (k = 0; k < n; k++) {
            v[2 * k] *= room->share[k];
            v[2 * k + 1] *= room->share[k];
            sum += length_in(m + 3 * k, v[2 * k], v[2 * k + 1]);
        }
        speeds[step] = sum / (double)n;
    }
}

/* Steps of motion as of `relax_ellipses`. */
KERNEL int64_t metric_relax(int64_t n, int64_t t, const int64_t *triangles, int64_t e, const int64_t *edges, double *x,
                            const double *m, int64_t fixed, int64_t steps, double dt, double c, double cutoff,
                            double most, double keep, double shortest, double *speeds)
{
    const Moving moving = {dt, c, cutoff, most, keep, shortest};
    int32_t *ends = n < INT32_MAX ? malloc((size_t)(2 * e + 1) * sizeof *ends) : NULL;
    Room room;
    int64_t k, status = make_moving_room(&room, n, t) && ends ? DONE : NO_MEMORY;
    for (k = 0; k < 2 * e && status == DONE; k++)
        ends[k] = (int32_t)edges[k];
    if (status == DONE)
        relax_ellipses(n, t, triangles, e, ends, x, m, fixed, steps, &moving, speeds, &room);
    free(ends);
    leave_moving_room(&room);
    return status;
}
