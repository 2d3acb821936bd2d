/* Any image to a drawing in black and white. */
#include "image/image.h"

#include "base/parallel.h"
#include "base/params.h"

#include <math.h>

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
    const pave_image *image;
    uint8_t *drawing;
    double threshold; /* on the image's own scale */
    int32_t invert;
    int32_t red, green, blue, alpha;
    double full; /* the value that stands for white */
} threshold_job;

enum { ROWS = 64 };

/* Halley's iteration, for pow and cbrt differ between C libraries. */
static double cube_root(double v)
{
    double t = 1;
    for (int i = 0; i < 8; i++)
        t *= (t * t * t + 2 * v) / (2 * t * t * t + v);
    return t;
}

/* Luma is taken on display values, so linear light is coded first (IEC 61966-2-1): v^(1/2.4) = v^(1/4) * v^(1/6). */
static double display(double linear)
{
    if (linear <= 0.0031308)
        return 12.92 * linear;
    double root = sqrt(linear < 1 ? linear : 1);
    return 1.055 * sqrt(root) * cube_root(root) - 0.055;
}

static double luma(const threshold_job *job, int64_t first)
{
    const pave_image *image = job->image;
    double r = pv_image_value(image, first + job->red) / job->full;
    double g = pv_image_value(image, first + job->green) / job->full;
    double b = pv_image_value(image, first + job->blue) / job->full;
    double alpha = job->alpha < 0 ? 1 : pv_image_value(image, first + job->alpha) / job->full;
    if (alpha < 1)
        r = 1 + (r - 1) * alpha, g = 1 + (g - 1) * alpha, b = 1 + (b - 1) * alpha;
    if (image->encoding == PAVE_LINEAR)
        r = display(r), g = display(g), b = display(b);
    return job->red == job->green ? r : 0.299 * r + 0.587 * g + 0.114 * b;
}

static void threshold_rows_task(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    const threshold_job *job = data;
    const pave_image *image = job->image;
    int64_t from = (int64_t)band * ROWS * image->width, to = from + (int64_t)ROWS * image->width;
    int64_t all = (int64_t)image->width * image->height;
    for (int64_t i = from; i < (to < all ? to : all); i++) {
        int white = luma(job, i * image->channels) >= job->threshold; /* false for NaN */
        job->drawing[i] = white != job->invert ? 255 : 0;
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
    threshold_job job = { image, drawing->pixels, params.threshold, params.invert, 0, 0, 0, image->alpha,
                image->type == PAVE_U32 ? 4294967295.0 : 1 };
    int32_t red = pv_image_channel(image, "R"), green = pv_image_channel(image, "G"),
            blue = pv_image_channel(image, "B");
    if (red >= 0 && green >= 0 && blue >= 0)
        job.red = red, job.green = green, job.blue = blue;
    pv_call call = pv_call_begin(context, "threshold", 0, 1);
    result = pv_parallel(context, (image->height + ROWS - 1) / ROWS, threshold_rows_task, &job, 0, 1);
    pv_call_end(context, call);
    if (result)
        pave_image_free(&drawing);
    *out = drawing;
    return result;
}
