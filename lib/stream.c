/* A pavement from file to files, window after window: read the drawing as bits, lay each window into a file of its own,
 * merge. */
#include "base/params.h"
#include "cvd/cvd.h"
#include "field/field.h"
#include "io/drawing.h"
#include "io/output.h"
#include "io/stonefile.h"
#include "stones/stones.h"

#include <pave/pave.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
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
    pave_threshold_params threshold;
    pave_field_params field;
    pave_cvd_params cvd;
    pave_stones_params stones;
    pv_bitmap drawing;
    uint64_t hash;
    int32_t margin; /* px of drawing that are laid around a window */
    int32_t columns, rows;
    char folder[PATH];
} stream;

static pave_result read_params(stream *s, const pave_lay_params *given)
{
    pave_context *context = s->context;
    static const pave_lay_params none = PAVE_LAY_PARAMS_INIT;
    const pave_lay_params *params = given ? given : &none;
    pave_result result = pv_params_read(context, &pv_threshold_table, params->threshold, &s->threshold);
    if (!result)
        result = pv_params_read(context, &pv_field_table, params->field, &s->field);
    if (!result)
        result = pv_params_read(context, &pv_cvd_table, params->cvd, &s->cvd);
    if (!result)
        result = pv_params_read(context, &pv_stones_table, params->stones, &s->stones);
    for (int i = 0; i < 4 && !result; i++)
        if (s->cvd.window[i])
            result = pv_fail(context, PAVE_ERR_ARGUMENT, "give a window or a memory, not both");
    return result;
}

/* Windows of such a size that one with its margin stays within the memory. */
static pave_result divide(stream *s, int64_t memory)
{
    pave_cvd_params cvd = s->cvd;
    double width = s->drawing.width, height = s->drawing.height;
    if (cvd.stones)
        cvd.half_side = sqrt(width * height / cvd.stones) / 2;
    s->margin = pv_margin_guess(&cvd) + (int32_t)(cvd.window_margin * cvd.half_side) + SPARE;
    double left = (double)memory - BASE - (double)s->drawing.stride * height;
    double side = floor(sqrt(fmax(left, 0) / BYTES_A_PIXEL)) - 2 * s->margin;
    if (side < s->margin / 2 && left < BYTES_A_PIXEL * width * height) {
        double least = 2.5 * s->margin;
        return pv_fail(s->context, PAVE_ERR_LIMIT, "memory is %lld bytes, but windows of this drawing need %.0f",
                       (long long)memory, least * least * BYTES_A_PIXEL + BASE + (double)s->drawing.stride * height);
    }
    if (left >= BYTES_A_PIXEL * width * height)
        side = fmax(width, height);
    s->columns = (int32_t)ceil(width / side);
    s->rows = (int32_t)ceil(height / side);
    return PAVE_OK;
}

static pv_rect window_of(const stream *s, int32_t k)
{
    int64_t column = k % s->columns, row = k / s->columns, w = s->drawing.width, h = s->drawing.height;
    int32_t left = (int32_t)(w * column / s->columns), top = (int32_t)(h * row / s->rows);
    return (pv_rect){ left, top, (int32_t)(w * (column + 1) / s->columns) - left,
                      (int32_t)(h * (row + 1) / s->rows) - top };
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
    if (s->cvd.stones) /* follows from it */
        head.cvd.half_side = s->cvd.half_side;
    return head.drawing == s->hash && head.x == w->x && head.y == w->y && head.width == w->width &&
           head.height == w->height && !memcmp(&head.cvd, &s->cvd, offsetof(pave_cvd_params, window)) &&
           !memcmp(&head.stones, &s->stones, sizeof head.stones) &&
           !memcmp(&head.field, &s->field, sizeof head.field) &&
           !memcmp(&head.threshold, &s->threshold, sizeof head.threshold);
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
    pave_cvd_params params = s->cvd;
    memcpy(params.window, &window, sizeof params.window);
    pave_result result = pv_bitmap_cut(context, &s->drawing, region.x, region.y, region.width, region.height, &drawing);
    if (!result)
        result = pave_field_create(context, drawing, &s->field, &field);
    if (!result)
        result = pv_cvd_create(context, field, &params, &needed, &cvd);
    if (cvd) {
        double lacking = pv_stones_margin(cvd, &s->stones) - pv_stones_room(cvd);
        needed = lacking > 0 ? *margin + (int32_t)ceil(lacking) : 0;
        if (needed)
            s->cvd.window_margin += lacking / pave_cvd_half_side(cvd) + 1;
    }
    if (!result && !needed)
        result = pave_stones_create(context, drawing, field, cvd, &s->stones, out);
    *margin = (needed > *margin ? needed : *margin) + SPARE;
    pave_cvd_free(&cvd);
    pave_field_free(&field);
    pave_image_free(&drawing);
    return result;
}

static pave_result lay_window(stream *s, int32_t k)
{
    char path[PATH + 32];
    pv_rect window = window_of(s, k);
    pave_stones *stones = NULL;
    pave_result result = PAVE_OK;
    int32_t margin = s->margin;
    part_path(s, k, path);
    if (is_done(s, path, &window))
        return PAVE_OK;
    while (!result && !stones)
        result = lay_region(s, window, &margin, &stones);
    if (!result) {
        stones->drawing = s->hash;
        stones->threshold = s->threshold;
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
    int32_t parts = s->columns * s->rows;
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

static pave_result lay_all(stream *s, const pave_stream_params *params, const char *drawing,
                           const char *const *outputs, int32_t count)
{
    pave_context *context = s->context;
    pv_call call = pv_call_begin(context, "read", 0, 0.03);
    pave_result result = pv_drawing_read(context, drawing, &s->threshold, &s->drawing);
    pv_call_end(context, call);
    if (result)
        return result;
    s->hash = pv_bitmap_hash(&s->drawing);
    result = divide(s, params->memory ? params->memory : DEFAULT_MEMORY);
    if (!result)
        result = make_folder(s, params->folder, outputs[0]);
    int32_t windows = s->columns * s->rows;
    for (int32_t k = 0; k < windows && !result; k++) {
        call = pv_call_begin(context, "lay", 0.03 + 0.92 * k / windows, 0.03 + 0.92 * (k + 1) / windows);
        result = lay_window(s, k);
        pv_call_end(context, call);
    }
    call = pv_call_begin(context, "merge", 0.95, 1);
    if (!result)
        result = merge_parts(s, outputs, count);
    pv_call_end(context, call);
    return result;
}

pave_result pave_lay_file(pave_context *context, const char *drawing, const pave_lay_params *given,
                          const pave_stream_params *stream_given, const char *const *outputs, int32_t count)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!drawing || !outputs || count < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_lay_file: no drawing or no outputs");
    pave_stream_params params;
    pave_result result = pv_params_read(context, &pv_stream_table, stream_given, &params);
    for (int32_t i = 0; i < count && !result; i++) {
        const char *format = pave_stones_format(outputs[i]);
        if (!format || !strcmp(format, "png"))
            result = pv_fail(context, PAVE_ERR_ARGUMENT,
                             "%s: what is laid window by window is written as .svg, .json or .stones", outputs[i]);
    }
    stream *s = result ? NULL : pv_allocate_zeroed(context, 1, sizeof *s, &result);
    if (!s)
        return result;
    int before = errno;
    s->context = context;
    result = read_params(s, given);
    pv_call call = pv_call_begin(context, "lay", 0, 1);
    if (!result)
        result = lay_all(s, &params, drawing, outputs, count);
    pv_call_end(context, call);
    pv_bitmap_free(&s->drawing);
    pv_release(s);
    errno = before;
    return result;
}
