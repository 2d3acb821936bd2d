/* Fourier transforms of several pictures at once: rows, then columns, each a task of its own. */
#include "image/fourier.h"

#include "base/parallel.h"

#include <string.h>

#define KISS_FFT_SHARED
#define kiss_fft_scalar float
#include <kissfft/kiss_fft.h>

enum { COLUMNS = 8, TASK = 4096 }; /* columns at once; pixels that are worth a task */

static pave_result make_plan(pave_context *context, int32_t size, int inverse, void **plan)
{
    pave_result result = PAVE_OK;
    size_t bytes = 0;
    kiss_fft_alloc(size, inverse, NULL, &bytes);
    *plan = pv_allocate(context, bytes, 1, &result);
    if (!result && !kiss_fft_alloc(size, inverse, *plan, &bytes))
        result = pv_fail(context, PAVE_ERR_INTERNAL, "no Fourier transform of %d", (int)size);
    return result;
}

/* A worker's room holds columns before and after, or a row. */
static size_t room_size(const pv_fourier *fourier)
{
    size_t columns = 2 * (size_t)COLUMNS * (size_t)fourier->height, row = (size_t)fourier->width;
    return columns > row ? columns : row;
}

pave_result pv_fourier_create(pave_context *context, int32_t width, int32_t height, pv_fourier *out)
{
    pave_result result = PAVE_OK;
    *out = (pv_fourier){ .width = width, .height = height };
    for (int inverse = 0; inverse < 2 && !result; inverse++) {
        result = make_plan(context, width, inverse, &out->row[inverse]);
        if (!result)
            result = make_plan(context, height, inverse, &out->column[inverse]);
    }
    if (!result)
        out->room = pv_allocate(context, (size_t)pv_workers(context) * room_size(out), sizeof *out->room, &result);
    if (result)
        pv_fourier_free(out);
    return result;
}

void pv_fourier_free(pv_fourier *fourier)
{
    for (int inverse = 0; inverse < 2; inverse++) {
        pv_release(fourier->row[inverse]);
        pv_release(fourier->column[inverse]);
    }
    pv_release(fourier->room);
    memset(fourier, 0, sizeof *fourier);
}

typedef struct transforming {
    const pv_fourier *fourier;
    pv_complex *const *planes;
    int32_t run, parts; /* rows or columns of a task, and tasks of a plane */
    int inverse;
} transforming;

/* So many of `count` rows or columns of a plane, in COLUMNS, that threads do not wait longer than they work. */
static transforming share_out(const pv_fourier *f, int inverse, pv_complex *const *planes, int32_t length,
                              int32_t count)
{
    int32_t run = (TASK / length + COLUMNS - 1) / COLUMNS * COLUMNS;
    run = run > COLUMNS ? run : COLUMNS;
    return (transforming){ f, planes, run, (count + run - 1) / run, inverse };
}

static int is_nothing(const pv_complex *row, int32_t width)
{
    int32_t x = 0;
    while (x < width && row[x].r == 0 && row[x].i == 0)
        x++;
    return x == width;
}

/* Spectra that were cut out or filled up have many rows of nothing, which stay so. */
static void do_rows(void *data, int32_t index, int32_t worker)
{
    const transforming *t = data;
    const pv_fourier *f = t->fourier;
    pv_complex *room = f->room + (size_t)worker * room_size(f);
    int32_t first = index % t->parts * t->run, end = first + t->run < f->height ? first + t->run : f->height;
    for (int32_t y = first; y < end; y++) {
        pv_complex *row = t->planes[index / t->parts] + (size_t)y * (size_t)f->width;
        if (is_nothing(row, f->width))
            continue;
        memcpy(room, row, (size_t)f->width * sizeof *room);
        kiss_fft(f->row[t->inverse], (const kiss_fft_cpx *)room, (kiss_fft_cpx *)row);
    }
}

/* Some columns at once, for what lies beside each other in memory is fetched together. */
static void do_strip(const transforming *t, size_t first, pv_complex *plane, pv_complex *before)
{
    const pv_fourier *f = t->fourier;
    size_t height = (size_t)f->height, width = (size_t)f->width;
    size_t count = width - first < COLUMNS ? width - first : COLUMNS;
    pv_complex *after = before + COLUMNS * height;
    float scale = t->inverse ? (float)(1.0 / ((double)width * (double)height)) : 1;
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < count; x++)
            before[x * height + y] = plane[y * width + x];
    for (size_t x = 0; x < count; x++)
        kiss_fft(f->column[t->inverse], (const kiss_fft_cpx *)before + x * height, (kiss_fft_cpx *)after + x * height);
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < count; x++) {
            pv_complex value = after[x * height + y];
            plane[y * width + x] = (pv_complex){ value.r * scale, value.i * scale };
        }
}

static void do_columns(void *data, int32_t index, int32_t worker)
{
    const transforming *t = data;
    const pv_fourier *f = t->fourier;
    int32_t first = index % t->parts * t->run, end = first + t->run < f->width ? first + t->run : f->width;
    for (int32_t x = first; x < end; x += COLUMNS)
        do_strip(t, (size_t)x, t->planes[index / t->parts] + x, f->room + (size_t)worker * room_size(f));
}

static pave_result transform(pave_context *context, const pv_fourier *fourier, int inverse, int32_t count,
                             pv_complex *const *planes)
{
    transforming rows = share_out(fourier, inverse, planes, fourier->width, fourier->height);
    transforming columns = share_out(fourier, inverse, planes, fourier->height, fourier->width);
    pave_result result = pv_parallel(context, count * rows.parts, do_rows, &rows, 0, 0);
    return result ? result : pv_parallel(context, count * columns.parts, do_columns, &columns, 0, 0);
}

pave_result pv_fourier_forth(pave_context *context, const pv_fourier *fourier, int32_t count,
                             pv_complex *const *planes)
{
    return transform(context, fourier, 0, count, planes);
}

pave_result pv_fourier_back(pave_context *context, const pv_fourier *fourier, int32_t count,
                            pv_complex *const *planes)
{
    return transform(context, fourier, 1, count, planes);
}
