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

/* How nodes go down the gradient: triangles with nodes corners (3, t), and edges with ends (2, m) that should have the
   lengths contact (m,); those among them with a node that may move, whose factor in scale (n,) is not 0. */
typedef struct {
    int64_t n, t, m;
    const int64_t *corners;
    const double *d;
    const int64_t *ends;
    const double *contact;
    double flattest, worst, shortest;
    const double *scale;
    int64_t moving_t, moving_m;
    int32_t *triangles, *edges; /* (moving_t,), (moving_m,): their numbers, ascending */
} Links;

/* Lists the triangles and edges with a node that may move. */
static void list_moving(Links *all)
{
    const int64_t *corners = all->corners, *ends = all->ends;
    const double *scale = all->scale;
    int64_t k, t = all->t, m = all->m;
    for (k = 0; k < t; k++) {
        all->triangles[all->moving_t] = (int32_t)k;
        all->moving_t += scale[corners[k]] != 0 || scale[corners[t + k]] != 0 || scale[corners[2 * t + k]] != 0;
    }
    for (k = 0; k < m; k++) {
        all->edges[all->moving_m] = (int32_t)k;
        all->moving_m += scale[ends[k]] != 0 || scale[ends[m + k]] != 0;
    }
}

/* Gradients (3, 2, BLOCK) of eta^4 by the corners of triangles with sides u and w from the first corner (2, BLOCK each),
   whose areas count as no less than least (BLOCK,). */
SIDE_BY_SIDE static void triangle_pulls(const double *u, const double *w, const double *least, double worst, double *pull)
{
    int k;
    for (k = 0; k < BLOCK; k++) {
        double ux = u[k], uy = u[BLOCK + k], wx = w[k], wy = w[BLOCK + k], zx = wx - ux, zy = wy - uy;
        double area = (ux * wy - uy * wx) / 2;
        double squares = ux * ux + uy * uy + wx * wx + wy * wy + zx * zx + zy * zy, to_eta, eta, bounded, steep;
        double by_squares, by_area;
        area = area < least[k] ? least[k] : area; /* what is no number stays none, as in NumPy */
        to_eta = 1 / (FOUR_ROOTS * area);
        eta = squares * to_eta;
        bounded = eta > worst ? worst : eta;
        steep = 4 * (bounded * bounded * bounded);
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

/* Gradients (2, BLOCK) of (l / l0 - 1)^2 by the first ends of edges that are dx and dy long, at the last ends less
   than nothing by as much. */
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

/* Adds what triangles pull, from the one at `begin` of those that move, to sums of[3] at their corners. */
static void add_triangles(const Links *all, int64_t begin, const double *x, double *const *of)
{
    double u[2 * BLOCK] = {0}, w[2 * BLOCK] = {0}, least[BLOCK], pull[6 * BLOCK];
    int64_t t = all->t, count = all->moving_t - begin < BLOCK ? all->moving_t - begin : BLOCK, k;
    int corner;
    for (k = 0; k < BLOCK; k++)
        least[k] = 1.0;
    for (k = 0; k < count; k++) {
        const int64_t *node = all->corners + all->triangles[begin + k];
        const double *a = x + 2 * node[0], *b = x + 2 * node[t], *c = x + 2 * node[2 * t];
        u[k] = b[0] - a[0], u[BLOCK + k] = b[1] - a[1];
        w[k] = c[0] - a[0], w[BLOCK + k] = c[1] - a[1];
        least[k] = all->flattest * (all->d[node[0]] * all->d[node[0]]);
    }
    triangle_pulls(u, w, least, all->worst, pull);
    for (k = 0; k < count; k++) {
        const int64_t *node = all->corners + all->triangles[begin + k];
        for (corner = 0; corner < 3; corner++) {
            of[corner][2 * node[corner * t]] += pull[2 * corner * BLOCK + k];
            of[corner][2 * node[corner * t] + 1] += pull[(2 * corner + 1) * BLOCK + k];
        }
    }
}

/* Adds what edges pull, from the one at `begin` of those that move, to sums of[2] at their ends. */
static void add_edges(const Links *all, int64_t begin, const double *x, double *const *of)
{
    double dx[BLOCK] = {0}, dy[BLOCK] = {0}, contact[BLOCK], pull[2 * BLOCK];
    int64_t m = all->m, count = all->moving_m - begin < BLOCK ? all->moving_m - begin : BLOCK, k;
    for (k = 0; k < BLOCK; k++)
        contact[k] = 1.0;
    for (k = 0; k < count; k++) {
        int64_t edge = all->edges[begin + k], i = 2 * all->ends[edge], j = 2 * all->ends[m + edge];
        dx[k] = x[i] - x[j];
        dy[k] = x[i + 1] - x[j + 1];
        contact[k] = all->contact[edge];
    }
    edge_pulls(dx, dy, contact, all->shortest, pull);
    for (k = 0; k < count; k++) {
        int64_t edge = all->edges[begin + k], i = 2 * all->ends[edge], j = 2 * all->ends[m + edge];
        of[0][i] += pull[k];
        of[0][i + 1] += pull[BLOCK + k];
        of[1][j] += pull[k];
        of[1][j + 1] += pull[BLOCK + k];
    }
}

/* Nodes of which the first `fixed` have no way to go and the next ones, b of them, go along their tangents (b, 2); none
   goes farther in a step than most (n,). */
typedef struct {
    int64_t fixed, b;
    const double *tangents, *most;
    double weight, momentum, step;
} Way;

/* Moves nodes x (n, 2) with velocities v (n, 2) down the gradient, by sums (5, n, 2) of what pulls them: at the three
   corners of triangles, and at the first and at the last ends of edges. */
static void go_down(const Links *all, const Way *way, const double *sums, double *x, double *v)
{
    int64_t n = all->n, k;
    int axis;
    for (k = 0; k < n; k++) {
        double down[2], *vk = v + 2 * k, length, share;
        for (axis = 0; axis < 2; axis++) {
            const double *at = sums + 2 * k + axis;
            double shape = at[0] + at[2 * n] + at[4 * n], lengths = at[6 * n] - at[8 * n];
            down[axis] = (shape + way->weight * lengths) * all->scale[k];
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

/* Moves nodes x (n, 2) so many steps down the gradient, from rest. */
KERNEL int64_t descend(int64_t n, int64_t t, int64_t m, int64_t fixed, int64_t b, const int64_t *corners,
                       const double *d, const int64_t *ends, const double *contact, double flattest, double worst,
                       double shortest, const double *scale, const double *most, double weight, double momentum,
                       double step, const double *tangents, int64_t steps, double *x)
{
    Links all = {n, t, m, corners, d, ends, contact, flattest, worst, shortest, scale, 0, 0, NULL, NULL};
    const Way way = {fixed, b, tangents, most, weight, momentum, step};
    double *sums = malloc((size_t)(10 * n + 1) * sizeof *sums), *v = calloc((size_t)(2 * n + 1), sizeof *v), *of[5];
    int64_t k, status = NO_MEMORY;
    all.triangles = malloc((size_t)(t + 1) * sizeof *all.triangles);
    all.edges = malloc((size_t)(m + 1) * sizeof *all.edges);
    if (sums && v && all.triangles && all.edges && t < INT32_MAX && m < INT32_MAX) {
        list_moving(&all);
        for (k = 0; k < 5; k++)
            of[k] = sums + 2 * n * k;
        for (; steps > 0; steps--) {
            memset(sums, 0, (size_t)(10 * n) * sizeof *sums);
            for (k = 0; k < all.moving_t; k += BLOCK)
                add_triangles(&all, k, x, of);
            for (k = 0; k < all.moving_m; k += BLOCK)
                add_edges(&all, k, x, of + 3);
            go_down(&all, &way, sums, x, v);
        }
        status = DONE;
    }
    free(sums);
    free(v);
    free(all.triangles);
    free(all.edges);
    return status;
}
