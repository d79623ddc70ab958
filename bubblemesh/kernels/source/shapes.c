/* Shapes of triangles, gradients of these and of the lengths of edges, and steps down these; see shapes.py. */
#include <math.h>
#include <stdlib.h>

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

/* Triangles with nodes corners (3, t), and edges with ends (2, m) that should have the lengths contact (m,). */
struct links {
    int64_t n, t, m;
    const int64_t *corners;
    const double *d;
    const int64_t *ends;
    const double *contact;
};

/* Sums of the gradient over nodes x (n, 2), ten for each in work (5, n, 2): at the three corners of the triangles, and
at the first and at the last ends of the edges. */
static void add_gradients(const struct links *all, const double *x, double flattest, double worst, double shortest,
                          double *work)
{
    int64_t n = all->n, t = all->t, m = all->m, k, axis;
    const int64_t *corners = all->corners, *ends = all->ends;
    const double *d = all->d, *contact = all->contact;
    double *of[5];
    for (k = 0; k < 5; k++)
        of[k] = work + 2 * n * k;
    for (k = 0; k < t; k++) {
        int64_t node[3] = {corners[k], corners[t + k], corners[2 * t + k]};
        const double *a = x + 2 * node[0], *b = x + 2 * node[1], *c = x + 2 * node[2];
        double ux = b[0] - a[0], uy = b[1] - a[1], wx = c[0] - a[0], wy = c[1] - a[1], zx = c[0] - b[0],
               zy = c[1] - b[1];
        double area = (ux * wy - uy * wx) / 2, least = flattest * (d[node[0]] * d[node[0]]);
        double squares = ux * ux + uy * uy + wx * wx + wy * wy + zx * zx + zy * zy, to_eta, eta, bounded, steep;
        double by_squares, by_area;
        double pull[3][2] = {{-ux - wx, -uy - wy}, {ux - zx, uy - zy}, {wx + zx, wy + zy}};
        double push[3][2] = {{-zy, zx}, {wy, -wx}, {-uy, ux}};
        int corner;
        area = area < least ? least : area; /* what is no number stays none, as in NumPy */
        to_eta = 1 / (FOUR_ROOTS * area);
        eta = squares * to_eta;
        bounded = eta > worst ? worst : eta;
        steep = 4 * (bounded * bounded * bounded);
        by_squares = 2 * steep * to_eta;
        by_area = steep * eta / (2 * area);
        for (corner = 0; corner < 3; corner++)
            for (axis = 0; axis < 2; axis++)
                of[corner][2 * node[corner] + axis] += by_squares * pull[corner][axis] - by_area * push[corner][axis];
    }
    for (k = 0; k < m; k++) {
        int64_t i = 2 * ends[k], j = 2 * ends[m + k];
        double dx = x[i] - x[j], dy = x[i + 1] - x[j + 1], length = sqrt(dx * dx + dy * dy), least, pulled;
        least = shortest * contact[k];
        length = length < least ? least : length;
        pulled = 2 * (length / contact[k] - 1) / (contact[k] * length);
        of[3][i] += pulled * dx;
        of[3][i + 1] += pulled * dy;
        of[4][j] += pulled * dx;
        of[4][j + 1] += pulled * dy;
    }
}

/* A step of nodes x (n, 2) down the gradient, with velocities v (n, 2), both in place.

The first `fixed` nodes have no way to go, the next ones, b of them, go along their tangents (b, 2). */
KERNEL int64_t descent_step(int64_t n, int64_t t, int64_t m, int64_t fixed, int64_t b, const int64_t *corners,
                            const double *d, const int64_t *ends, const double *contact, double flattest,
                            double worst, double shortest, const double *scale, const double *most, double weight,
                            double momentum, double step, double *x, double *v, const double *tangents)
{
    const struct links all = {n, t, m, corners, d, ends, contact};
    double *work = calloc((size_t)(10 * n + 1), sizeof *work);
    int64_t k, axis;
    if (!work)
        return NO_MEMORY;
    add_gradients(&all, x, flattest, worst, shortest, work);
    for (k = 0; k < n; k++) {
        double down[2], *vk = v + 2 * k, length, share;
        for (axis = 0; axis < 2; axis++) {
            const double *at = work + 2 * k + axis;
            double shape = at[0] + at[2 * n] + at[4 * n], lengths = at[6 * n] - at[8 * n];
            down[axis] = (shape + weight * lengths) * scale[k];
        }
        if (k < fixed) {
            down[0] = down[1] = vk[0] = vk[1] = 0;
        } else if (k < fixed + b) {
            const double *along = tangents + 2 * (k - fixed);
            double slope = down[0] * along[0] + down[1] * along[1], speed = vk[0] * along[0] + vk[1] * along[1];
            for (axis = 0; axis < 2; axis++) {
                down[axis] = slope * along[axis];
                vk[axis] = speed * along[axis];
            }
        }
        for (axis = 0; axis < 2; axis++)
            vk[axis] = momentum * vk[axis] - step * down[axis];
        length = sqrt(vk[0] * vk[0] + vk[1] * vk[1]);
        share = most[k] / (length < most[k] ? most[k] : length); /* what is no number stays none, as in NumPy */
        for (axis = 0; axis < 2; axis++) {
            vk[axis] *= share;
            x[2 * k + axis] += vk[axis];
        }
    }
    free(work);
    return DONE;
}
