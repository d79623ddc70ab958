/* Flips of edges that make triangles Delaunay in a metric; see ellipse_flips.py. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "ellipses.h"

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
    r22 = sqrt(r22 > DBL_MIN ? r22 : DBL_MIN);
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

int64_t list_side_edges(const Sides *s, int64_t *edges)
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
        *count = list_side_edges(&s, edges);
    }
    give_sides_back(&s);
    return status;
}
