/* Any image to a drawing in black and white. */
#include "image/image.h"
#include "image/pixel.h"

#include "base/parallel.h"
#include "base/params.h"

static const pave_threshold_params default_params = PAVE_THRESHOLD_PARAMS_INIT;

static const pv_param threshold_rows[] = {
    PV_REAL(pave_threshold_params, threshold, "", 0, 1, "display value from which a pixel is white"),
    PV_FLAG(pave_threshold_params, invert, "swap black and white"),
};

const pv_table pv_threshold_table = PV_TABLE("threshold", default_params, threshold_rows);

void pave_threshold_params_init(pave_threshold_params *params, size_t size)
{
    pv_params_init(&pv_threshold_table, params, size);
}

typedef struct threshold_job {
    pv_pixels_of pixels;
    uint8_t *drawing, *levels;
    double threshold; /* on the image's own scale */
    int32_t invert, cut;
} threshold_job;

enum { ROWS = 64 };

/* Luma is taken on display values. */
static double luma(const pv_pixels_of *pixels, int64_t at)
{
    double v[3];
    pv_pixel_values(pixels, at, v);
    return pixels->red == pixels->green ? v[0] : 0.299 * v[0] + 0.587 * v[1] + 0.114 * v[2];
}

static void threshold_rows_task(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    const threshold_job *job = data;
    const pave_image *image = job->pixels.image;
    int64_t from = (int64_t)band * ROWS * image->width, to = from + (int64_t)ROWS * image->width;
    int64_t all = (int64_t)image->width * image->height;
    for (int64_t i = from; i < (to < all ? to : all); i++) {
        double v = luma(&job->pixels, i);
        int white = (v >= job->threshold) != job->invert; /* NaN is less */
        job->drawing[i] = white ? 255 : 0;
        job->levels[i] = pv_level_of(job->invert ? 1 - v : v, white, job->cut);
    }
}

pave_result pave_image_threshold(pave_context *context, const pave_image *image, const pave_threshold_params *given,
                                 pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !image || !out)
        return PAVE_ERR_ARGUMENT;
    pave_threshold_params params;
    pave_image *drawing = NULL;
    pave_result result = pv_params_read(context, &pv_threshold_table, given, &params);
    if (result)
        return result;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = image->width;
    shape.height = image->height;
    result = pv_image_new(context, &shape, &drawing);
    if (result)
        return result;

    drawing->place = image->place;
    result = pv_levels_new(context, drawing, pv_level_cut(params.invert ? 1 - params.threshold : params.threshold));
    threshold_job job = { pv_pixels_begin(image), drawing->pixels, drawing->levels, params.threshold, params.invert,
                          drawing->cut };
    pv_call call = pv_call_begin(context, "threshold", 0, 1);
    if (!result)
        result = pv_parallel(context, (image->height + ROWS - 1) / ROWS, threshold_rows_task, &job, 0, 1);
    pv_call_end(context, call);
    if (result)
        pave_image_free(&drawing);
    else
        pv_levels_tidy(drawing);
    *out = drawing;
    return result;
}
