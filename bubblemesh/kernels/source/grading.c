/* Tensors (m11, m12, m22) that grow from place to place no faster than by some part over a length of 1; see grading.py. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* Intersects a tensor with another one, as `tensors.intersections` does. */
static void intersect(double *m, const double *other)
{
    double r11 = sqrt(m[0]), r12 = m[1] / r11, r22 = sqrt(larger(m[2] - r12 * r12, DBL_MIN));
    double i11 = 1 / r11, i12 = -r12 / (r11 * r22), i22 = 1 / r22;
    double n11 = i11 * i11 * other[0], n12 = i11 * (i12 * other[0] + i22 * other[1]);
    double n22 = i12 * i12 * other[0] + 2 * i12 * i22 * other[1] + i22 * i22 * other[2];
    double half = (n11 + n22) / 2, aside = (n11 - n22) / 2, apart = sqrt(aside * aside + n12 * n12);
    double large = larger(half + apart, 1), small = larger(half - apart, 1);
    double mean = (large + small) / 2, part = (large - small) / 2 / (apart > 0 ? apart : 1);
    double k11 = mean + part * (n11 - half), k12 = part * n12, k22 = mean + part * (n22 - half);
    m[0] = r11 * r11 * k11;
    m[1] = r11 * (r12 * k11 + r22 * k12);
    m[2] = r12 * r12 * k11 + 2 * r12 * r22 * k12 + r22 * r22 * k22;
}

static double length_in(const double *m, double dx, double dy)
{
    return sqrt(larger(m[0] * dx * dx + 2 * (m[1] * dx * dy) + m[2] * dy * dy, 0));
}

/* Whether any entry of a tensor differs from what was told of it by more than a part of the trace of that. */
static int is_news(const double *m, const double *told, double settled)
{
    double change = larger(larger(fabs(m[0] - told[0]), fabs(m[1] - told[1])), fabs(m[2] - told[2]));
    return change > settled * (told[0] + told[2]);
}

/* Passes tensors (n, 3) on to the neighbours of points (n, 2), sweep by sweep, until none changes any more or
   there have been so many. The neighbours of point k are the ends from begin[k] (n + 1,) on. */
KERNEL int64_t grow_tensors(int64_t n, const double *points, const int64_t *begin, const int64_t *ends, double growth,
                            double settled, int64_t sweeps, double *tensors)
{
    double *told = malloc((size_t)(3 * n + 1) * sizeof *told);
    int64_t *news = malloc((size_t)(n + 1) * sizeof *news);
    char *reached = calloc((size_t)(n + 1), 1);
    int64_t count = n, k, j, status = told && news && reached ? DONE : NO_MEMORY;
    if (status == DONE) {
        memcpy(told, tensors, (size_t)(3 * n) * sizeof *told);
        for (k = 0; k < n; k++)
            news[k] = k;
    }
    for (; status == DONE && count > 0 && sweeps > 0; sweeps--) {
        for (k = 0; k < count; k++)
            memcpy(told + 3 * news[k], tensors + 3 * news[k], 3 * sizeof *told);
        for (k = 0; k < count; k++) {
            const double *here = told + 3 * news[k], *x = points + 2 * news[k];
            for (j = begin[news[k]]; j < begin[news[k] + 1]; j++) {
                const double *end = points + 2 * ends[j];
                double factor = 1 + growth * length_in(here, end[0] - x[0], end[1] - x[1]), squared = factor * factor;
                const double grown[3] = {here[0] / squared, here[1] / squared, here[2] / squared};
                intersect(tensors + 3 * ends[j], grown);
                reached[ends[j]] = 1;
            }
        }
        for (k = count = 0; k < n; k++) {
            if (reached[k] && is_news(tensors + 3 * k, told + 3 * k, settled))
                news[count++] = k;
            reached[k] = 0;
        }
    }
    free(told);
    free(news);
    free(reached);
    return status;
}
