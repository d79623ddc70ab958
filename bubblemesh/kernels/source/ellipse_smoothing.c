/* Packing in a metric: smoothing that inverts no triangle; see ellipse_smoothing.py. */
#include <math.h>
#include <stdlib.h>

#include "ellipses.h"

/* Metrics around places (k, 2): roots (k, 3) that are linear from there, with slopes (k, 6) along their own axes. */
typedef struct {
    const double *places, *roots, *slopes;
} Metrics;

/* The root (3,) of a metric at (x, y), and the square of the distance from its place in the root there. */
static double root_at(const Metrics *m, int64_t k, double x, double y, double *root)
{
    const double *r = m->roots + 3 * k, *s = m->slopes + 6 * k;
    double cx = x - m->places[2 * k], cy = y - m->places[2 * k + 1];
    double f = r[0] * cx + r[1] * cy, g = r[2] * cy;
    root[0] = r[0] + (s[0] * f + s[3] * g);
    root[1] = r[1] + (s[1] * f + s[4] * g);
    root[2] = r[2] + (s[2] * f + s[5] * g);
    return f * f + g * g;
}

/* Triangles around the nodes that are smoothed, the metrics in which they count, two steps (n, 4) of length 1 in which
   each node goes, the roots (n, 3) of the nodes where they are now, and the costs (t,) of the sides across from the node
   that moves, which stay the same. */
typedef struct {
    const int64_t *triangles, *begin, *around;
    Metrics inside, own;
    const double *axes;
    double *x, *now, *across, weight, slack, bend, trust;
} Patches;

static double length_by(const double *root, double dx, double dy)
{
    double u = root[0] * dx + root[1] * dy, v = root[2] * dy;
    return sqrt(u * u + v * v);
}

/* Cost (l - 1 / l)^2 of the length l of the side between two nodes, by the metrics of both, beyond the slack. */
static double side_cost(const Patches *p, int64_t i, int64_t j)
{
    double dx = p->x[2 * j] - p->x[2 * i], dy = p->x[2 * j + 1] - p->x[2 * i + 1];
    double l = mean_length(length_by(p->now + 3 * i, dx, dy), length_by(p->now + 3 * j, dx, dy));
    double squared = l * l, beyond = squared + 1 / squared - 2 - p->slack;
    return beyond < 0 ? 0 : beyond;
}

/* Cost of the side between two nodes of a triangle while the node k moves. */
static double side_while(const Patches *p, int64_t triangle, int64_t k, int64_t i, int64_t j)
{
    return i == k || j == k ? side_cost(p, i, j) : p->across[triangle];
}

/* Cost of a triangle while its node k moves: Huber's function of eta^4 in the metric at its centroid, and those of its
   sides with a weight. Where the metric at the centroid is not known so far from its place, the cost is infinite. */
static double cost(const Patches *p, int64_t triangle, int64_t k)
{
    const int64_t *row = p->triangles + 3 * triangle;
    const double *a = p->x + 2 * row[0], *b = p->x + 2 * row[1], *o = p->x + 2 * row[2];
    double r[3], far = root_at(&p->inside, triangle, (a[0] + b[0] + o[0]) / 3, (a[1] + b[1] + o[1]) / 3, r);
    double ux = r[0] * (b[0] - a[0]) + r[1] * (b[1] - a[1]), uy = r[2] * (b[1] - a[1]);
    double wx = r[0] * (o[0] - a[0]) + r[1] * (o[1] - a[1]), wy = r[2] * (o[1] - a[1]);
    double zx = wx - ux, zy = wy - uy, area = (ux * wy - uy * wx) / 2;
    double eta, power, sides;
    if (!(r[0] > 0 && r[2] > 0 && area > 0 && far <= p->trust * p->trust))
        return INFINITY;
    eta = ((ux * ux + uy * uy) + (wx * wx + wy * wy) + (zx * zx + zy * zy)) / (6.9282032302755088 * area);
    power = eta * eta * (eta * eta);
    power = power > p->bend ? p->bend * (power - p->bend / 2) : power * power / 2;
    sides = side_while(p, triangle, k, row[0], row[1]) + side_while(p, triangle, k, row[1], row[2]) +
            side_while(p, triangle, k, row[2], row[0]);
    return power + p->weight * sides;
}

static void put(const Patches *p, int64_t k, double px, double py)
{
    p->x[2 * k] = px;
    p->x[2 * k + 1] = py;
    root_at(&p->own, k, px, py, p->now + 3 * k);
}

/* Sum of the costs of the triangles around a node at (px, py), where it is left. */
static double cost_at(const Patches *p, int64_t k, double px, double py)
{
    double sum = 0;
    int64_t j;
    put(p, k, px, py);
    for (j = p->begin[k]; j < p->begin[k + 1]; j++)
        sum += cost(p, p->around[j], k);
    return sum;
}

static void take_sides_across(const Patches *p, int64_t k)
{
    int64_t j;
    for (j = p->begin[k]; j < p->begin[k + 1]; j++) {
        const int64_t *row = p->triangles + 3 * p->around[j];
        int first = row[0] == k ? 1 : row[1] == k ? 2 : 0;
        p->across[p->around[j]] = side_cost(p, row[first], row[(first + 1) % 3]);
    }
}

/* Moves a node down: a step of Newton's method along both of its axes, shorter until the cost is less. */
static void improve(const Patches *p, int64_t k, double delta, double most, int64_t tries)
{
    const double *axis = p->axes + 4 * k;
    double ux = axis[0], uy = axis[1], vx = axis[2], vy = axis[3], px = p->x[2 * k], py = p->x[2 * k + 1];
    double here, ahead, behind, over, under, h1, h2, a, b, far, share;
    take_sides_across(p, k);
    here = cost_at(p, k, px, py);
    ahead = cost_at(p, k, px + delta * ux, py + delta * uy);
    behind = cost_at(p, k, px - delta * ux, py - delta * uy);
    over = cost_at(p, k, px + delta * vx, py + delta * vy);
    under = cost_at(p, k, px - delta * vx, py - delta * vy);
    h1 = (ahead + behind - 2 * here) / (delta * delta);
    h2 = (over + under - 2 * here) / (delta * delta);
    a = -(ahead - behind) / (2 * delta) / (h1 > 1 ? h1 : 1);
    b = -(over - under) / (2 * delta) / (h2 > 1 ? h2 : 1);
    if (!(isfinite(a) && isfinite(b)))
        tries = 0;
    far = sqrt(a * a + b * b);
    share = most / (far > most ? far : most);
    for (; tries > 0; tries--, share /= 2)
        if (cost_at(p, k, px + share * (a * ux + b * vx), py + share * (a * uy + b * vy)) < here)
            return;
    put(p, k, px, py);
}

/* Improves nodes x (n, 2) one by one in an order (count,), again and again, along their axes (n, 4), of which the second
   one may be 0. Metrics, as of `root_at`, are known around places inside the triangles (t, 3), and around those where the
   nodes are at first. */
KERNEL int64_t metric_smooth(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *inside,
                             const double *inside_roots, const double *inside_slopes, const double *own,
                             const double *own_roots, const double *own_slopes, const double *axes, int64_t count,
                             const int64_t *order, int64_t sweeps, double weight, double slack, double bend,
                             double trust, double delta, double most, int64_t tries)
{
    int64_t *begin = calloc((size_t)(n + 2), sizeof *begin), *around = malloc((size_t)(3 * t + 1) * sizeof *around);
    double *now = malloc((size_t)(3 * n + 1) * sizeof *now), *across = malloc((size_t)(t + 1) * sizeof *across);
    int64_t k, status = begin && around && now && across ? DONE : NO_MEMORY;
    if (status == DONE) {
        Patches p = {triangles, begin, around, {inside, inside_roots, inside_slopes}, {own, own_roots, own_slopes},
                     axes, x, now, across, weight, slack, bend, trust};
        for (k = 0; k < n; k++)
            put(&p, k, x[2 * k], x[2 * k + 1]);
        for (k = 0; k < 3 * t; k++)
            begin[triangles[k] + 2]++;
        for (k = 0; k < n; k++)
            begin[k + 2] += begin[k + 1];
        for (k = 0; k < 3 * t; k++)
            around[begin[triangles[k] + 1]++] = k / 3;
        for (; sweeps > 0; sweeps--)
            for (k = 0; k < count; k++)
                improve(&p, order[k], delta, most, tries);
    }
    free(begin);
    free(around);
    free(now);
    free(across);
    return status;
}
