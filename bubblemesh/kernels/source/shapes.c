/* Shapes of triangles, gradients of these and of the lengths of edges, and steps down these; see shapes.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

static const double FOUR_ROOTS = 6.9282032302755088; /* 4 sqrt(3) */

/* Shape measures eta (t,) of triangles (t, 3) with their nodes at x (n, 2); infinite where the area is not positive. */
KERNEL int64_t shape_measures(int64_t t, const double *x, const int64_t *triangles, double *eta)
{
    int64_t k;
    for (k = 0; k < t; k++) {
        const double *a = x + 2 * triangles[3 * k], *b = x + 2 * triangles[3 * k + 1],
                     *c = x + 2 * triangles[3 * k + 2];
        double ux = b[0] - a[0], uy = b[1] - a[1], wx = c[0] - a[0], wy = c[1] - a[1], zx = c[0] - b[0],
               zy = c[1] - b[1];
        double area = (ux * wy - uy * wx) / 2;
        double squares = (ux * ux + wx * wx + zx * zx) + (uy * uy + wy * wy + zy * zy);
        eta[k] = area > 0 ? squares / (FOUR_ROOTS * area) : INFINITY;
    }
    return DONE;
}

enum { BLOCK = 64 }; /* triangles or edges whose pulls are found side by side */

/* What pulls n nodes: triangles with their corners (t, 3), each as often as it counts (t,), and edges with their ends
   (m, 2) that should have the lengths contact (m,). They are those with a node that may move, whose factor in scale
   (n,) is not 0. */
typedef struct {
    int64_t n, t, m;
    int32_t *corners, *ends;
    double *counts, *contact;
    const double *d, *scale; /* (n,) */
    double flattest, worst, shortest;
} Links;

/* Lists those of the triangles (t, 3), with their counts (t,), and edges (m, 2) that have a node that may move. */
static void list_moving(Links *all, int64_t t, const int64_t *triangles, const double *counts, int64_t m,
                        const int64_t *edges)
{
    const double *scale = all->scale;
    int64_t k;
    for (k = 0; k < t; k++) {
        const int64_t *node = triangles + 3 * k;
        int32_t *corner = all->corners + 3 * all->t;
        corner[0] = (int32_t)node[0], corner[1] = (int32_t)node[1], corner[2] = (int32_t)node[2];
        all->counts[all->t] = counts[k];
        all->t += scale[node[0]] != 0 || scale[node[1]] != 0 || scale[node[2]] != 0;
    }
    for (k = 0; k < m; k++) {
        int64_t i = edges[2 * k], j = edges[2 * k + 1];
        all->ends[2 * all->m] = (int32_t)i, all->ends[2 * all->m + 1] = (int32_t)j;
        all->contact[all->m] = (all->d[i] + all->d[j]) / 2;
        all->m += scale[i] != 0 || scale[j] != 0;
    }
}

/* Gradients (3, 2, BLOCK) of counts (BLOCK,) times eta^8 / 2 by the corners of triangles with sides u and w from the
   first corner (2, BLOCK each), whose areas count as no less than least (BLOCK,). */
SIDE_BY_SIDE static void triangle_pulls(const double *u, const double *w, const double *least, const double *counts,
                                        double worst, double *pull)
{
    int k;
    for (k = 0; k < BLOCK; k++) {
        double ux = u[k], uy = u[BLOCK + k], wx = w[k], wy = w[BLOCK + k], zx = wx - ux, zy = wy - uy;
        double area = (ux * wy - uy * wx) / 2;
        double squares = ux * ux + uy * uy + wx * wx + wy * wy + zx * zx + zy * zy, to_eta, eta, bounded, cube, steep;
        double by_squares, by_area;
        area = area < least[k] ? least[k] : area; /* what is no number stays none, as in NumPy */
        to_eta = 1 / (FOUR_ROOTS * area);
        eta = squares * to_eta;
        bounded = eta > worst ? worst : eta;
        cube = bounded * bounded * bounded;
        steep = 4 * counts[k] * (cube * cube * bounded);
        by_squares = 2 * steep * to_eta;
        by_area = steep * eta / (2 * area);
        pull[k] = by_squares * (-ux - wx) - by_area * -zy;
        pull[BLOCK + k] = by_squares * (-uy - wy) - by_area * zx;
        pull[2 * BLOCK + k] = by_squares * (ux - zx) - by_area * wy;
        pull[3 * BLOCK + k] = by_squares * (uy - zy) - by_area * -wx;
        pull[4 * BLOCK + k] = by_squares * (wx + zx) - by_area * -uy;
        pull[5 * BLOCK + k] = by_squares * (wy + zy) - by_area * ux;
    }
}

/* Gradients (2, BLOCK) of (l / l0 - 1)^2 by the first ends of edges that are dx and dy long: those by the last ends are
   their negatives. */
SIDE_BY_SIDE static void edge_pulls(const double *dx, const double *dy, const double *contact, double shortest,
                                    double *pull)
{
    int k;
    for (k = 0; k < BLOCK; k++) {
        double length = sqrt(dx[k] * dx[k] + dy[k] * dy[k]), least = shortest * contact[k], pulled;
        length = length < least ? least : length;
        pulled = 2 * (length / contact[k] - 1) / (contact[k] * length);
        pull[k] = pulled * dx[k];
        pull[BLOCK + k] = pulled * dy[k];
    }
}

enum { SUMS = 4 }; /* of a node: of triangles in both directions, and of edges */

/* Adds what triangles pull, from the one at `begin`, to the sums (n, SUMS) of their corners. */
static void add_triangles(const Links *all, int64_t begin, const double *x, double *sums)
{
    double u[2 * BLOCK] = {0}, w[2 * BLOCK] = {0}, least[BLOCK], counts[BLOCK] = {0}, pull[6 * BLOCK];
    int64_t count = all->t - begin < BLOCK ? all->t - begin : BLOCK, k;
    const int32_t *corners = all->corners + 3 * begin;
    int corner;
    for (k = 0; k < BLOCK; k++)
        least[k] = 1.0;
    for (k = 0; k < count; k++) {
        const int32_t *node = corners + 3 * k;
        const double *a = x + 2 * (int64_t)node[0], *b = x + 2 * (int64_t)node[1], *c = x + 2 * (int64_t)node[2];
        u[k] = b[0] - a[0], u[BLOCK + k] = b[1] - a[1];
        w[k] = c[0] - a[0], w[BLOCK + k] = c[1] - a[1];
        least[k] = all->flattest * (all->d[node[0]] * all->d[node[0]]);
        counts[k] = all->counts[begin + k];
    }
    triangle_pulls(u, w, least, counts, all->worst, pull);
    for (k = 0; k < count; k++)
        for (corner = 0; corner < 3; corner++) {
            double *sum = sums + SUMS * (int64_t)corners[3 * k + corner];
            sum[0] += pull[2 * corner * BLOCK + k];
            sum[1] += pull[(2 * corner + 1) * BLOCK + k];
        }
}

/* Adds what edges pull, from the one at `begin`, to the sums (n, SUMS) of their ends. */
static void add_edges(const Links *all, int64_t begin, const double *x, double *sums)
{
    double dx[BLOCK] = {0}, dy[BLOCK] = {0}, contact[BLOCK], pull[2 * BLOCK];
    int64_t count = all->m - begin < BLOCK ? all->m - begin : BLOCK, k;
    const int32_t *ends = all->ends + 2 * begin;
    for (k = 0; k < BLOCK; k++)
        contact[k] = 1.0;
    for (k = 0; k < count; k++) {
        const double *one = x + 2 * (int64_t)ends[2 * k], *other = x + 2 * (int64_t)ends[2 * k + 1];
        dx[k] = one[0] - other[0];
        dy[k] = one[1] - other[1];
        contact[k] = all->contact[begin + k];
    }
    edge_pulls(dx, dy, contact, all->shortest, pull);
    for (k = 0; k < count; k++) {
        double *first = sums + SUMS * (int64_t)ends[2 * k] + 2, *last = sums + SUMS * (int64_t)ends[2 * k + 1] + 2;
        first[0] += pull[k];
        first[1] += pull[BLOCK + k];
        last[0] -= pull[k];
        last[1] -= pull[BLOCK + k];
    }
}

/* Nodes of which the first `fixed` have no way to go and the next ones, b of them, go along their tangents (b, 2); none
   goes farther in a step than most (n,). */
typedef struct {
    int64_t fixed, b;
    const double *tangents, *most;
    double weight, momentum, step;
} Way;

/* Moves nodes x (n, 2) with velocities v (n, 2) down the gradient, by sums (n, SUMS) of what pulls them. */
static void go_down(const Links *all, const Way *way, const double *sums, double *x, double *v)
{
    int64_t k;
    int axis;
    for (k = 0; k < all->n; k++) {
        double down[2], *vk = v + 2 * k, length, share;
        for (axis = 0; axis < 2; axis++) {
            const double *sum = sums + SUMS * k + axis;
            down[axis] = (sum[0] + way->weight * sum[2]) * all->scale[k];
        }
        if (k < way->fixed) {
            down[0] = down[1] = vk[0] = vk[1] = 0;
        } else if (k < way->fixed + way->b) {
            const double *along = way->tangents + 2 * (k - way->fixed);
            double slope = down[0] * along[0] + down[1] * along[1], speed = vk[0] * along[0] + vk[1] * along[1];
            for (axis = 0; axis < 2; axis++) {
                down[axis] = slope * along[axis];
                vk[axis] = speed * along[axis];
            }
        }
        for (axis = 0; axis < 2; axis++)
            vk[axis] = way->momentum * vk[axis] - way->step * down[axis];
        length = sqrt(vk[0] * vk[0] + vk[1] * vk[1]);
        share = way->most[k] / (length < way->most[k] ? way->most[k] : length); /* no number stays none, as in NumPy */
        for (axis = 0; axis < 2; axis++) {
            vk[axis] *= share;
            x[2 * k + axis] += vk[axis];
        }
    }
}

/* Moves nodes x (n, 2) of triangles (t, 3), each as often as it counts (t,), and edges (m, 2) so many steps down the
   gradient, from rest. */
KERNEL int64_t descend(int64_t n, int64_t t, int64_t m, int64_t fixed, int64_t b, const int64_t *triangles,
                       const double *counts, const int64_t *edges, const double *d, double flattest, double worst,
                       double shortest, const double *scale, const double *most, double weight, double momentum,
                       double step, const double *tangents, int64_t steps, double *x)
{
    Links all = {n, 0, 0, NULL, NULL, NULL, NULL, d, scale, flattest, worst, shortest};
    const Way way = {fixed, b, tangents, most, weight, momentum, step};
    double *sums = malloc((size_t)(SUMS * n + 1) * sizeof *sums), *v = calloc((size_t)(2 * n + 1), sizeof *v);
    int64_t k, status = NO_MEMORY;
    all.corners = malloc((size_t)(3 * (t + 1)) * sizeof *all.corners);
    all.counts = malloc((size_t)(t + 1) * sizeof *all.counts);
    all.ends = malloc((size_t)(2 * (m + 1)) * sizeof *all.ends);
    all.contact = malloc((size_t)(m + 1) * sizeof *all.contact);
    if (sums && v && all.corners && all.counts && all.ends && all.contact && n < INT32_MAX) {
        list_moving(&all, t, triangles, counts, m, edges);
        for (; steps > 0; steps--) {
            memset(sums, 0, (size_t)(SUMS * n) * sizeof *sums);
            for (k = 0; k < all.t; k += BLOCK)
                add_triangles(&all, k, x, sums);
            for (k = 0; k < all.m; k += BLOCK)
                add_edges(&all, k, x, sums);
            go_down(&all, &way, sums, x, v);
        }
        status = DONE;
    }
    free(sums);
    free(v);
    free(all.corners);
    free(all.counts);
    free(all.ends);
    free(all.contact);
    return status;
}
