/* Flips that make triangles Delaunay in a metric, and motion that inverts none; see ellipses.py. */
#include <stdlib.h>
#include <string.h>

#include "ellipses.h"

enum { HALVINGS = 4, MOST_TRIES = 40 };
enum { BLOCK = 64 }; /* edges whose forces are found side by side */

static double cross(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static int64_t node(const Sides *s, int64_t side, int64_t ahead)
{
    return s->triangles[side - side % 3 + (side + ahead) % 3];
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
static char is_wrong(const Sides *s, const double *x, const double *m, int64_t side, const Circles *circles)
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
    return value > circles->sure * scale && ca > circles->flattest * whole && bc > circles->flattest * whole;
}

static void join(Sides *s, int64_t side, int64_t twin, char fixed)
{
    s->twin[side] = twin;
    s->fixed[side] = fixed;
    if (twin >= 0) {
        s->twin[twin] = side;
        s->fixed[twin] = fixed;
    }
}

/* The edge at a side (a, b) between (a, b, c) and (b, a, e) becomes (e, c), between (a, e, c) and (e, b, c). */
static void flip(Sides *s, int64_t side)
{
    int64_t twin = s->twin[side], one = side - side % 3, two = twin - twin % 3, k = side % 3, k2 = twin % 3;
    int64_t a = node(s, side, 0), b = node(s, side, 1), c = node(s, side, 2), e = node(s, twin, 2);
    int64_t outer[4] = {two + (k2 + 1) % 3, one + (k + 2) % 3, two + (k2 + 2) % 3, one + (k + 1) % 3};
    int64_t twins[4], j, *row = s->triangles + one, *row2 = s->triangles + two;
    char fixed[4];
    for (j = 0; j < 4; j++) {
        twins[j] = s->twin[outer[j]];
        fixed[j] = s->fixed[outer[j]];
    }
    row[0] = a, row[1] = e, row[2] = c;
    row2[0] = e, row2[1] = b, row2[2] = c;
    join(s, one, twins[0], fixed[0]);     /* a, e */
    join(s, one + 2, twins[1], fixed[1]); /* c, a */
    join(s, two, twins[2], fixed[2]);     /* e, b */
    join(s, two + 1, twins[3], fixed[3]); /* b, c */
    join(s, one + 1, two + 2, 0);         /* e, c */
}

int64_t take_sides(Sides *s, int64_t n, int64_t t, int64_t *triangles, int64_t f, const int64_t *facets)
{
    int64_t sides = 3 * t;
    s->n = n, s->t = t, s->triangles = triangles;
    s->twin = malloc((size_t)(sides + 1) * sizeof *s->twin);
    s->chosen = malloc((size_t)(t + 1) * sizeof *s->chosen);
    s->fixed = calloc((size_t)(sides + 1), 1);
    s->wrong = calloc((size_t)(sides + 1), 1);
    s->changed = malloc((size_t)(t + 1));
    if (!(s->twin && s->chosen && s->fixed && s->wrong && s->changed && find_twins(s)))
        return NO_MEMORY;
    return fix_facets(s, f, facets);
}

void give_sides_back(Sides *s)
{
    free(s->twin);
    free(s->chosen);
    free(s->fixed);
    free(s->wrong);
    free(s->changed);
}

/* Tests the edge at a side again, under the lower number of its two sides. */
static void test_again(Sides *s, const double *x, const double *m, int64_t side, const Circles *circles)
{
    int64_t twin = s->twin[side], lower = twin >= 0 && twin < side ? twin : side;
    s->wrong[side] = 0;
    if (twin >= 0)
        s->wrong[twin] = 0;
    s->wrong[lower] = is_wrong(s, x, m, lower, circles);
}

/* The first side from one on that is wrong; 3 t if there is none. */
static int64_t next_wrong(const Sides *s, int64_t side)
{
    const char *found = memchr(s->wrong + side, 1, (size_t)(3 * s->t - side));
    return found ? found - s->wrong : 3 * s->t;
}

void flip_wrong(Sides *s, const double *x, const double *m, const Circles *circles)
{
    int64_t sides = 3 * s->t, side, k, j, pass;
    char *changed = s->changed;
    for (side = 0; side < sides; side++)
        s->wrong[side] = s->twin[side] > side && is_wrong(s, x, m, side, circles);
    memset(changed, 0, (size_t)s->t);
    for (pass = 0; pass < circles->passes; pass++) {
        int64_t number = 0;
        for (side = next_wrong(s, 0); side < sides; side = next_wrong(s, side + 1))
            if (!changed[side / 3] && !changed[s->twin[side] / 3]) {
                changed[side / 3] = changed[s->twin[side] / 3] = 1;
                s->chosen[2 * number] = side;
                s->chosen[2 * number++ + 1] = s->twin[side];
            }
        if (number == 0)
            break;
        for (k = 0; k < number; k++)
            flip(s, s->chosen[2 * k]);
        for (k = 0; k < 2 * number; k++) {
            int64_t triangle = s->chosen[k] / 3;
            changed[triangle] = 0;
            for (j = 0; j < 3; j++)
                test_again(s, x, m, 3 * triangle + j, circles);
        }
    }
}

int64_t list_edges(const Sides *s, int64_t *edges)
{
    int64_t side, count = 0;
    for (side = 0; side < 3 * s->t; side++)
        if (s->twin[side] < 0 || s->twin[side] > side) {
            edges[2 * count] = node(s, side, 0);
            edges[2 * count++ + 1] = node(s, side, 1);
        }
    return count;
}

/* Flips edges of triangles (t, 3) of n nodes as `flip_wrong`; the edges (3 t, 2) are written, with their number in count
   (1,). */
KERNEL int64_t metric_flips(int64_t n, int64_t t, int64_t *triangles, const double *x, const double *m, int64_t f,
                            const int64_t *facets, int64_t passes, double sure, double flattest, int64_t *edges,
                            int64_t *count)
{
    const Circles circles = {passes, sure, flattest};
    Sides s;
    int64_t status = take_sides(&s, n, t, triangles, f, facets);
    if (status == DONE) {
        flip_wrong(&s, x, m, &circles);
        *count = list_edges(&s, edges);
    }
    give_sides_back(&s);
    return status;
}

int make_room(Room *room, int64_t n, int64_t t)
{
    double *all = malloc((size_t)(2 * t + 11 * n + 1) * sizeof *all), *of_nodes = all + 2 * t;
    const Room made = {all, all, all + t, of_nodes, of_nodes + 2 * n, of_nodes + 3 * n, of_nodes + 5 * n,
                       of_nodes + 7 * n, of_nodes + 9 * n, malloc((size_t)(n + 1))};
    *room = made;
    return room->all && room->marked;
}

void leave_room(Room *room)
{
    free(room->all);
    free(room->marked);
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
        int bad = 0;
        for (k = 0; k < n; k++) {
            places[2 * k] = x[2 * k] + share[k] * move[2 * k];
            places[2 * k + 1] = x[2 * k + 1] + share[k] * move[2 * k + 1];
        }
        find_areas(t, triangles, places, next);
        memset(room->marked, 0, (size_t)n);
        for (k = 0; k < t; k++)
            if (next[k] < keep * area[k])
                for (bad = 1, j = 0; j < 3; j++)
                    room->marked[triangles[3 * k + j]] = 1;
        if (!bad) {
            memcpy(x, places, (size_t)(2 * n) * sizeof *x);
            room->area = next;
            room->next = area;
            return;
        }
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
    int64_t status = make_room(&room, n, t) ? DONE : NO_MEMORY;
    if (status == DONE) {
        move_guarded(n, t, triangles, x, move, keep, &room);
        memcpy(share, room.share, (size_t)n * sizeof *share);
    }
    leave_room(&room);
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
        l = (2 * sqrt(a * b) + (a + b) / 2) / 3;
        force = ((1.25 * l - 2.375) * l) * l + 1.125;
        force = (l < cutoff ? force : 0.0) / l;
        edges->fx[k] = force * dx;
        edges->fy[k] = force * dy;
    }
}

/* Adds to first (n, 2) the forces on the first ends of edges (e, 2), and to second (n, 2) those against the last ones. */
static void add_forces(int64_t e, const int32_t *ends, const double *x, const double *m, const Motion *motion,
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
        pull(&edges, motion->cutoff, motion->shortest);
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
                    const double *m, int64_t fixed, int64_t steps, const Motion *motion, double *speeds, Room *room)
{
    double *v = room->v, *move = room->move, *first = room->first, *second = room->second, dt = motion->dt;
    int64_t step, k;
    for (k = 0; k < 2 * n; k++)
        v[k] = 0;
    find_areas(t, triangles, x, room->area);
    for (step = 0; step < steps; step++) {
        double sum = 0;
        for (k = 0; k < 2 * n; k++)
            first[k] = second[k] = 0;
        add_forces(e, ends, x, m, motion, first, second);
        for (k = 0; k < n; k++) {
            double vx = (v[2 * k] + dt * (second[2 * k] - first[2 * k])) / (1 + motion->c * dt);
            double vy = (v[2 * k + 1] + dt * (second[2 * k + 1] - first[2 * k + 1])) / (1 + motion->c * dt);
            double far, part;
            if (k < fixed)
                vx = vy = 0;
            far = length_in(m + 3 * k, dt * vx, dt * vy);
            part = motion->most / (far > motion->most ? far : motion->most);
            v[2 * k] = part * vx;
            v[2 * k + 1] = part * vy;
            move[2 * k] = dt * v[2 * k];
            move[2 * k + 1] = dt * v[2 * k + 1];
        }
        move_by_areas(n, t, triangles, x, move, motion->keep, room);
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
    const Motion motion = {dt, c, cutoff, most, keep, shortest};
    int32_t *ends = n < INT32_MAX ? malloc((size_t)(2 * e + 1) * sizeof *ends) : NULL;
    Room room;
    int64_t k, status = make_room(&room, n, t) && ends ? DONE : NO_MEMORY;
    for (k = 0; k < 2 * e && status == DONE; k++)
        ends[k] = (int32_t)edges[k];
    if (status == DONE)
        relax_ellipses(n, t, triangles, e, ends, x, m, fixed, steps, &motion, speeds, &room);
    free(ends);
    leave_room(&room);
    return status;
}
