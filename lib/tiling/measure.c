/* Measures: what a tiling is judged by, with the definitions that independent judges use. */
#include "tiling/best.h"

#include "image/fft.h"

#include <stdlib.h>
#include <string.h>

enum { PATCH = 9, STEP = 4, FINE = 2, CELL = 8, MOST_EXEMPLAR = 256, MOST_RESULT = 512, QUANTILES = 513, RGB = 3 };

typedef struct judging {
    pave_context *context;
    const pave_tiling *tiling;
    pv_picture exemplar, result;
    pv_bank from, to; /* the exemplar's and the result's patches */
    pave_tiling_measure *out;
} judging;

/* What is no number counts as 0, and what is far beyond white as 256 times as bright. */
static double to_255(const pave_image *image, int64_t index)
{
    double value = pv_image_value(image, index);
    return isfinite(value) ? 255 * fmax(fmin(value, 256), -256) : 0;
}

static pave_result read_picture(pave_context *context, const pave_image *image, pv_picture *out)
{
    pave_result result = PAVE_OK;
    int64_t pixels = (int64_t)image->width * image->height;
    int32_t colours = image->channels - (image->alpha >= 0 && image->channels > 1);
    *out = (pv_picture){ image->width, image->height, NULL };
    out->rgb = pv_allocate(context, (size_t)pixels, RGB * sizeof *out->rgb, &result);
    for (int64_t i = 0; i < pixels && !result; i++)
        for (int32_t c = 0; c < RGB; c++)
            out->rgb[RGB * i + c] = (float)to_255(image, i * image->channels + (colours < RGB ? 0 : c));
    return result;
}

/* Mean difference across each line between two columns (or rows); the last one is across the border. */
static pave_result line_differences(pave_context *context, const pv_picture *p, int rows, double **out)
{
    pave_result result = PAVE_OK;
    int32_t lines = rows ? p->height : p->width, along = rows ? p->width : p->height;
    double *mean = *out = pv_allocate_zeroed(context, (size_t)lines, sizeof *mean, &result);
    for (int32_t i = 0; i < lines && !result; i++)
        for (int32_t k = 0; k < along; k++) {
            int64_t a = rows ? (int64_t)i * p->width + k : (int64_t)k * p->width + i;
            int64_t b = rows ? (int64_t)((i + 1) % lines) * p->width + k : (int64_t)k * p->width + (i + 1) % lines;
            for (int32_t c = 0; c < RGB; c++)
                mean[i] += fabs((double)p->rgb[RGB * a + c] - p->rgb[RGB * b + c]) / (along * RGB);
        }
    return result;
}

static pave_result judge_lines(judging *j)
{
    int wraps[2] = { j->tiling->params.periodic == PAVE_PERIODIC_XY || j->tiling->params.periodic == PAVE_PERIODIC_X,
                     j->tiling->params.periodic == PAVE_PERIODIC_XY || j->tiling->params.periodic == PAVE_PERIODIC_Y };
    double *seam[2] = { &j->out->seam_x, &j->out->seam_y }, *mean = NULL;
    pave_result result = PAVE_OK;
    for (int rows = 0; rows < 2 && !result; rows++) {
        int32_t lines = (rows ? j->result.height : j->result.width) - 1;
        double sum = 0, most = 0;
        result = line_differences(j->context, &j->result, rows, &mean);
        for (int32_t i = 0; i < lines && !result; i++) {
            sum += mean[i];
            most = mean[i] > most ? mean[i] : most;
        }
        int told = !result && sum > 0, closes = wraps[rows] && j->tiling->params.mode != PAVE_TILING_PAPER;
        *seam[rows] = told && closes ? mean[lines] * lines / sum : -1;
        if (told && most * lines / sum > j->out->worst_line)
            j->out->worst_line = most * lines / sum;
        pv_release(mean);
    }
    return result;
}

/* The top left part of a picture as a bank of whole numbers. */
static pave_result patches_of(pave_context *context, const pv_picture *p, int32_t most, pv_bank *out)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_tiling_params plain = PAVE_TILING_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = p->width < most ? p->width : most;
    params.height = p->height < most ? p->height : most;
    params.channels = RGB;
    plain.mode = PAVE_TILING_PAPER;
    pave_result result = pv_image_new(context, &params, &image);
    for (int32_t y = 0; y < params.height && !result; y++)
        for (int32_t k = 0; k < params.width * RGB; k++) {
            float v = p->rgb[(int64_t)y * p->width * RGB + k];
            ((uint8_t *)image->pixels)[(int64_t)y * params.width * RGB + k] =
                (uint8_t)(v > 0 ? v < 255 ? v + 0.5f : 255 : 0);
        }
    const pave_image *const images[1] = { image };
    if (!result)
        result = pv_bank_create(context, images, 1, &plain, out);
    pave_image_free(&image);
    return result;
}

/* Nearest patches: for every patch of one bank, a step apart, the nearest one in another. */
typedef struct nearest {
    const pv_bank *of, *in;
    int32_t across, down, step; /* patches of `of` */
    int32_t fine;               /* step in `in` */
    const pave_tiling *guess;   /* the sources of `of`, if it is the result */
    pv_query *query;            /* of each worker */
    pv_compare *compare;
    double *distance;           /* of each patch, and */
    int32_t *place;             /* where its nearest one is: y * places across + x */
} nearest;

static int64_t first_guess(const nearest *n, const pv_query *query, int32_t x, int32_t y, int32_t *place)
{
    const pv_sheet *sheet = &n->in->sheet[0];
    const pave_source *s = n->guess ? &n->guess->sources[(int64_t)y * n->guess->width + x] : NULL;
    if (!s || s->turn || s->exemplar || s->x > sheet->width - PATCH || s->y > sheet->height - PATCH)
        return PV_NO_PLACE;
    *place = s->y * (sheet->width - PATCH + 1) + s->x;
    return n->compare(query, sheet->first + s->y * n->in->stride + s->x, PV_NO_PLACE);
}

static void find_nearest(const nearest *n, pv_query *query, int32_t x, int32_t y, int32_t at)
{
    const pv_sheet *sheet = &n->in->sheet[0], *own = &n->of->sheet[0];
    int32_t across = sheet->width - PATCH + 1, down = sheet->height - PATCH + 1;
    pv_query_begin(query, PATCH, PATCH);
    for (int32_t k = 0; k < PATCH * PATCH; k++) {
        int32_t place = own->first + (y + k / PATCH) * n->of->stride + x + k % PATCH;
        memcpy(query->value + RGB * k, n->of->values + (int64_t)RGB * place, RGB * sizeof *query->value);
        query->counts[k] = 1;
    }
    pv_query_end(query);
    int64_t least = first_guess(n, query, x, y, &n->place[at]);
    for (int32_t v = 0; v < down && least; v += n->fine)
        for (int32_t u = 0; u < across && least; u += n->fine) {
            int64_t cost = n->compare(query, sheet->first + v * n->in->stride + u, least);
            if (cost < least)
                least = cost, n->place[at] = v * across + u;
        }
    n->distance[at] = sqrt((double)least / (PATCH * PATCH * RGB));
}

static void nearest_task(void *data, int32_t index, int32_t worker)
{
    const nearest *n = data;
    find_nearest(n, &n->query[worker], index % n->across * n->step, index / n->across * n->step, index);
}

static void free_nearest(nearest *n, int32_t workers)
{
    for (int32_t i = 0; i < workers && n->query; i++)
        pv_query_free(&n->query[i]);
    pv_release(n->query);
    pv_release(n->distance);
    pv_release(n->place);
}

static pave_result run_nearest(judging *j, nearest *n, double from, double to)
{
    pave_result result = PAVE_OK;
    int32_t workers = pv_workers(j->context);
    n->across = n->of->sheet[0].width < PATCH ? 0 : (n->of->sheet[0].width - PATCH) / n->step + 1;
    n->down = n->of->sheet[0].height < PATCH ? 0 : (n->of->sheet[0].height - PATCH) / n->step + 1;
    n->compare = pv_compare_choose(PAVE_SEARCH_AUTO);
    size_t patches = (size_t)n->across * (size_t)n->down;
    if (n->in->sheet[0].width < PATCH || n->in->sheet[0].height < PATCH)
        patches = 0;
    n->query = pv_allocate_zeroed(j->context, (size_t)workers, sizeof *n->query, &result);
    n->distance = result ? NULL : pv_allocate_zeroed(j->context, patches, sizeof *n->distance, &result);
    n->place = result ? NULL : pv_allocate_zeroed(j->context, patches, sizeof *n->place, &result);
    for (int32_t i = 0; i < workers && !result; i++)
        result = pv_query_create(j->context, n->in, PATCH, PATCH, &n->query[i]);
    return result || !patches ? result
                              : pv_parallel(j->context, (int32_t)patches, nearest_task, n, from, to);
}

static double mean_distance(const nearest *n)
{
    double sum = 0;
    int32_t count = n->across * n->down;
    for (int32_t i = 0; i < count; i++)
        sum += n->distance[i];
    return count ? sum / count : 0;
}

/* How evenly the places found lie over the exemplar's cells. */
static pave_result judge_use(judging *j, const nearest *n)
{
    int32_t across = n->in->sheet[0].width - PATCH + 1, down = n->in->sheet[0].height - PATCH + 1;
    int32_t cells_across = (across + CELL - 1) / CELL, cells = cells_across * ((down + CELL - 1) / CELL);
    int32_t count = n->across * n->down, most = 0;
    pave_result result = PAVE_OK;
    int32_t *uses = pv_allocate_zeroed(j->context, (size_t)cells, sizeof *uses, &result);
    double entropy = 0;
    for (int32_t i = 0; i < count && !result; i++)
        uses[n->place[i] / across / CELL * cells_across + n->place[i] % across / CELL]++;
    for (int32_t i = 0; i < cells && !result; i++) {
        double share = (double)uses[i] / count;
        entropy -= uses[i] ? share * log(share) : 0;
        most = uses[i] > most ? uses[i] : most;
    }
    j->out->entropy = cells > 1 ? entropy / log(cells) : 1;
    j->out->overuse = count ? (double)most * cells / count : 0;
    pv_release(uses);
    return result;
}

static pave_result judge_patches(judging *j)
{
    nearest forth = { .of = &j->to, .in = &j->from, .step = STEP, .fine = 1, .guess = j->tiling };
    nearest back = { .of = &j->from, .in = &j->to, .step = STEP, .fine = FINE };
    if (j->from.sheet[0].width < PATCH || j->from.sheet[0].height < PATCH)
        return PAVE_OK;
    pave_result result = run_nearest(j, &forth, 0.1, 0.7);
    if (!result) {
        j->out->coherence = mean_distance(&forth);
        result = judge_use(j, &forth);
    }
    if (!result)
        result = run_nearest(j, &back, 0.7, 0.95);
    if (!result)
        j->out->completeness = mean_distance(&back);
    free_nearest(&forth, pv_workers(j->context));
    free_nearest(&back, pv_workers(j->context));
    return result;
}

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static pave_result sorted_channel(pave_context *context, const pv_picture *p, int32_t channel, float **out)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)p->width * (size_t)p->height;
    float *values = *out = pv_allocate(context, n, sizeof *values, &result);
    for (size_t i = 0; i < n && !result; i++)
        values[i] = p->rgb[RGB * i + (size_t)channel];
    if (!result)
        qsort(values, n, sizeof *values, ascending);
    return result;
}

static double quantile(const float *sorted, int64_t count, int32_t k)
{
    double at = (double)k / (QUANTILES - 1) * (double)(count - 1);
    int64_t below = (int64_t)at, above = below + 1 < count ? below + 1 : below;
    return sorted[below] + (at - (double)below) * ((double)sorted[above] - sorted[below]);
}

static pave_result judge_histogram(judging *j)
{
    pave_result result = PAVE_OK;
    for (int32_t c = 0; c < RGB && !result; c++) {
        float *a = NULL, *b = NULL;
        result = sorted_channel(j->context, &j->exemplar, c, &a);
        if (!result)
            result = sorted_channel(j->context, &j->result, c, &b);
        for (int32_t k = 0; k < QUANTILES && !result; k++)
            j->out->histogram += fabs(quantile(a, (int64_t)j->exemplar.width * j->exemplar.height, k) -
                                      quantile(b, (int64_t)j->result.width * j->result.height, k)) / (RGB * QUANTILES);
        pv_release(a);
        pv_release(b);
    }
    return result;
}

static double gradient_energy(const pv_picture *p)
{
    double across = 0, down = 0;
    int64_t row = (int64_t)p->width * RGB, values = row * p->height;
    for (int64_t i = 0; i < values; i++) {
        double right = i % row + RGB < row ? (double)p->rgb[i + RGB] - p->rgb[i] : 0;
        double below = i + row < values ? (double)p->rgb[i + row] - p->rgb[i] : 0;
        across += right * right;
        down += below * below;
    }
    double n_across = (double)(p->width - 1) * p->height, n_down = (double)p->width * (p->height - 1);
    return (n_across > 0 ? across / (RGB * n_across) : 0) + (n_down > 0 ? down / (RGB * n_down) : 0);
}

static double differ(const judging *j, const pave_source *a, const pave_source *b, int32_t ax, int32_t ay, int32_t bx,
                     int32_t by)
{
    const pv_picture *p = &j->exemplar;
    int32_t x0 = a->x + ax, y0 = a->y + ay, x1 = b->x + bx, y1 = b->y + by;
    x0 = x0 < 0 ? 0 : x0 < p->width ? x0 : p->width - 1, x1 = x1 < 0 ? 0 : x1 < p->width ? x1 : p->width - 1;
    y0 = y0 < 0 ? 0 : y0 < p->height ? y0 : p->height - 1, y1 = y1 < 0 ? 0 : y1 < p->height ? y1 : p->height - 1;
    double sum = 0;
    for (int32_t c = 0; c < RGB; c++) {
        double d = (double)p->rgb[RGB * ((int64_t)y0 * p->width + x0) + c] -
                   p->rgb[RGB * ((int64_t)y1 * p->width + x1) + c];
        sum += d * d;
    }
    return sqrt(sum);
}

/* What a seam between neighbours costs. Told where both come from the first exemplar, upright. */
static double seam_between(const judging *j, int64_t p, int64_t q, int32_t dx, int32_t dy, int64_t *seams)
{
    const pave_source *a = &j->tiling->sources[p], *b = &j->tiling->sources[q];
    int alike = a->exemplar == b->exemplar && a->turn == b->turn;
    if (alike && a->turn == 0 && b->x - a->x == dx && b->y - a->y == dy)
        return 0;
    ++*seams;
    return alike && !a->turn && !a->exemplar ? differ(j, a, b, 0, 0, -dx, -dy) + differ(j, a, b, dx, dy, 0, 0) + 1 : 0;
}

/* The mean difference of neighbours that a seam runs between, against that of all others: 1: seams cannot be told. */
typedef struct step_sums { double at_seams, elsewhere; int64_t seams, others; } step_sums;

static void note_step(const judging *j, int64_t p, int64_t q, int seam, step_sums *s)
{
    for (int32_t c = 0; c < RGB; c++)
        *(seam ? &s->at_seams : &s->elsewhere) += fabs((double)j->result.rgb[RGB * p + c] - j->result.rgb[RGB * q + c]);
    *(seam ? &s->seams : &s->others) += 1;
}

static void judge_seams(judging *j)
{
    int32_t width = j->result.width, height = j->result.height, periodic = j->tiling->params.periodic;
    int64_t seams = 0;
    double energy = 0;
    step_sums steps = { 0, 0, 0, 0 };
    for (int64_t i = 0; i < 2 * (int64_t)height * width; i++) {
        int32_t x = (int32_t)(i / 2 % width), y = (int32_t)(i / 2 / width), dx = (int32_t)(i % 2), dy = !dx;
        if ((x + dx == width && periodic != PAVE_PERIODIC_XY && periodic != PAVE_PERIODIC_X) ||
            (y + dy == height && periodic != PAVE_PERIODIC_XY && periodic != PAVE_PERIODIC_Y))
            continue;
        int64_t p = (int64_t)y * width + x, q = (int64_t)((y + dy) % height) * width + (x + dx) % width, before = seams;
        energy += seam_between(j, p, q, dx, dy, &seams);
        note_step(j, p, q, seams > before, &steps);
    }
    if (steps.seams && steps.elsewhere > 0)
        j->out->seam_inner = steps.at_seams / (double)steps.seams / (steps.elsewhere / (double)steps.others);
    j->out->seam_energy = energy / ((double)width * height);
    j->out->seam_share = (double)seams / (2.0 * width * height);
}

typedef struct stones { double share, size; } stones;

static pave_result find_stones(pave_context *context, const pv_picture *p, int32_t left, int32_t top, int32_t width,
                               int32_t height, stones *out)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)width * (size_t)height;
    int16_t *bright = pv_allocate(context, n, sizeof *bright, &result);
    for (size_t i = 0; i < n && !result; i++) {
        size_t x = (size_t)left + i % (size_t)width, y = (size_t)top + i / (size_t)width;
        const float *rgb = p->rgb + RGB * (y * (size_t)p->width + x);
        bright[i] = (int16_t)((rgb[0] + rgb[1] + rgb[2]) / RGB);
    }
    pv_grey grey = { width, height, width, 255, bright };
    pv_joints joints = { 0 };
    double squares = 0;
    int64_t count = 0;
    if (!result)
        result = pv_joints_find(context, &grey, &joints);
    if (!result)
        result = pv_joints_areas(context, width, height, joints.joint, &squares);
    for (size_t i = 0; i < n && !result; i++)
        count += joints.joint[i];
    out->share += (double)count / (double)n;
    out->size += n > (size_t)count ? squares / ((double)n - (double)count) : 0;
    pv_release(bright);
    pv_joints_free(&joints);
    return result;
}

/* Windows as large as the exemplar, three by three over the result. */
static pave_result judge_stones(judging *j)
{
    stones own = { 0, 0 }, all = { 0, 0 };
    int32_t width = j->exemplar.width < j->result.width ? j->exemplar.width : j->result.width;
    int32_t height = j->exemplar.height < j->result.height ? j->exemplar.height : j->result.height;
    pave_result result = find_stones(j->context, &j->exemplar, 0, 0, j->exemplar.width, j->exemplar.height, &own);
    for (int32_t k = 0; k < 9 && !result; k++)
        result = find_stones(j->context, &j->result, (j->result.width - width) * (k % 3) / 2,
                             (j->result.height - height) * (k / 3) / 2, width, height, &all);
    j->out->joint_share = own.share > 0 ? all.share / 9 / own.share : 1;
    j->out->stone_ratio = own.size > 0 ? all.size / 9 / own.size : 1;
    return result;
}

static pave_result judge_all(judging *j, const pave_image *exemplar, const pave_image *laid)
{
    pave_result result = read_picture(j->context, exemplar, &j->exemplar);
    if (!result)
        result = read_picture(j->context, laid, &j->result);
    if (!result)
        result = patches_of(j->context, &j->exemplar, MOST_EXEMPLAR, &j->from);
    if (!result)
        result = patches_of(j->context, &j->result, MOST_RESULT, &j->to);
    if (!result)
        result = judge_lines(j);
    if (!result)
        result = judge_patches(j);
    if (!result)
        result = judge_histogram(j);
    if (!result)
        result = pv_sliced_distance(j->context, &j->exemplar, &j->result, &j->out->sliced);
    if (!result)
        result = judge_stones(j);
    if (!result)
        result = pv_fft_repeat(j->context, j->result.rgb, j->result.width, j->result.height, &j->out->repeat);
    if (result)
        return result;
    judge_seams(j);
    double own = gradient_energy(&j->exemplar);
    j->out->sharpness = own > 0 ? gradient_energy(&j->result) / own : 1;
    return pv_progress(j->context, 1);
}

static const pave_tiling_measure empty_measure = { .size = sizeof(pave_tiling_measure) };

pave_result pave_tiling_judge(pave_context *context, const pave_tiling *tiling, const pave_image *const *exemplars,
                              int32_t count, pave_tiling_measure *measure)
{
    if (!context || !tiling || !exemplars || !measure)
        return PAVE_ERR_ARGUMENT;
    if (measure->size != sizeof *measure)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a tiling measure has a size of %zu: set it first", measure->size);
    pave_image *laid = NULL;
    *measure = empty_measure;
    judging j = { .context = context, .tiling = tiling, .out = measure };
    pv_call outer = pv_call_begin(context, "judge", 0, 1);
    pave_result result = pave_tiling_apply(context, tiling, exemplars, count, &laid);
    if (!result)
        result = judge_all(&j, exemplars[0], laid);
    measure->feature = tiling->feature;
    measure->seconds = tiling->seconds;
    pave_image_free(&laid);
    pv_release(j.exemplar.rgb);
    pv_release(j.result.rgb);
    pv_bank_free(&j.from);
    pv_bank_free(&j.to);
    pv_call_end(context, outer);
    return result;
}
