/* Newton's method for shapes and lengths in a metric, which inverts no triangle; see newton.py. */
#include <math.h>
#include <stdlib.h>

#include "ellipses.h"

enum { LANES = 8 }; /* places of a node whose costs are found side by side */

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

/* Triangles (t, 3), the metrics in which they count, and the places (n, 2) of the nodes with the roots (n, 3) there. */
typedef struct {
    const int64_t *triangles;
    Metrics inside, own;
    double *x, *now, weight, slack, bend, trust;
    int64_t worst; /* whether the worst triangles count most */
} Triangles;

/* What is around each node that is smoothed: its triangles, from ``begin`` on, the spokes that go out from it, twice as
   many at most, and two steps (n, 4) of length 1 in which it goes. */
typedef struct {
    const int64_t *begin, *around;
    const int64_t *corner, *ahead, *behind; /* (3 t,): which corner of each triangle it is, the spokes beside it there */
    const int64_t *ends;                    /* (6 t,): the other ends of the spokes */
    const int64_t *spokes;                  /* (n,) of each node */
    const double *axes;
    double *along, *across; /* costs of the spokes at each place, and (3 t,) of the sides across from the node */
} Patches;

static double length_by(const double *root, double dx, double dy)
{
    double u = root[0] * dx + root[1] * dy, v = root[2] * dy;
    return sqrt(u * u + v * v);
}

/* Cost (l - 1 / l)^2 of the length l of the side between two nodes, by the metrics of both, beyond the slack. */
static double side_cost(const Triangles *all, int64_t i, int64_t j)
{
    const double *x = all->x, *now = all->now;
    double dx = x[2 * j] - x[2 * i], dy = x[2 * j + 1] - x[2 * i + 1];
    double l = mean_length(length_by(now + 3 * i, dx, dy), length_by(now + 3 * j, dx, dy));
    double squared = l * l, beyond = squared + 1 / squared - 2 - all->slack;
    return beyond < 0 ? 0 : beyond;
}

/* Term of a shape by ``power``, eta^4: by a power k of it, 2 or 8, up to the bend, and linear from there on. */
static double shape_term(double power, double bend, int worst)
{
    double curved = power > bend ? bend : power, square = curved * curved;
    double raised = worst ? square * square * (square * square) : square;
    return raised * (worst ? 0.125 : 0.5) + raised / curved * (power - curved);
}

/* Term of a triangle's shape in the metric at its centroid. Where that is not known so far from its place it is
   infinite. */
static double shape_cost(const Triangles *all, int64_t triangle)
{
    const int64_t *row = all->triangles + 3 * triangle;
    const double *a = all->x + 2 * row[0], *b = all->x + 2 * row[1], *o = all->x + 2 * row[2];
    double r[3], far = root_at(&all->inside, triangle, (a[0] + b[0] + o[0]) / 3, (a[1] + b[1] + o[1]) / 3, r);
    double ux = r[0] * (b[0] - a[0]) + r[1] * (b[1] - a[1]), uy = r[2] * (b[1] - a[1]);
    double wx = r[0] * (o[0] - a[0]) + r[1] * (o[1] - a[1]), wy = r[2] * (o[1] - a[1]);
    double zx = wx - ux, zy = wy - uy, area = (ux * wy - uy * wx) / 2, eta, power;
    if (!(r[0] > 0 && r[2] > 0 && area > 0 && far <= all->trust * all->trust))
        return INFINITY;
    eta = ((ux * ux + uy * uy) + (wx * wx + wy * wy) + (zx * zx + zy * zy)) / (6.9282032302755088 * area);
    power = eta * eta * (eta * eta);
    return shape_term(power, all->bend, all->worst != 0);
}

static void put(const Triangles *all, int64_t k, double px, double py)
{
    all->x[2 * k] = px;
    all->x[2 * k + 1] = py;
    root_at(&all->own, k, px, py, all->now + 3 * k);
}

/* Sums of the costs of the triangles around a node at places (2, LANES), each as `metric_costs` has it. */
SIDE_BY_SIDE static void sum_costs(const Triangles *all, const Patches *p, int64_t k, const double (*place)[LANES],
                                   double *sum)
{
    const double *r = all->own.roots + 3 * k, *s = all->own.slopes + 6 * k, *from = all->own.places + 2 * k;
    const double slack = all->slack, trust = all->trust * all->trust, bend = all->bend, weight = all->weight;
    const int worst = all->worst != 0;
    double root[3][LANES];
    int64_t j;
    int l, c;
    for (l = 0; l < LANES; l++) {
        double cx = place[0][l] - from[0], cy = place[1][l] - from[1], f = r[0] * cx + r[1] * cy, g = r[2] * cy;
        for (c = 0; c < 3; c++)
            root[c][l] = r[c] + (s[c] * f + s[c + 3] * g);
        sum[l] = 0;
    }
    for (j = 0; j < p->spokes[k]; j++) {
        int64_t end = p->ends[2 * p->begin[k] + j];
        double ex = all->x[2 * end], ey = all->x[2 * end + 1], *along = p->along + LANES * j;
        const double *there = all->now + 3 * end;
        for (l = 0; l < LANES; l++) {
            double dx = ex - place[0][l], dy = ey - place[1][l], squared, beyond;
            double u = root[0][l] * dx + root[1][l] * dy, v = root[2][l] * dy;
            double u2 = there[0] * dx + there[1] * dy, v2 = there[2] * dy;
            double length = mean_length(sqrt(u * u + v * v), sqrt(u2 * u2 + v2 * v2));
            squared = length * length;
            beyond = squared + 1 / squared - 2 - slack;
            along[l] = beyond < 0 ? 0 : beyond;
        }
    }
    for (j = p->begin[k]; j < p->begin[k + 1]; j++) {
        int64_t triangle = p->around[j], corner = p->corner[j];
        const int64_t *row = all->triangles + 3 * triangle;
        const double *sides[3]; /* in the order of the triangle's corners, in which they are summed */
        double across[LANES], at[3][2][LANES];
        r = all->inside.roots + 3 * triangle, s = all->inside.slopes + 6 * triangle;
        from = all->inside.places + 2 * triangle;
        for (c = 0; c < 3; c++)
            for (l = 0; l < LANES; l++) {
                at[c][0][l] = c == corner ? place[0][l] : all->x[2 * row[c]];
                at[c][1][l] = c == corner ? place[1][l] : all->x[2 * row[c] + 1];
            }
        for (l = 0; l < LANES; l++)
            across[l] = p->across[j];
        sides[corner] = p->along + LANES * p->ahead[j];
        sides[(corner + 1) % 3] = across;
        sides[(corner + 2) % 3] = p->along + LANES * p->behind[j];
        for (l = 0; l < LANES; l++) {
            double ax = at[0][0][l], ay = at[0][1][l], bx = at[1][0][l], by = at[1][1][l];
            double ox = at[2][0][l], oy = at[2][1][l];
            double cx = (ax + bx + ox) / 3 - from[0], cy = (ay + by + oy) / 3 - from[1];
            double f = r[0] * cx + r[1] * cy, g = r[2] * cy;
            double r11 = r[0] + (s[0] * f + s[3] * g), r12 = r[1] + (s[1] * f + s[4] * g);
            double r22 = r[2] + (s[2] * f + s[5] * g);
            double ux = r11 * (bx - ax) + r12 * (by - ay), uy = r22 * (by - ay);
            double wx = r11 * (ox - ax) + r12 * (oy - ay), wy = r22 * (oy - ay);
            double zx = wx - ux, zy = wy - uy, area = (ux * wy - uy * wx) / 2, far = f * f + g * g;
            double eta = ((ux * ux + uy * uy) + (wx * wx + wy * wy) + (zx * zx + zy * zy)) / (6.9282032302755088 * area);
            double power = eta * eta * (eta * eta);
            double cost = shape_term(power, bend, worst) + weight * (sides[0][l] + sides[1][l] + sides[2][l]);
            int known = (r11 > 0) & (r22 > 0) & (area > 0) & (far <= trust);
            sum[l] += known ? cost : INFINITY;
        }
    }
}

static void take_sides_across(const Triangles *all, const Patches *p, int64_t k)
{
    int64_t j;
    for (j = p->begin[k]; j < p->begin[k + 1]; j++) {
        const int64_t *ends = p->ends + 2 * p->begin[k];
        p->across[j] = side_cost(all, ends[p->ahead[j]], ends[p->behind[j]]);
    }
}

/* Moves a node down: a step of Newton's method along both of its axes, shorter until the cost is less. */
static void improve(const Triangles *all, const Patches *p, int64_t k, double delta, double most, int64_t tries)
{
    const double *axis = p->axes + 4 * k;
    double ux = axis[0], uy = axis[1], vx = axis[2], vy = axis[3], px = all->x[2 * k], py = all->x[2 * k + 1];
    double ahead = delta * ux, aside = delta * uy, over = delta * vx, up = delta * vy;
    double place[2][LANES] = {{px, px + ahead, px - ahead, px + over, px - over, px, px, px},
                              {py, py + aside, py - aside, py + up, py - up, py, py, py}};
    double sum[LANES], here, h1, h2, a, b, far, share;
    int l;
    take_sides_across(all, p, k);
    sum_costs(all, p, k, place, sum);
    here = sum[0];
    h1 = (sum[1] + sum[2] - 2 * here) / (delta * delta);
    h2 = (sum[3] + sum[4] - 2 * here) / (delta * delta);
    a = -(sum[1] - sum[2]) / (2 * delta) / (h1 > 1 ? h1 : 1);
    b = -(sum[3] - sum[4]) / (2 * delta) / (h2 > 1 ? h2 : 1);
    if (!(isfinite(a) && isfinite(b)))
        return;
    far = sqrt(a * a + b * b);
    share = most / (far > most ? far : most);
    for (l = 0; l < LANES; l++, share /= 2) {
        place[0][l] = px + share * (a * ux + b * vx);
        place[1][l] = py + share * (a * uy + b * vy);
    }
    sum_costs(all, p, k, place, sum);
    for (l = 0; l < tries && l < LANES; l++)
        if (sum[l] < here) {
            put(all, k, place[0][l], place[1][l]);
            return;
        }
}

/* The spoke from a node to an end, by its number among those that are known, or as a new one. */
static int64_t spoke_to(int64_t end, int64_t *ends, int64_t *count)
{
    int64_t j;
    for (j = 0; j < *count && ends[j] != end; j++)
        ;
    if (j == *count)
        ends[(*count)++] = end;
    return j;
}

/* Improves nodes x (n, 2) one by one in an order (count,), again and again, along their axes (n, 4), of which the second
   one may be 0. Metrics, as of `root_at`, are known around places inside the triangles (t, 3), and around those where the
   nodes are at first. */
KERNEL int64_t metric_smooth(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *inside,
                             const double *inside_roots, const double *inside_slopes, const double *own,
                             const double *own_roots, const double *own_slopes, const double *axes, int64_t count,
                             const int64_t *order, int64_t sweeps, double weight, double slack, double bend,
                             double trust, int64_t worst, double delta, double most, int64_t tries)
{
    int64_t *begin = calloc((size_t)(2 * n + 2), sizeof *begin), *spokes = begin ? begin + n + 2 : NULL;
    int64_t *around = malloc((size_t)(18 * t + 1) * sizeof *around), *corner = around + 3 * t, *ahead = around + 6 * t;
    int64_t *behind = around + 9 * t, *ends = around + 12 * t;
    double *now = malloc((size_t)(3 * n + (3 + 6 * LANES) * t + 1) * sizeof *now), *across = now + 3 * n;
    double *along = across + 3 * t;
    int64_t k, j, status = begin && around && now ? DONE : NO_MEMORY;
    if (status == DONE) {
        const Triangles all = {triangles, {inside, inside_roots, inside_slopes}, {own, own_roots, own_slopes},
                               x, now, weight, slack, bend, trust, worst};
        const Patches p = {begin, around, corner, ahead, behind, ends, spokes, axes, along, across};
        for (k = 0; k < n; k++)
            put(&all, k, x[2 * k], x[2 * k + 1]);
        for (k = 0; k < 3 * t; k++)
            begin[triangles[k] + 2]++;
        for (k = 0; k < n; k++)
            begin[k + 2] += begin[k + 1];
        for (k = 0; k < 3 * t; k++) {
            j = begin[triangles[k] + 1]++;
            around[j] = k / 3;
            corner[j] = k % 3;
        }
        for (k = 0; k < n; k++)
            for (j = begin[k]; j < begin[k + 1]; j++) {
                const int64_t *row = triangles + 3 * around[j];
                ahead[j] = spoke_to(row[(corner[j] + 1) % 3], ends + 2 * begin[k], spokes + k);
                behind[j] = spoke_to(row[(corner[j] + 2) % 3], ends + 2 * begin[k], spokes + k);
            }
        for (; sweeps > 0; sweeps--)
            for (k = 0; k < count; k++)
                improve(&all, &p, order[k], delta, most, tries);
    }
    free(begin);
    free(around);
    free(now);
    return status;
}

/* Costs (t,) of triangles (t, 3) of nodes x (n, 2), in metrics as of `metric_smooth`. */
KERNEL int64_t metric_costs(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *inside,
                            const double *inside_roots, const double *inside_slopes, const double *own,
                            const double *own_roots, const double *own_slopes, double weight, double slack,
                            double bend, double trust, int64_t worst, double *costs)
{
    double *now = malloc((size_t)(3 * n + 1) * sizeof *now);
    const Triangles all = {triangles, {inside, inside_roots, inside_slopes}, {own, own_roots, own_slopes},
                           x, now, weight, slack, bend, trust, worst};
    int64_t k;
    if (!now)
        return NO_MEMORY;
    for (k = 0; k < n; k++)
        root_at(&all.own, k, x[2 * k], x[2 * k + 1], now + 3 * k);
    for (k = 0; k < t; k++) {
        const int64_t *row = triangles + 3 * k;
        double shape = shape_cost(&all, k), sides = side_cost(&all, row[0], row[1]) + side_cost(&all, row[1], row[2]);
        costs[k] = shape < INFINITY ? shape + weight * (sides + side_cost(&all, row[2], row[0])) : INFINITY;
    }
    free(now);
    return DONE;
}

/* Groups (n,) of the ``chosen`` (n,) among nodes of triangles (t, 3), -1 of the others: of each, in the order of their
   numbers, the first group in which none of its neighbours is. */
KERNEL int64_t first_groups(int64_t n, int64_t t, const int64_t *triangles, const char *chosen, int64_t *groups)
{
    int64_t *begin = calloc((size_t)(n + 2), sizeof *begin), *around = malloc((size_t)(3 * t + 1) * sizeof *around);
    int64_t *taken = malloc((size_t)(n + 1) * sizeof *taken); /* by which node each group was found taken */
    int64_t k, j, status = begin && around && taken ? DONE : NO_MEMORY;
    if (status == DONE) {
        for (k = 0; k < 3 * t; k++)
            begin[triangles[k] + 2]++;
        for (k = 0; k < n; k++) {
            begin[k + 2] += begin[k + 1];
            groups[k] = taken[k] = -1;
        }
        for (k = 0; k < 3 * t; k++)
            around[begin[triangles[k] + 1]++] = k / 3;
        for (k = 0; k < n; k++) {
            int64_t group = 0;
            if (!chosen[k])
                continue;
            for (j = 3 * begin[k]; j < 3 * begin[k + 1]; j++) {
                int64_t other = groups[triangles[3 * around[j / 3] + j % 3]];
                if (other >= 0)
                    taken[other] = k;
            }
            while (taken[group] == k)
                group++;
            groups[k] = group;
        }
    }
    free(begin);
    free(around);
    free(taken);
    return status;
}
