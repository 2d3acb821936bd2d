/* A pavement from file to files, window after window: read the drawing as bits, lay each window into a file of its own,
 * merge. */
#include "base/params.h"
#include "cvd/cvd.h"
#include "field/field.h"
#include "io/drawing.h"
#include "io/manifest.h"
#include "io/output.h"
#include "io/stonefile.h"
#include "stones/stones.h"

#include <pave/pave.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const pave_stream_params default_params = PAVE_STREAM_PARAMS_INIT;

static const pv_param stream_rows[] = {
    PV_LONG(pave_stream_params, memory, "bytes", 0, 1ll << 47, "lay window by window within so much: 1G; 0: at once"),
};

const pv_table pv_stream_table = PV_TABLE("stream", default_params, stream_rows);

void pave_stream_params_init(pave_stream_params *params, size_t size)
{
    pv_params_init(&pv_stream_table, params, size);
}

enum {
    PATH = 4096,
    SPARE = 8,             /* px of drawing around what a diagram is asked for */
    BYTES_A_PIXEL = 18,    /* of a region: drawing, field, edges, labels, and its share of sites and polygons */
    BASE = 160 << 20,      /* code, image libraries, a driver */
    DEFAULT_MEMORY = 1 << 30,
};

typedef struct stream {
    pave_context *context;
    pv_manifest plan; /* margin: px of drawing that are laid around a window */
    pv_bitmap drawing;
    char folder[PATH];
} stream;

static pave_result read_params(stream *s, const pave_lay_params *given)
{
    pave_context *context = s->context;
    static const pave_lay_params none = PAVE_LAY_PARAMS_INIT;
    const pave_lay_params *params = given ? given : &none;
    pave_result result = pv_params_read(context, &pv_threshold_table, params->threshold, &s->plan.threshold);
    if (!result)
        result = pv_params_read(context, &pv_field_table, params->field, &s->plan.field);
    if (!result)
        result = pv_params_read(context, &pv_cvd_table, params->cvd, &s->plan.cvd);
    if (!result)
        result = pv_params_read(context, &pv_stones_table, params->stones, &s->plan.stones);
    if (!s->plan.cvd.supersample)
        s->plan.cvd.supersample = pv_stones_supersample(&s->plan.stones);
    for (int i = 0; i < 4 && !result; i++)
        if (s->plan.cvd.window[i])
            result = pv_fail(context, PAVE_ERR_ARGUMENT, "give a window or a memory, not both");
    return result;
}

/* Windows of such a size that one with its margin stays within the memory. */
static pave_result divide(stream *s, int64_t memory)
{
    pave_cvd_params cvd = s->plan.cvd;
    double width = s->drawing.width, height = s->drawing.height;
    if (cvd.stones)
        cvd.half_side = sqrt(width * height / cvd.stones) / 2;
    s->plan.margin = pv_margin_guess(&cvd) + (int32_t)(cvd.window_margin * cvd.half_side) + SPARE;
    double left = (double)memory - BASE - (double)s->drawing.stride * height;
    double side = floor(sqrt(fmax(left, 0) / BYTES_A_PIXEL)) - 2 * s->plan.margin;
    if (side < s->plan.margin / 2 && left < BYTES_A_PIXEL * width * height) {
        double least = 2.5 * s->plan.margin;
        return pv_fail(s->context, PAVE_ERR_LIMIT, "memory is %lld bytes, but windows of this drawing need %.0f",
                       (long long)memory, least * least * BYTES_A_PIXEL + BASE + (double)s->drawing.stride * height);
    }
    if (left >= BYTES_A_PIXEL * width * height)
        side = fmax(width, height);
    s->plan.columns = (int32_t)ceil(width / side);
    s->plan.rows = (int32_t)ceil(height / side);
    return PAVE_OK;
}

static void part_path(const stream *s, int32_t k, char path[PATH + 32])
{
    snprintf(path, PATH + 32, "%s/%06d.stones", s->folder, (int)k);
}

/* Was this window laid before, from the same drawing and parameters? */
static int is_done(const stream *s, const char *path, const pv_rect *w)
{
    pv_stone_file_head head;
    pave_context quiet = *s->context;
    quiet.message = NULL;
    if (access(path, F_OK) || pv_stones_file_head(&quiet, path, &head))
        return 0;
    if (s->plan.cvd.stones) /* follows from it */
        head.cvd.half_side = s->plan.cvd.half_side;
    const pv_manifest *plan = &s->plan;
    pv_making making = { plan->hash, &plan->threshold, &plan->field, &plan->cvd, &plan->stones };
    return head.x == w->x && head.y == w->y && head.width == w->width && head.height == w->height &&
           pv_stones_file_same(&head, &making);
}

/* The stones of a window from so much of the drawing around it; NULL, and a larger margin, if that is too little. */
static pave_result lay_region(stream *s, pv_rect window, int32_t *margin, pave_stones **out)
{
    pave_context *context = s->context;
    pv_rect region = pv_rect_grown(window, *margin, (pv_rect){ 0, 0, s->drawing.width, s->drawing.height });
    pave_image *drawing = NULL;
    pave_field *field = NULL;
    pave_cvd *cvd = NULL;
    int32_t needed = 0;
    pave_cvd_params params = s->plan.cvd;
    memcpy(params.window, &window, sizeof params.window);
    pave_result result = pv_bitmap_cut(context, &s->drawing, region.x, region.y, region.width, region.height, &drawing);
    if (!result)
        result = pave_field_create(context, drawing, &s->plan.field, &field);
    if (!result)
        result = pv_cvd_create(context, field, &params, &needed, &cvd);
    if (cvd) {
        double lacking = pv_stones_margin(cvd, &s->plan.stones) - pv_stones_room(cvd);
        needed = lacking > 0 ? *margin + (int32_t)ceil(lacking) : 0;
        if (needed)
            s->plan.cvd.window_margin += lacking / pave_cvd_half_side(cvd) + 1;
    }
    if (!result && !needed)
        result = pave_stones_create(context, drawing, field, cvd, &s->plan.stones, out);
    *margin = (needed > *margin ? needed : *margin) + SPARE;
    pave_cvd_free(&cvd);
    pave_field_free(&field);
    pave_image_free(&drawing);
    return result;
}

/* Lays a window into a file, unless it lies there. */
static pave_result lay_window(stream *s, int32_t k, const char *path)
{
    pv_rect window = pv_manifest_window(&s->plan, k);
    pave_stones *stones = NULL;
    pave_result result = PAVE_OK;
    int32_t margin = s->plan.margin;
    if (is_done(s, path, &window))
        return PAVE_OK;
    while (!result && !stones)
        result = lay_region(s, window, &margin, &stones);
    if (!result) {
        stones->drawing = s->plan.hash;
        stones->threshold = s->plan.threshold;
        result = pave_stones_write(s->context, stones, path, "stones");
    }
    pave_stones_free(&stones);
    return result;
}

static pave_result make_folder(stream *s, const char *folder, const char *output)
{
    int length = snprintf(s->folder, sizeof s->folder, "%s%s", folder ? folder : output, folder ? "" : ".parts");
    if (length >= (int)sizeof s->folder)
        return pv_fail(s->context, PAVE_ERR_ARGUMENT, "%s: the name is too long", output);
    if (mkdir(s->folder, 0777) && errno != EEXIST)
        return pv_fail(s->context, PAVE_ERR_IO, "%s: cannot be made: %s", s->folder, pv_system_error(errno));
    return PAVE_OK;
}

static pave_result merge_parts(stream *s, const char *const *outputs, int32_t count)
{
    int32_t parts = s->plan.columns * s->plan.rows;
    pave_result result = PAVE_OK;
    const char **paths = pv_allocate(s->context, (size_t)parts, sizeof *paths, &result);
    char(*names)[PATH + 32] = NULL;
    if (!result)
        names = pv_allocate(s->context, (size_t)parts, sizeof *names, &result);
    for (int32_t k = 0; k < parts && !result; k++) {
        part_path(s, k, names[k]);
        paths[k] = names[k];
    }
    for (int32_t i = 0; i < count && !result; i++)
        result = pave_stones_merge(s->context, paths, parts, outputs[i], NULL);
    for (int32_t k = 0; k < parts && !result; k++)
        unlink(paths[k]);
    if (!result)
        rmdir(s->folder);
    pv_release(names);
    pv_release(paths);
    return result;
}

/* Reads the drawing that a plan is for. */
static pave_result read_drawing(stream *s, const char *drawing, double to)
{
    pv_call call = pv_call_begin(s->context, "read", 0, to);
    pave_result result = pv_drawing_read(s->context, drawing, &s->plan.threshold, &s->drawing);
    pv_call_end(s->context, call);
    return result;
}

/* The plan of a drawing within a memory. */
static pave_result make_plan(stream *s, const char *drawing, const pave_lay_params *given, int64_t memory, double to)
{
    pave_result result = read_params(s, given);
    if (!result)
        result = read_drawing(s, drawing, to);
    if (result)
        return result;
    s->plan.hash = pv_bitmap_hash(&s->drawing);
    s->plan.width = s->drawing.width;
    s->plan.height = s->drawing.height;
    return divide(s, memory ? memory : DEFAULT_MEMORY);
}

static pave_result lay_all(stream *s, const pave_stream_params *params, const char *drawing,
                           const pave_lay_params *given, const char *const *outputs, int32_t count)
{
    pave_context *context = s->context;
    pave_result result = make_plan(s, drawing, given, params->memory, 0.03);
    if (!result)
        result = make_folder(s, params->folder, outputs[0]);
    int32_t windows = s->plan.columns * s->plan.rows;
    for (int32_t k = 0; k < windows && !result; k++) {
        char path[PATH + 32];
        part_path(s, k, path);
        pv_call call = pv_call_begin(context, "lay", 0.03 + 0.92 * k / windows, 0.03 + 0.92 * (k + 1) / windows);
        result = lay_window(s, k, path);
        pv_call_end(context, call);
    }
    pv_call call = pv_call_begin(context, "merge", 0.95, 1);
    if (!result)
        result = merge_parts(s, outputs, count);
    pv_call_end(context, call);
    return result;
}

static pave_result check_outputs(pave_context *context, const char *const *outputs, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        const char *format = pave_stones_format(outputs[i]);
        if (!format || !strcmp(format, "png"))
            return pv_fail(context, PAVE_ERR_ARGUMENT,
                           "%s: what is laid window by window is written as .svg, .json or .stones", outputs[i]);
    }
    return PAVE_OK;
}

static stream *begin(pave_context *context, pave_result *result)
{
    stream *s = pv_allocate_zeroed(context, 1, sizeof *s, result);
    if (s)
        s->context = context;
    return s;
}

static void end(stream *s)
{
    pv_bitmap_free(&s->drawing);
    pv_manifest_free(&s->plan);
    pv_release(s);
}

pave_result pave_lay_file(pave_context *context, const char *drawing, const pave_lay_params *given,
                          const pave_stream_params *stream_given, const char *const *outputs, int32_t count)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!drawing || !outputs || count < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_lay_file: no drawing or no outputs");
    int before = errno;
    pave_stream_params params;
    pave_result result = pv_params_read(context, &pv_stream_table, stream_given, &params);
    if (!result)
        result = check_outputs(context, outputs, count);
    stream *s = result ? NULL : begin(context, &result);
    if (!s)
        return result;
    pv_call call = pv_call_begin(context, "lay", 0, 1);
    result = lay_all(s, &params, drawing, given, outputs, count);
    pv_call_end(context, call);
    end(s);
    errno = before;
    return result;
}

pave_result pave_plan(pave_context *context, const char *drawing, const pave_lay_params *given,
                      const pave_stream_params *stream_given, const char *manifest, int32_t *windows)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!drawing || !manifest || !windows)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_plan: no drawing or no place for the plan");
    int before = errno;
    pave_stream_params params;
    pave_result result = pv_params_read(context, &pv_stream_table, stream_given, &params);
    stream *s = result ? NULL : begin(context, &result);
    if (!s)
        return result;
    pv_call call = pv_call_begin(context, "plan", 0, 1);
    result = make_plan(s, drawing, given, params.memory, 1);
    pv_call_end(context, call);
    *windows = s->plan.columns * s->plan.rows;
    if (!result && *windows > PV_MOST_WINDOWS)
        result = pv_fail(context, PAVE_ERR_LIMIT, "%d windows are beyond the limit of %d: give more memory",
                         (int)*windows, (int)PV_MOST_WINDOWS);
    char *path = result ? NULL : realpath(drawing, NULL);
    s->plan.drawing = path;
    if (!result)
        result = pv_manifest_write(context, &s->plan, manifest);
    free(path);
    s->plan.drawing = NULL;
    end(s);
    errno = before;
    return result;
}

static pave_result lay_shard(stream *s, const char *manifest, int32_t shard, const char *output)
{
    char path[PATH + 32];
    pave_result result = pv_manifest_read(s->context, manifest, &s->plan);
    if (result)
        return result;
    if (shard < 0 || shard >= s->plan.columns * s->plan.rows)
        return pv_fail(s->context, PAVE_ERR_ARGUMENT, "shard is %d, but the plan has shards 0 .. %d", (int)shard,
                       (int)(s->plan.columns * s->plan.rows - 1));
    if (!output) {
        result = make_folder(s, NULL, manifest);
        part_path(s, shard, path);
    }
    if (!result)
        result = read_drawing(s, s->plan.drawing, 0.1);
    if (!result && (pv_bitmap_hash(&s->drawing) != s->plan.hash || s->drawing.width != s->plan.width))
        result = pv_fail(s->context, PAVE_ERR_FORMAT, "%s: is not the drawing that %s was planned for",
                         s->plan.drawing, manifest);
    pv_call call = pv_call_begin(s->context, "lay", 0.1, 1);
    if (!result)
        result = lay_window(s, shard, output ? output : path);
    pv_call_end(s->context, call);
    return result;
}

pave_result pave_lay_shard(pave_context *context, const char *manifest, int32_t shard, const char *output)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!manifest)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_lay_shard: no plan");
    int before = errno;
    pave_result result = PAVE_OK;
    stream *s = begin(context, &result);
    if (!s)
        return result;
    pv_call call = pv_call_begin(context, "lay", 0, 1);
    result = lay_shard(s, manifest, shard, output);
    pv_call_end(context, call);
    end(s);
    errno = before;
    return result;
}
