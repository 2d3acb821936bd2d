/* Statistics from inside: how they are kept, and a picture taken apart to meet them. */
#pragma once

#include "statistics/planes.h"
#include "statistics/steerable.h"

enum { PV_MOST_REACH = 7, PV_MOST_TEXTURE = 1 << 30 }; /* pixels */

/* The groups of statistics, as they are reported. */
enum {
    PV_PIXELS,                /* mean, deviation, least and greatest */
    PV_SHAPE,                 /* skewness and kurtosis */
    PV_LOW_SHAPE,             /* the same of the lowpass pictures */
    PV_LOW_CORRELATION,       /* their autocorrelation */
    PV_HIGH,                  /* variance of the highpass residual */
    PV_MAGNITUDE,             /* mean magnitude of each band */
    PV_MAGNITUDE_CORRELATION, /* autocorrelation of the magnitudes */
    PV_ORIENTATIONS,          /* covariance of the magnitudes of two orientations */
    PV_SCALES,                /* of magnitudes and those of the coarser scale */
    PV_PHASE,                 /* of real parts and the coarser scale, its phase doubled */
    PV_CHANNELS,              /* covariance of the pixels of two channels */
    PV_CHANNEL_MAGNITUDES,    /* of the magnitudes of their bands */
    PV_GROUPS
};

/* Statistics of one group and scale, which lie together. */
typedef struct pv_stretch {
    int32_t group, channel, scale;
    int32_t first, count;
} pv_stretch;

struct pv_statistics {
    pv_statistics_settings settings;
    int32_t channels;
    int32_t reach[PV_MOST_SCALES + 1]; /* farthest lag of each level */
    int32_t stretch_count, count;
    pv_stretch *stretches;
    double *values;
};

pave_result pv_statistics_create(pave_context *context, int32_t width, int32_t height, int32_t channels,
                                 const pv_statistics_settings *settings, pv_statistics **out);

/* Room for statistics that can be compared with others. */
pave_result pv_statistics_create_like(pave_context *context, const pv_statistics *like, pv_statistics **out);

/* Where the statistics of a group are; NULL where there are none. */
double *pv_statistics_at(const pv_statistics *statistics, int32_t group, int32_t channel, int32_t scale);

/* What differences of a stretch are divided by. */
double pv_statistics_norm(const pv_statistics *wanted, const pv_stretch *stretch);

/* planes.c: are all values finite, and such that their fourth powers are?; measured with the reaches of others. */
pave_result pv_check_finite(pave_context *context, int32_t width, int32_t height, int32_t channels,
                            const float *planes);
pave_result pv_statistics_measure_like(pave_context *context, const pv_statistics *like, int32_t width, int32_t height,
                                       const float *planes, pv_statistics **out);

/* Planes that repeat, of sides that 2^scales divides, are taken there in place; `is` becomes the
 * statistics they have then. */
pave_result pv_statistics_grow(pave_context *context, const pv_statistics *wanted, int32_t width, int32_t height,
                               float *planes, int32_t iterations, double from, double to, pv_statistics **is);

/* Relative distance of a group; a negative number where there is none. */
double pv_statistics_group(const pv_statistics *wanted, const pv_statistics *is, int32_t group);

static inline int32_t pv_lags(int32_t reach)
{
    return ((2 * reach + 1) * (2 * reach + 1) + 1) / 2;
}

/* The i-th lag: the upper half of the square, for the other one is the same. */
static inline void pv_lag(int32_t reach, int32_t i, int32_t *x, int32_t *y)
{
    int32_t side = 2 * reach + 1;
    *x = (i + reach) % side - reach;
    *y = (i + reach) / side;
}

/* The other channels, for what is between them. */
typedef struct pv_company {
    int32_t channels;
    size_t size;        /* of a plane */
    const float *planes;
    uint8_t *known;     /* of each channel: its magnitudes are here */
    float *magnitudes;  /* of all scales and orientations, channel by channel; NULL where none are asked for */
    size_t per_channel; /* numbers of a channel's */
} pv_company;

static inline int32_t pv_pair(int32_t a, int32_t b)
{
    return a > b ? a * (a - 1) / 2 + b : b * (b - 1) / 2 + a;
}

/* One channel taken apart. */
typedef struct pv_texture {
    pave_context *context;
    const pv_statistics *like; /* settings and reaches */
    int32_t width, height;
    pv_steerable steerable;
    pv_pyramid pyramid;
    float *low[PV_MOST_SCALES + 1];                                  /* lows, without the mean */
    float *magnitude[PV_MOST_SCALES][PV_MOST_ORIENTATIONS];          /* less their mean */
    double mean_magnitude[PV_MOST_SCALES][PV_MOST_ORIENTATIONS];
    pv_complex *parent[PV_MOST_SCALES][PV_MOST_ORIENTATIONS];        /* bands of the next scale, expanded to this one */
    pv_complex *doubled[PV_MOST_SCALES][PV_MOST_ORIENTATIONS];       /* these with their phase doubled */
    float *parent_magnitude[PV_MOST_SCALES][PV_MOST_ORIENTATIONS];   /* less their mean */
    pv_complex *room[2];                                             /* two planes of level 0's size */
    float *rows;                                                     /* one of each worker */
    pv_company *company;                                             /* NULL: the channel is by itself */
} pv_texture;

pave_result pv_texture_create(pave_context *context, const pv_statistics *like, int32_t width, int32_t height,
                              pv_texture *out);
void pv_texture_free(pv_texture *texture);

/* gather.c: the fields of a scale from its bands and from those of the coarser one; all of them, from a plane. */
pave_result pv_texture_magnitudes(pv_texture *texture, int32_t scale);
pave_result pv_texture_parents(pv_texture *texture, int32_t scale);
pave_result pv_texture_analyse(pv_texture *texture, const float *plane);

/* How these fields of `at` change, to the first order, when a direction is added to its plane: into `out`. */
pave_result pv_texture_differentiate(const pv_texture *at, const float *direction, pv_texture *out);

/* gather.c: the statistics of one channel, of the plane and its fields; and how they change with a direction. */
pave_result pv_texture_gather(pv_texture *texture, const float *plane, int32_t channel, pv_statistics *into);
pave_result pv_texture_gather_change(const pv_texture *at, const pv_texture *change, const float *plane,
                                     const float *direction, int32_t channel, pv_statistics *into);

/* gradient.c: the plane that makes the sum of the statistics, each times its weight, grow fastest. `parts` is room. */
pave_result pv_texture_gradient(const pv_texture *at, const float *plane, int32_t channel, const double *weights,
                                pv_texture *parts, float *out);

/* company.c: room for what is between channels, if that is asked for; a channel's magnitudes kept for the others, and
 * those of another channel. */
pave_result pv_company_create(pave_context *context, const pv_statistics *like, int32_t width, int32_t height,
                              const float *planes, pv_company *out);
void pv_company_free(pv_company *company);
void pv_company_keep(const pv_texture *texture, int32_t channel);
float *pv_company_magnitude(const pv_texture *texture, int32_t channel, int32_t scale, int32_t orientation);

/* Covariances with the channels that are known; how they change; what they want of a plane. */
void pv_company_gather(const pv_texture *texture, const float *plane, int32_t channel, pv_statistics *into);
void pv_company_gather_change(const pv_texture *change, const float *direction, int32_t channel, pv_statistics *into);
void pv_company_grade(const pv_texture *texture, int32_t channel, const pv_statistics *weights, float *out);

/* impose.c: one round of all statistics of a channel. */
pave_result pv_texture_impose(pv_texture *texture, const pv_statistics *wanted, int32_t channel, float *plane);

/* joint.c: a step towards all statistics of a channel at once, by so many conjugate gradients, which becomes how many
 * to take for the next one; `is` becomes the statistics it has then. */
pave_result pv_texture_approach(pv_texture *at, pv_texture *change, const pv_statistics *wanted, int32_t channel,
                                float *plane, int32_t *steps, pv_statistics *is);

/* Sums of products of two planes, one of them moved by a lag around the torus; means of them. */
double pv_mean_product(const float *a, const float *b, int32_t width, int32_t height, int32_t x, int32_t y);

/* moments.c: mean, variance, and the third and fourth moments over powers of the deviation. */
typedef struct pv_moments { double mean, variance, skewness, kurtosis, least, greatest; } pv_moments;
double pv_mean(const float *plane, size_t count);
pv_moments pv_moments_of(const float *plane, size_t count);

/* Skewness and kurtosis; how they and the deviation change, to the first order, when a direction is added; the sum of
 * their gradients, each times its weight and the count, added to `out`. */
void pv_shape_of(const float *plane, size_t count, double shape[2]);
void pv_shape_change(const float *plane, const float *direction, size_t count, double change[2]);
double pv_deviation_change(const float *plane, const float *direction, size_t count);
void pv_shape_gradient(const float *plane, size_t count, const double weights[2], float *out);

/* Moves a plane as little as possible to another skewness or kurtosis (3 or 4); mean and variance stay. */
void pv_move_moment(float *plane, size_t count, int order, double wanted);

/* The mean and the ends of the range; what is beyond them becomes the ends. */
void pv_impose_range(float *plane, size_t count, double mean, double least, double greatest);

/* Mean, deviation, skewness, kurtosis and range. */
void pv_impose_marginal(float *plane, size_t count, const double pixels[4], const double shape[2]);

/* autocorrelation.c: filters a plane of a level to another autocorrelation within a reach. */
pave_result pv_impose_autocorrelation(pv_texture *texture, int32_t level, int32_t reach, const double *wanted,
                                      float *plane);

/* covariance.c: moves `count` planes to the covariance wanted among them (NULL: as it is), and with `others` planes
 * that stay. */
pave_result pv_impose_covariance(pave_context *context, int32_t count, float *const *planes, int32_t others,
                                 float *const *fixed, size_t size, const double *among, const double *with);

/* Eigenvalues and eigenvectors, in columns, of a small symmetric matrix, which is used up: Jacobi's method. */
void pv_jacobi(int32_t n, double *matrix, double *values, double *vectors);
