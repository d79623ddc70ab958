/* Cycles of annealing: displacements where the order is broken, flips, and relaxations; see annealing.py. */
#include <stdlib.h>
#include <string.h>

#include "disorder.h"
#include "relaxing.h"
#include "triangles.h"

enum { REGULAR_VALENCE = 6 };

/* Bubbles (n, 2) with the spacings d (n,), of which the first ones are on the boundary. */
typedef struct {
    int64_t n, fixed;
    double *x;
    const double *d;
    const char *calm; /* (n,): whether they are not displaced */
} Bubbles;

/* Buffers that all cycles use. */
typedef struct {
    double *v, *contact;
    int32_t *ends;
    int32_t *valence;
    char *near;
} Work;

void mark_disorder(int64_t n, int64_t fixed, int64_t m, const int64_t *edges, int32_t *valence, char *near)
{
    int64_t k;
    memset(valence, 0, (size_t)n * sizeof *valence);
    for (k = 0; k < 2 * m; k++)
        valence[edges[k]]++;
    for (k = 0; k < n; k++) {
        near[k] = valence[k] != REGULAR_VALENCE ? DISORDERED : 0;
        valence[k] = near[k] | (k < fixed ? BESIDE_BOUNDARY : 0);
    }
    for (k = 0; k < m; k++) {
        int64_t i = edges[2 * k], j = edges[2 * k + 1];
        near[i] |= (char)valence[j];
        near[j] |= (char)valence[i];
    }
}

/* Displaces marked bubbles by random lengths of standard deviations ``inside``, or ``beside`` the boundary, in terms of
   their spacing. */
static void displace(const Bubbles *bubbles, const char *near, const Chance *chance, double inside, double beside)
{
    int64_t k;
    for (k = bubbles->fixed; k < bubbles->n; k++)
        if (near[k] & DISORDERED && !bubbles->calm[k]) {
            double scale = (near[k] & BESIDE_BOUNDARY ? beside : inside) * bubbles->d[k];
            uint64_t bits = random_bits(chance, k);
            if (scale == 0)
                continue;
            bubbles->x[2 * k] = bubbles->x[2 * k] + scale * deviation(bits);
            bubbles->x[2 * k + 1] = bubbles->x[2 * k + 1] + scale * deviation(bits >> 32);
        }
}

/* Triangles in order (t, 3) catch up with those that flips have changed. */
static void catch_up(Mesh *mesh, int64_t *triangles)
{
    int64_t k;
    for (k = 0; k < mesh->t; k++)
        if (mesh->changed[k]) {
            triangles[3 * k] = mesh->nodes[3 * k];
            triangles[3 * k + 1] = mesh->nodes[3 * k + 1];
            triangles[3 * k + 2] = mesh->nodes[3 * k + 2];
            mesh->changed[k] = 0;
        }
}

/* The net that bubbles have: its triangles, and its edges (m, 2) in order. */
typedef struct {
    Mesh mesh;
    double *start; /* (n, 2): places of the bubbles when it was connected last */
    int64_t *triangles; /* (t, 3): as they were when the edges were listed last */
    int64_t m, *edges;  /* with room for (3 t, 2) */
    int64_t *next;      /* (3 t, 2): where edges are listed next */
    int known;          /* whether triangles are in order as well */
    int flipped;        /* whether any edge ever was */
} Net;

/* Lists the edges anew where there were flips. */
static int64_t list_anew(Net *net)
{
    const Known known = {net->known ? net->triangles : NULL, net->edges, net->known ? net->m : 0};
    int64_t *listed = net->next, status;
    if (!memchr(net->mesh.changed, 1, (size_t)net->mesh.t))
        return DONE;
    status = put_edges_in_order(&net->mesh, &known, listed, &net->m);
    net->next = net->edges;
    net->edges = listed;
    net->known = net->flipped = 1;
    catch_up(&net->mesh, net->triangles);
    return status;
}

/* Lists the ends of edges, but for those between fixed bubbles, on which forces are of no concern, and the distances
   contact at which the bubbles are at rest; how many. */
static int64_t list_pairs(const Net *net, const Bubbles *bubbles, int32_t *ends, double *contact)
{
    const double *d = bubbles->d;
    int64_t k, count = 0;
    for (k = 0; k < net->m; k++) {
        int64_t i = net->edges[2 * k], j = net->edges[2 * k + 1];
        ends[2 * count] = (int32_t)i;
        ends[2 * count + 1] = (int32_t)j;
        contact[count] = (d[i] + d[j]) / 2;
        count += i >= bubbles->fixed || j >= bubbles->fixed;
    }
    return count;
}

/* Puts triangles and their twins (t, 3) in order, and the edges where the first ones were. */
static int64_t finish(Net *net, int64_t *edges, int32_t *twins)
{
    if (!net->flipped)
        return DONE;
    if (net->edges != edges)
        memcpy(edges, net->edges, (size_t)(2 * net->m) * sizeof *edges);
    memset(net->mesh.changed, 1, (size_t)net->mesh.t);
    return put_triangles_in_order(&net->mesh, net->triangles, twins);
}

static int make_room(Work *work, int64_t n, int64_t t)
{
    work->v = malloc((size_t)(2 * n + 1) * sizeof *work->v);
    work->contact = malloc((size_t)(3 * t + 1) * sizeof *work->contact);
    work->ends = malloc((size_t)(6 * t + 1) * sizeof *work->ends);
    work->valence = malloc((size_t)(n + 1) * sizeof *work->valence);
    work->near = malloc((size_t)(n + 1));
    return work->v && work->contact && work->ends && work->valence && work->near;
}

static void leave_room(Work *work)
{
    free(work->v);
    free(work->contact);
    free(work->ends);
    free(work->valence);
    free(work->near);
}

/* What a cycle of annealing goes by, but for its share of the displacement. */
typedef struct {
    const double *strength, *most; /* (n,) */
    double cutoff, dt;
    int64_t steps;
    const double *c; /* (steps,): viscosities */
} Rules;

/* One cycle, with mean speeds (steps,); the outcome is that of the flips, and nothing is done after the displacement if
   it is not DONE, even before. */
static int64_t go_through(Net *net, const Bubbles *bubbles, const Rules *rules, const Chance *chance, double inside,
                          double beside, double *speeds, Work *work, int64_t *outcome)
{
    const Motion motion = {bubbles->n, bubbles->fixed, bubbles->x, work->v, rules->most};
    int64_t status = DONE;
    mark_disorder(bubbles->n, bubbles->fixed, net->m, net->edges, work->valence, work->near);
    displace(bubbles, work->near, chance, inside, beside);
    if (*outcome == DONE)
        status = flip_all(&net->mesh, net->start, bubbles->x, outcome);
    if (status == DONE && *outcome == DONE) {
        memcpy(net->start, bubbles->x, (size_t)(2 * bubbles->n) * sizeof *net->start);
        status = list_anew(net);
    }
    if (status == DONE && *outcome == DONE) {
        int64_t count = list_pairs(net, bubbles, work->ends, work->contact);
        const Pairs pairs = {bubbles->n, count, work->ends, work->contact, rules->strength, rules->cutoff};
        status = relax_pairs(&pairs, &motion, rules->dt, rules->steps, rules->c, speeds);
    }
    return status;
}

/* Cycles of annealing of bubbles at x (n, 2), of which the first ones are ``fixed`` and ``calm`` ones (n,) are not
   displaced, with triangles (t, 3) and edges (m, 2) within facets, and twins (t, 3) and all in order if they are
   ``known``. They were connected when they were at start (n, 2), and in the end this is where they were last.

   Each cycle displaces by standard deviations of ``inside`` and ``beside`` (cycles,) the boundary, in spacings d (n,),
   and relaxes by so many steps with viscosities c (steps,), as `relax` does. Its random numbers are those of the seed
   and of its number, counted on from ``first``. Places, triangles, twins and edges, with room for (3 t, 2), are those in
   the end, if done (1,) is the number of cycles; mean speeds (cycles, steps) come out. Where rounding decides after a
   displacement, or it inverts a triangle, there is no further cycle, and all but the places and the done ones' speeds is
   void. */
KERNEL int64_t anneal(int64_t n, int64_t t, int64_t *triangles, int64_t m, int64_t *edges, int64_t known,
                      int32_t *twins, int64_t facet_count, const int64_t *facets, double *start, double *x,
                      int64_t fixed, const char *calm, const double *d, const double *strength, double cutoff,
                      const double *most, double dt, int64_t steps, const double *c, int64_t cycles,
                      const double *inside, const double *beside, int64_t seed, int64_t first, double *speeds,
                      int64_t *count, int64_t *done)
{
    const Bubbles bubbles = {n, fixed, x, d, calm};
    const Rules rules = {strength, most, cutoff, dt, steps, c};
    int64_t *spare = malloc((size_t)(6 * t + 1) * sizeof *spare), cycle, outcome = DONE;
    Net net = {{n, t, NULL, NULL, NULL}, start, triangles, m, edges, spare, known != 0, 0};
    Work work = {NULL, NULL, NULL, NULL, NULL};
    int64_t status = take_with_twins(&net.mesh, triangles, known ? twins : NULL, facet_count, facets, &outcome);
    if (!make_room(&work, n, t) || !spare)
        status = NO_MEMORY;
    for (cycle = 0; cycle < cycles && status == DONE; cycle++) {
        const Chance chance = {(uint64_t)seed, (uint64_t)(first + cycle)};
        status = go_through(&net, &bubbles, &rules, &chance, inside[cycle], beside[cycle], speeds + cycle * steps,
                            &work, &outcome);
        if (outcome != DONE)
            break;
    }
    if (status == DONE && outcome == DONE)
        status = finish(&net, edges, twins);
    if (status == DONE) {
        *done = cycle;
        *count = net.m;
    }
    give_back(&net.mesh);
    leave_room(&work);
    free(spare);
    return status;
}
