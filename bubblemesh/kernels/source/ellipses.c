/* Packing in a metric: flips that make triangles Delaunay in it, motion and smoothing that invert none; see
   ellipses.py. A tensor is (m11, m12, m22). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

enum { HALVINGS = 4, MOST_TRIES = 40 };

static double cross(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Sides are numbered k * t + triangle: from the triangle's node k to the next one. */
typedef struct {
    int64_t n, t, *triangles, *twin;
    char *fixed, *wrong;
} Sides;

static int64_t node(const Sides *s, int64_t side, int64_t ahead)
{
    return s->triangles[3 * (side % s->t) + (side / s->t + ahead) % 3];
}

/* The twin of each side, by chains of the sides that begin at each node. */
static int find_twins(Sides *s)
{
    int64_t sides = 3 * s->t, side, other;
    int64_t *first = malloc((size_t)(s->n + 1) * sizeof *first), *next = malloc((size_t)(sides + 1) * sizeof *next);
    int enough = first && next;
    if (enough) {
        for (side = 0; side < s->n; side++)
            first[side] = -1;
        for (side = 0; side < sides; side++) {
            int64_t begin = node(s, side, 0);
            next[side] = first[begin];
            first[begin] = side;
        }
        for (side = 0; side < sides; side++) {
            int64_t begin = node(s, side, 0);
            for (other = first[node(s, side, 1)]; other >= 0 && node(s, other, 1) != begin; other = next[other])
                ;
            s->twin[side] = other;
        }
    }
    free(first);
    free(next);
    return enough;
}

/* Marks the sides along facets (m, 2), which stay; NO_MEMORY or DONE. */
static int64_t fix_facets(Sides *s, int64_t m, const int64_t *facets)
{
    int64_t sides = 3 * s->t, side, k;
    int64_t *first = malloc((size_t)(s->n + 1) * sizeof *first), *next = malloc((size_t)(2 * m + 1) * sizeof *next);
    int64_t status = first && next ? DONE : NO_MEMORY;
    if (status == DONE) {
        for (k = 0; k < s->n; k++)
            first[k] = -1;
        for (k = 0; k < 2 * m; k++) {
            int64_t begin = facets[k];
            next[k] = first[begin];
            first[begin] = k;
        }
        for (side = 0; side < sides; side++) {
            int64_t end = node(s, side, 1);
            for (k = first[node(s, side, 0)]; k >= 0 && facets[k ^ 1] != end; k = next[k])
                ;
            s->fixed[side] = k >= 0;
        }
    }
    free(first);
    free(next);
    return status;
}

/* Whether the edge at a side should be flipped: the circle test in the sum of the metrics at the four nodes. */
static char is_wrong(const Sides *s, const double *x, const double *m, int64_t side, double sure, double flattest)
{
    int64_t twin = s->twin[side], k, a, b, c, e, four[4];
    double sum[3], r11, r12, r22, p[3][2], bc, ca, ab, aa, bb, cc, value, scale, whole;
    if (twin < 0 || s->fixed[side])
        return 0;
    if (twin < side)
        side = twin, twin = s->twin[side];
    a = node(s, side, 0), b = node(s, side, 1), c = node(s, side, 2), e = node(s, twin, 2);
    for (k = 0; k < 3; k++)
        sum[k] = m[3 * a + k] + m[3 * b + k] + m[3 * c + k] + m[3 * e + k];
    r11 = sqrt(sum[0]);
    r12 = sum[1] / r11;
    r22 = sum[2] - r12 * r12;
    r22 = sqrt(r22 > 2.2250738585072014e-308 ? r22 : 2.2250738585072014e-308);
    four[0] = a, four[1] = b, four[2] = c;
    for (k = 0; k < 3; k++) {
        double dx = x[2 * four[k]] - x[2 * e], dy = x[2 * four[k] + 1] - x[2 * e + 1];
        p[k][0] = r11 * dx + r12 * dy;
        p[k][1] = r22 * dy;
    }
    bc = p[1][0] * p[2][1] - p[1][1] * p[2][0];
    ca = p[2][0] * p[0][1] - p[2][1] * p[0][0];
    ab = p[0][0] * p[1][1] - p[0][1] * p[1][0];
    aa = p[0][0] * p[0][0] + p[0][1] * p[0][1];
    bb = p[1][0] * p[1][0] + p[1][1] * p[1][1];
    cc = p[2][0] * p[2][0] + p[2][1] * p[2][1];
    value = aa * bc + bb * ca + cc * ab;
    scale = aa * fabs(bc) + bb * fabs(ca) + cc * fabs(ab);
    whole = fabs(ca) + fabs(bc);
    return value > sure * scale && ca > flattest * whole && bc > flattest * whole;
}

static void join(Sides *s, int64_t side, int64_t twin, char fixed)
{
    s->twin[side] = twin;
    s->fixed[side] = fixed;
    if (twin >= 0)
        s->twin[twin] = side;
}

/* The edge at a side (a, b) between (a, b, c) and (b, a, e) becomes (e, c), between (a, e, c) and (e, b, c). */
static void flip(Sides *s, int64_t side)
{
    int64_t t = s->t, twin = s->twin[side], one = side % t, two = twin % t, k = side / t, k2 = twin / t;
    int64_t a = node(s, side, 0), b = node(s, side, 1), c = node(s, side, 2), e = node(s, twin, 2);
    int64_t outer[4] = {(k2 + 1) % 3 * t + two, (k + 2) % 3 * t + one, (k2 + 2) % 3 * t + two, (k + 1) % 3 * t + one};
    int64_t twins[4], j, *row = s->triangles + 3 * one, *row2 = s->triangles + 3 * two;
    char fixed[4];
    for (j = 0; j < 4; j++) {
        twins[j] = s->twin[outer[j]];
        fixed[j] = s->fixed[outer[j]];
    }
    row[0] = a, row[1] = e, row[2] = c;
    row2[0] = e, row2[1] = b, row2[2] = c;
    join(s, one, twins[0], fixed[0]);         /* a, e */
    join(s, 2 * t + one, twins[1], fixed[1]); /* c, a */
    join(s, two, twins[2], fixed[2]);         /* e, b */
    join(s, t + two, twins[3], fixed[3]);     /* b, c */
    join(s, t + one, 2 * t + two, 0);         /* e, c */
}

/* Flips edges of triangles (t, 3) of n nodes at x (n, 2) with tensors m (n, 3) until all but those along facets (f, 2)
   pass the circle test, in passes in which no triangle changes twice; the edges (3 t, 2) are written, with their number
   in count (1,). */
KERNEL int64_t metric_flips(int64_t n, int64_t t, int64_t *triangles, const double *x, const double *m, int64_t f,
                            const int64_t *facets, int64_t passes, double sure, double flattest, int64_t *edges,
                            int64_t *count)
{
    int64_t sides = 3 * t, side, k, pass, status = NO_MEMORY;
    Sides s = {n, t, triangles, NULL, NULL, NULL};
    int64_t *chosen = malloc((size_t)(t + 1) * sizeof *chosen);
    char *changed = malloc((size_t)(t + 1));
    s.twin = malloc((size_t)(sides + 1) * sizeof *s.twin);
    s.fixed = calloc((size_t)(sides + 1), 1);
    s.wrong = calloc((size_t)(sides + 1), 1);
    if (chosen && changed && s.twin && s.fixed && s.wrong && find_twins(&s))
        status = fix_facets(&s, f, facets);
    if (status == DONE) {
        for (side = 0; side < sides; side++)
            if (s.twin[side] > side)
                s.wrong[side] = is_wrong(&s, x, m, side, sure, flattest);
        for (pass = 0; pass < passes; pass++) {
            int64_t number = 0;
            memset(changed, 0, (size_t)t);
            for (side = 0; side < sides; side++)
                if (s.wrong[side] && !changed[side % t] && !changed[s.twin[side] % t]) {
                    changed[side % t] = changed[s.twin[side] % t] = 1;
                    chosen[number++] = side;
                }
            if (number == 0)
                break;
            for (k = 0; k < number; k++)
                flip(&s, chosen[k]);
            for (side = 0; side < sides; side++)
                if (changed[side % t] || (s.twin[side] >= 0 && changed[s.twin[side] % t]))
                    s.wrong[side] = s.twin[side] > side && is_wrong(&s, x, m, side, sure, flattest);
        }
        *count = 0;
        for (side = 0; side < sides; side++)
            if (s.twin[side] < 0 || s.twin[side] > side) {
                edges[2 * *count] = node(&s, side, 0);
                edges[2 * (*count)++ + 1] = node(&s, side, 1);
            }
    }
    free(chosen);
    free(changed);
    free(s.twin);
    free(s.fixed);
    free(s.wrong);
    return status;
}

/* Moves nodes x (n, 2) by share * move (n, 2) with the largest shares (n,), up to 1, that leave to each triangle (t, 3)
   at least its part of ``least`` (t,); where halving does not help, nodes stay. */
static void guarded(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *move, double keep,
                    double *share, double *least, double *places, char *marked)
{
    int64_t k, j, tries;
    for (k = 0; k < n; k++)
        share[k] = 1;
    for (k = 0; k < t; k++)
        least[k] = keep * cross(x + 2 * triangles[3 * k], x + 2 * triangles[3 * k + 1], x + 2 * triangles[3 * k + 2]);
    for (tries = 0; tries < MOST_TRIES; tries++) {
        int bad = 0;
        for (k = 0; k < n; k++) {
            places[2 * k] = x[2 * k] + share[k] * move[2 * k];
            places[2 * k + 1] = x[2 * k + 1] + share[k] * move[2 * k + 1];
            marked[k] = 0;
        }
        for (k = 0; k < t; k++) {
            const int64_t *row = triangles + 3 * k;
            if (cross(places + 2 * row[0], places + 2 * row[1], places + 2 * row[2]) < least[k])
                for (bad = 1, j = 0; j < 3; j++)
                    marked[row[j]] = 1;
        }
        if (!bad) {
            memcpy(x, places, (size_t)(2 * n) * sizeof *x);
            return;
        }
        for (k = 0; k < n; k++)
            if (marked[k])
                share[k] = tries < HALVINGS ? share[k] / 2 : 0;
    }
    for (k = 0; k < n; k++)
        share[k] = 0;
}

/* Moves nodes as `guarded`; shares (n,) are written. */
KERNEL int64_t guarded_move(int64_t n, int64_t t, const int64_t *triangles, double *x, const double *move, double keep,
                            double *share)
{
    double *work = malloc((size_t)(t + 2 * n + 1) * sizeof *work);
    char *marked = malloc((size_t)(n + 1));
    int64_t status = work && marked ? DONE : NO_MEMORY;
    if (status == DONE)
        guarded(n, t, triangles, x, move, keep, share, work, work + t, marked);
    free(work);
    free(marked);
    return status;
}

static double length_in(const double *m, double dx, double dy)
{
    double squared = m[0] * dx * dx + 2 * (m[1] * dx * dy) + m[2] * dy * dy;
    return sqrt(squared > 0 ? squared : 0);
}

/* Length of an edge that is a and b long in the metrics of its ends: nearly the logarithmic mean. */
static double mean_length(double a, double b)
{
    return (2 * sqrt(a * b) + (a + b) / 2) / 3;
}

/* Steps of the motion of nodes x (n, 2) with tensors m (n, 3) under forces along edges (e, 2), with damping c and time
   step dt; the first ``fixed`` nodes stay, none goes farther in a step than ``most`` in its tensor, and no triangle
   (t, 3) keeps less than ``keep`` of its area. The mean speeds in the metric come out (steps,). */
KERNEL int64_t metric_relax(int64_t n, int64_t t, const int64_t *triangles, int64_t e, const int64_t *edges, double *x,
                            const double *m, int64_t fixed, int64_t steps, double dt, double c, double cutoff,
                            double most, double keep, double shortest, double *speeds)
{
    double *work = malloc((size_t)(t + 11 * n + 1) * sizeof *work);
    double *least = work, *places = least + t, *share = places + 2 * n, *v = share + n, *move = v + 2 * n;
    double *first = move + 2 * n, *second = first + 2 * n;
    char *marked = malloc((size_t)(n + 1));
    int64_t status = work && marked ? DONE : NO_MEMORY, step, k;
    for (k = 0; status == DONE && k < 2 * n; k++)
        v[k] = 0;
    for (step = 0; status == DONE && step < steps; step++) {
        double sum = 0;
        for (k = 0; k < 2 * n; k++)
            first[k] = second[k] = 0;
        for (k = 0; k < e; k++) {
            int64_t i = edges[2 * k], j = edges[2 * k + 1];
            double dx = x[2 * j] - x[2 * i], dy = x[2 * j + 1] - x[2 * i + 1];
            double li = length_in(m + 3 * i, dx, dy), lj = length_in(m + 3 * j, dx, dy), l, force;
            li = li > shortest ? li : shortest;
            lj = lj > shortest ? lj : shortest;
            l = mean_length(li, lj);
            if (!(l < cutoff))
                continue;
            force = ((1.25 * l - 2.375) * l) * l + 1.125;
            force /= l;
            first[2 * i] += force * dx;
            first[2 * i + 1] += force * dy;
            second[2 * j] += force * dx;
            second[2 * j + 1] += force * dy;
        }
        for (k = 0; k < n; k++) {
            double vx = (v[2 * k] + dt * (second[2 * k] - first[2 * k])) / (1 + c * dt);
            double vy = (v[2 * k + 1] + dt * (second[2 * k + 1] - first[2 * k + 1])) / (1 + c * dt);
            double far, part;
            if (k < fixed)
                vx = vy = 0;
            far = length_in(m + 3 * k, dt * vx, dt * vy);
            part = most / (far > most ? far : most);
            v[2 * k] = part * vx;
            v[2 * k + 1] = part * vy;
            move[2 * k] = dt * v[2 * k];
            move[2 * k + 1] = dt * v[2 * k + 1];
        }
        guarded(n, t, triangles, x, move, keep, share, least, places, marked);
        for (k = 0; k < n; k++) {
            v[2 * k] *= share[k];
            v[2 * k + 1] *= share[k];
            sum += length_in(m + 3 * k, v[2 * k], v[2 * k + 1]);
        }
        speeds[step] = sum / (double)n;
    }
    free(work);
    free(marked);
    return status;
}

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
   each node goes, and the roots (n, 3) of the nodes where they are now. */
typedef struct {
    const int64_t *triangles, *begin, *around;
    Metrics inside, own;
    const double *axes;
    double *x, *now, weight, trust;
} Patches;

static double length_by(const double *root, double dx, double dy)
{
    double u = root[0] * dx + root[1] * dy, v = root[2] * dy;
    return sqrt(u * u + v * v);
}

/* Square of the length of the side between two nodes, by the metrics of both. */
static double squared_side(const Patches *p, int64_t i, int64_t j)
{
    double dx = p->x[2 * j] - p->x[2 * i], dy = p->x[2 * j + 1] - p->x[2 * i + 1];
    double l = mean_length(length_by(p->now + 3 * i, dx, dy), length_by(p->now + 3 * j, dx, dy));
    return l * l;
}

/* Cost of a triangle: eta^4 in the metric at its centroid, and l^2 + 1 / l^2 - 2 of its sides, in the metrics of their
   ends, with a weight. Where the metric at the centroid is not known so far from its place, the cost is infinite. */
static double cost(const Patches *p, int64_t triangle)
{
    const int64_t *row = p->triangles + 3 * triangle;
    const double *a = p->x + 2 * row[0], *b = p->x + 2 * row[1], *o = p->x + 2 * row[2];
    double r[3], far = root_at(&p->inside, triangle, (a[0] + b[0] + o[0]) / 3, (a[1] + b[1] + o[1]) / 3, r);
    double ux = r[0] * (b[0] - a[0]) + r[1] * (b[1] - a[1]), uy = r[2] * (b[1] - a[1]);
    double wx = r[0] * (o[0] - a[0]) + r[1] * (o[1] - a[1]), wy = r[2] * (o[1] - a[1]);
    double zx = wx - ux, zy = wy - uy, area = (ux * wy - uy * wx) / 2;
    double eta, ab, bo, oa;
    if (!(r[0] > 0 && r[2] > 0 && area > 0 && far <= p->trust * p->trust))
        return INFINITY;
    eta = ((ux * ux + uy * uy) + (wx * wx + wy * wy) + (zx * zx + zy * zy)) / (6.9282032302755088 * area);
    ab = squared_side(p, row[0], row[1]), bo = squared_side(p, row[1], row[2]), oa = squared_side(p, row[2], row[0]);
    return eta * eta * (eta * eta) + p->weight * ((ab + 1 / ab) + (bo + 1 / bo) + (oa + 1 / oa) - 6);
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
        sum += cost(p, p->around[j]);
    return sum;
}

/* Moves a node down: a step of Newton's method along both of its axes, shorter until the cost is less. */
static void improve(const Patches *p, int64_t k, double delta, double most, int64_t tries)
{
    const double *axis = p->axes + 4 * k;
    double ux = axis[0], uy = axis[1], vx = axis[2], vy = axis[3], px = p->x[2 * k], py = p->x[2 * k + 1];
    double here = cost_at(p, k, px, py), far, share;
    double ahead = cost_at(p, k, px + delta * ux, py + delta * uy);
    double behind = cost_at(p, k, px - delta * ux, py - delta * uy);
    double over = cost_at(p, k, px + delta * vx, py + delta * vy);
    double under = cost_at(p, k, px - delta * vx, py - delta * vy);
    double h1 = (ahead + behind - 2 * here) / (delta * delta), h2 = (over + under - 2 * here) / (delta * delta);
    double a = -(ahead - behind) / (2 * delta) / (h1 > 1 ? h1 : 1), b = -(over - under) / (2 * delta) / (h2 > 1 ? h2 : 1);
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
                             const int64_t *order, int64_t sweeps, double weight, double trust, double delta,
                             double most, int64_t tries)
{
    int64_t *begin = calloc((size_t)(n + 2), sizeof *begin), *around = malloc((size_t)(3 * t + 1) * sizeof *around);
    double *now = malloc((size_t)(3 * n + 1) * sizeof *now);
    int64_t k, status = begin && around && now ? DONE : NO_MEMORY;
    if (status == DONE) {
        Patches p = {triangles, begin, around, {inside, inside_roots, inside_slopes}, {own, own_roots, own_slopes},
                     axes, x, now, weight, trust};
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
    return status;
}
