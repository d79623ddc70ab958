/* Positions of grid cells on a Hilbert curve; see hilbert.py. */
#include "kernels.h"

/* Positions (n,) of cells (n, 2), columns and rows of a grid with 2^bits of each. From level to level the lower quarters
   are transposed, and the one on the right is turned about as well: both, so far, are what every bit is changed by. */
KERNEL int64_t hilbert_index(int64_t n, const int64_t *cells, int64_t bits, int64_t *index)
{
    int64_t k, bit;
    for (k = 0; k < n; k++) {
        uint64_t x = (uint64_t)cells[2 * k], y = (uint64_t)cells[2 * k + 1], found = 0, transposed = 0, turned = 0;
        for (bit = bits - 1; bit >= 0; bit--) {
            uint64_t column = x >> bit & 1, row = y >> bit & 1, exchanged = (column ^ row) & transposed;
            uint64_t right = column ^ exchanged ^ turned, upper = row ^ exchanged ^ turned, lower = upper ^ 1;
            found = found << 2 | ((3 * right) ^ upper);
            transposed ^= lower;
            turned ^= right & lower;
        }
        index[k] = (int64_t)found;
    }
    return DONE;
}
