/* Where the order of bubbles is broken; see disorder.py. */
#include <stdlib.h>

#include "kernels.h"

enum { REGULAR_VALENCE = 6 };

/* Values (n,) of bubbles without six of the edges (m, 2), and of those next to them: ``beside`` where they are next to
   the boundary, else ``inside``; all others have zero, and so have the first ones, which are on the boundary. */
KERNEL int64_t mark_disorder(int64_t n, int64_t m, const int64_t *edges, int64_t on_boundary, double inside,
                             double beside, double *result)
{
    int64_t *valence = calloc((size_t)(n + 1), sizeof *valence), k;
    char *near = calloc((size_t)(n + 1), 1); /* bits: next to one whose order is broken, next to the boundary */
    if (!valence || !near) {
        free(valence);
        free(near);
        return NO_MEMORY;
    }
    for (k = 0; k < 2 * m; k++)
        valence[edges[k]]++;
    for (k = 0; k < n; k++)
        near[k] = valence[k] != REGULAR_VALENCE;
    for (k = 0; k < m; k++) {
        int64_t i = edges[2 * k], j = edges[2 * k + 1];
        near[i] |= (char)((valence[j] != REGULAR_VALENCE) | (j < on_boundary) << 1);
        near[j] |= (char)((valence[i] != REGULAR_VALENCE) | (i < on_boundary) << 1);
    }
    for (k = 0; k < n; k++)
        result[k] = k < on_boundary || !(near[k] & 1) ? 0.0 : near[k] & 2 ? beside : inside;
    free(valence);
    free(near);
    return DONE;
}
