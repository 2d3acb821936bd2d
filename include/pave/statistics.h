/* The joint statistics of a texture, and textures that share them: another picture of the same stuff, from noise.
 *
 * Source: Portilla and Simoncelli 2000, "A parametric texture model based on joint statistics of complex wavelet
 * coefficients", International Journal of Computer Vision 40(1). A picture is taken apart into bands of a scale and an
 * orientation; what is measured is how they are distributed and how they go together. White noise is then
 * changed until it has the same statistics. Stochastic textures come out well, those made of whole things
 * (bricks, letters) do not: pave/tiling.h copies such ones. docs/papers.md says what is done otherwise, and why.
 *
 * Border    a picture that does not repeat is made to, by taking out the smooth part that its jumps at the border
 *           call for (Moisan 2011); of one that repeats nothing is taken. Of sides that 2^scales does not divide,
 *           pixels are left out on both sides. So statistics are means, which do not depend on the size.
 * Values    are taken as they are stored, 0..1 for whole-number types. Alpha is not looked at.
 * Colours   are turned to their principal axes first, and back at the end.
 * Same      bytes for any number of threads and in every locale.
 */
#ifndef PAVE_STATISTICS_H
#define PAVE_STATISTICS_H

#include <pave/image.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_statistics pave_statistics;

/* What is measured between channels. */
enum { PAVE_CROSS_NONE = 0, PAVE_CROSS_PIXELS = 1, PAVE_CROSS_MAGNITUDES = 2 };

typedef struct pave_statistics_params {
    size_t size;
    int32_t scales;        /* of the pyramid; each side must have 4 * 2^scales px */
    int32_t orientations;
    int32_t neighbourhood; /* side of the square of lags of an autocorrelation, odd */
    int32_t cross;         /* PAVE_CROSS_ */
} pave_statistics_params;

#define PAVE_STATISTICS_PARAMS_INIT { sizeof(pave_statistics_params), 4, 4, 7, PAVE_CROSS_MAGNITUDES }

PAVE_API void pave_statistics_params_init(pave_statistics_params *params, size_t size);

/* Measures a texture of 1 to 32 channels. Memory: about 250 bytes a pixel, and 4 more for each channel. Cost: some
 * 40 ms for 256 x 256 px and a channel. PAVE_ERR_ARGUMENT for one too small for its scales, for labels, and for values
 * that are not finite. */
PAVE_API pave_result pave_statistics_create(pave_context *context, const pave_image *texture,
                                            const pave_statistics_params *params, pave_statistics **out);
PAVE_API void pave_statistics_free(pave_statistics **statistics);

/* How many numbers they are: 726 for one channel of at least 128 x 128 px by default. */
PAVE_API int32_t pave_statistics_count(const pave_statistics *statistics);

/* How far apart two textures' statistics are, by groups. In each, differences and what is wanted are vectors for each
 * channel and scale; the figure is the root of the mean square of |difference| / |wanted|. 0.01 is one per cent. */
typedef struct pave_statistics_report {
    size_t size;
    double pixels;                /* mean, deviation, least, greatest; what is wanted is counted from the mean */
    double shape;                 /* skewness and kurtosis of the pixels */
    double low_shape;             /* and of the lowpass picture at each scale */
    double low_correlation;       /* autocorrelation of the lowpass pictures */
    double high;                  /* variance of the highpass residual */
    double magnitude;             /* mean magnitude of each band */
    double magnitude_correlation; /* autocorrelation of the magnitudes */
    double orientations;          /* their covariance between orientations */
    double scales;                /* and with the next coarser scale */
    double phase;                 /* covariance of real parts and the coarser scale, its phase doubled */
    double channels;              /* covariance between channels, of pixels, over deviations; NaN where not measured */
    double channel_magnitudes;    /* and of magnitudes; NaN where not measured */
    double distance;              /* the greatest of them */
} pave_statistics_report;

/* Measures another texture, of the same channels, as the first one was measured, and compares: `report`'s size must be
 * set. It must be large enough for the same lags. */
PAVE_API pave_result pave_statistics_compare(pave_context *context, const pave_statistics *wanted,
                                             const pave_image *texture, pave_statistics_report *report);

typedef struct pave_statistics_synthesis_params {
    size_t size;
    int32_t extent[2];  /* of the picture that is made, px; 0: as large as the one measured */
    uint64_t seed;      /* of the noise it is made from */
    int32_t iterations; /* rounds at most; it ends when each group is within half a per cent */
} pave_statistics_synthesis_params;

#define PAVE_STATISTICS_SYNTHESIS_PARAMS_INIT { sizeof(pave_statistics_synthesis_params), { 0, 0 }, 1, 50 }

PAVE_API void pave_statistics_synthesis_params_init(pave_statistics_synthesis_params *params, size_t size);

/* Makes a texture with the same statistics, of the same channels (without alpha), names, type and encoding. It repeats
 * without a seam where 2^scales divides its sides; else it is cut from a larger one. `report`, unless NULL, tells how
 * near it came, before values are rounded to the type, and of the larger one; its size must be set. Up to 10 rounds are
 * the paper's projections in turn; of more, the last three fifths are joint steps, each some 20 times as long. Memory:
 * about 250 bytes a pixel, with joint steps 550, and 4 more for each channel, with PAVE_CROSS_MAGNITUDES 25. Cost: for
 * 256 x 256 px and one channel some 0.1 s a round, and 5 to 15 s for 50 on two cores; for three channels minutes. */
PAVE_API pave_result pave_statistics_synthesize(pave_context *context, const pave_statistics *statistics,
                                                const pave_statistics_synthesis_params *params,
                                                pave_statistics_report *report, pave_image **out);

#ifdef __cplusplus
}
#endif

#endif
