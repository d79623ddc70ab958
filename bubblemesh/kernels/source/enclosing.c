/* Triangles that closed rings enclose; see enclosing.py. */
#include <stdlib.h>

#include "kernels.h"

enum { UNKNOWN, OUTSIDE, INSIDE };
enum { EXTRA = 3 }; /* nodes of the triangle around all others come first */

/* How many of the walls (m, 2), in lists by their lower nodes, lie between two nodes. */
static int64_t walls_between(const int64_t *first, const int64_t *next, const int64_t *walls, int64_t a, int64_t b)
{
    int64_t found = 0, k;
    for (k = first[a < b ? a : b]; k >= 0; k = next[k])
        found += walls[2 * k] + walls[2 * k + 1] == a + b;
    return found;
}

/* Goes through the cells (t, 6), nodes and neighbours of triangles, from outside, and notes the side (t,) of each:
   another one behind a wall. Gives how many walls it has seen. */
static int64_t pass_walls(const uint32_t *cells, int64_t t, const int64_t *first, const int64_t *next,
                          const int64_t *walls, char *side, int64_t *stack)
{
    int64_t k, top = 0, seen = 0;
    for (k = 0; k < t && !top; k++)
        if (cells[6 * k] < EXTRA || cells[6 * k + 1] < EXTRA || cells[6 * k + 2] < EXTRA) {
            side[k] = OUTSIDE;
            stack[top++] = k;
        }
    while (top) {
        int64_t one = stack[--top];
        const uint32_t *nodes = cells + 6 * one, *across = nodes + 3;
        for (k = 0; k < 3; k++) {
            int64_t a = (int64_t)nodes[k] - EXTRA, b = (int64_t)nodes[(k + 1) % 3] - EXTRA;
            int64_t crossed = a < 0 || b < 0 ? 0 : walls_between(first, next, walls, a, b);
            seen += crossed;
            if (across[k] < t && side[across[k]] == UNKNOWN) {
                side[across[k]] = (char)(crossed % 2 ? OUTSIDE + INSIDE - side[one] : side[one]);
                stack[top++] = across[k];
            }
        }
    }
    return seen;
}

/* Triangles (t, 3) among cells (t, 6) that an odd number of rings encloses, with their number in counts (2,). The cells
   cover all of n nodes and three more, which come first, around them; the rings are walls (m, 2), sides of cells: if not
   all of them are, the second of the counts is 1, else 0. */
KERNEL int64_t enclose(int64_t n, int64_t t, const uint32_t *cells, int64_t m, const int64_t *walls, int64_t *triangles,
                       int64_t *counts)
{
    int64_t *first = malloc((size_t)(n + 1) * sizeof *first), *next = malloc((size_t)(m + 1) * sizeof *next);
    int64_t *stack = malloc((size_t)(t + 1) * sizeof *stack), status = NO_MEMORY, k, node;
    char *side = calloc((size_t)(t + 1), 1);
    if (first && next && stack && side) {
        for (k = 0; k < n; k++)
            first[k] = -1;
        for (k = 0; k < m; k++) {
            node = walls[2 * k] < walls[2 * k + 1] ? walls[2 * k] : walls[2 * k + 1];
            next[k] = first[node];
            first[node] = k;
        }
        counts[1] = pass_walls(cells, t, first, next, walls, side, stack) != 2 * m;
        counts[0] = 0;
        for (k = 0; k < t; k++)
            if (side[k] == INSIDE) {
                for (node = 0; node < 3; node++)
                    triangles[3 * counts[0] + node] = (int64_t)cells[6 * k + node] - EXTRA;
                counts[0]++;
            }
        status = DONE;
    }
    free(first);
    free(next);
    free(stack);
    free(side);
    return status;
}
