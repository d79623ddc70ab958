/* Shapes of triangles, and gradients of these and of the lengths of edges; see shapes.py. */
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

/* Gradient (n, 2) for triangles with nodes corners (3, t) and edges with ends (2, m), at x (n, 2). */
KERNEL int64_t shape_gradient(int64_t n, int64_t t, int64_t m, const double *x, const double *d,
                              const int64_t *corners, double flattest, double worst, const int64_t *ends,
                              const double *contact, double shortest, double weight, double *gradient)
{
    double *work = calloc((size_t)(10 * n + 1), sizeof *work), *of[5];
    int64_t k, axis;
    if (!work)
        return NO_MEMORY;
    for (k = 0; k < 5; k++)
        of[k] = work + 2 * n * k; /* at the three corners, at the first and at the last end */
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
    for (k = 0; k < 2 * n; k++)
        gradient[k] = of[0][k] + of[1][k] + of[2][k] + weight * (of[3][k] - of[4][k]);
    free(work);
    return DONE;
}
