/* A pavement from file to files, window after window: read the drawing as bits, lay each window into a file of its own,
 * merge. */
#include "stream.h"

#include "base/params.h"
#include "io/output.h"
#include "io/stonefile.h"

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
    SPARE = 8,             /* px of drawing around what a diagram is asked for */
    BYTES_A_PIXEL = 18,    /* of a region: drawing, field, edges, labels, and its share of sites and polygons */
    BYTES_BEST = 12,       /* and of the diagram's own pixels in best mode: labels, pieces, tessellation */
    BASE = 160 << 20,      /* code, image libraries, a driver */
    DEFAULT_MEMORY = 1 << 30,
};

int32_t pv_stream_windows(const pv_stream *s)
{
    return s->plan.columns * s->plan.rows;
}

static pave_result read_params(pv_stream *s, const pave_lay_params *given)
{
    pave_context *context = s->context;
    static const pave_lay_params none = PAVE_LAY_PARAMS_INIT;
    const pave_lay_params *params = given ? given : &none;
    pave_result result = pv_params_read(context, &pv_threshold_table, params->threshold, &s->plan.threshold);
    if (!result)
        result = pv_params_read(context, &pv_palette_table, params->palette, &s->plan.palette);
    if (!result)
        result = pv_params_read(context, &pv_field_table, params->field, &s->plan.field);
    if (!result)
        result = pv_params_read(context, &pv_cvd_table, params->cvd, &s->plan.cvd);
    if (!result)
        result = pv_params_read(context, &pv_stones_table, params->stones, &s->plan.stones);
    if (!s->plan.cvd.supersample)
        s->plan.cvd.supersample = pv_stones_supersample(&s->plan.stones);
    if (!result && s->plan.cvd.until_still > 0)
        result = pv_fail(context, PAVE_ERR_ARGUMENT,
                         "until_still looks at all sites of a plane: it is not for what is laid window by window");
    for (int i = 0; i < 4 && !result; i++)
        if (s->plan.cvd.window[i])
            result = pv_fail(context, PAVE_ERR_ARGUMENT, "give a window or a memory, not both");
    return result;
}

static double bytes_a_pixel(const pv_stream *s)
{
    int32_t scale = s->plan.cvd.supersample, bytes = BYTES_A_PIXEL + (s->drawing.cut != 0);
    return s->plan.stones.mode == PAVE_MODE_PAPER ? bytes : bytes + BYTES_BEST * scale * scale;
}

/* How far around a plane that repeats its diagram and its stones are computed, if that is done for the whole. */
static double whole_around(const pave_cvd_params *cvd)
{
    double around = pv_torus_guess(cvd), stones = cvd->window_margin * cvd->half_side;
    return stones > around ? stones : around;
}

static double margin_for(const pv_stream *s, const pave_cvd_params *cvd, int whole)
{
    pave_cvd_params like = *cvd;
    like.window[2] = like.window[3] = !whole;
    return fmax(cvd->window_margin, pv_stones_margin_guess(s->drawing.width, s->drawing.height,
                                                           s->plan.field.periodic, &like, &s->plan.stones));
}

/* Windows of such a size that one with its margin stays within the memory. */
static pave_result divide(pv_stream *s, int64_t memory)
{
    pave_cvd_params cvd = s->plan.cvd;
    double width = s->drawing.width, height = s->drawing.height;
    if (cvd.stones)
        cvd.half_side = sqrt(width * height / cvd.stones) / 2;
    double held = s->drawing.bits ? (double)s->drawing.stride * height : 0, left = (double)memory - BASE - held;
    cvd.window_margin = margin_for(s, &s->plan.cvd, 1);
    double around = s->plan.field.periodic ? 2 * whole_around(&cvd) : 0;
    double bytes = bytes_a_pixel(s), whole = bytes * (width + around) * (height + around);
    if (left < whole)
        cvd.window_margin = margin_for(s, &s->plan.cvd, 0);
    s->plan.cvd.window_margin = cvd.window_margin;
    s->plan.margin = pv_margin_guess(&cvd, 0) + (int32_t)(cvd.window_margin * cvd.half_side) + SPARE;
    double pixels = fmax(left, 0) / bytes, span = sqrt(pixels), narrow = fmin(width, height);
    if (narrow < span && !s->plan.field.periodic) /* windows reach from side to side */
        span = pixels / narrow;
    double side = floor(span) - 2 * s->plan.margin;
    if (side < s->plan.margin / 2 && left < whole) {
        double least = 2.5 * s->plan.margin;
        return pv_fail(s->context, PAVE_ERR_LIMIT, "memory is %lld bytes, but windows of this drawing need %.0f",
                       (long long)memory, least * least * bytes + BASE + held);
    }
    if (left >= whole)
        side = fmax(width, height);
    s->plan.columns = (int32_t)ceil(width / side);
    s->plan.rows = (int32_t)ceil(height / side);
    int64_t windows = (int64_t)s->plan.columns * s->plan.rows;
    return windows <= PV_MOST_WINDOWS ? PAVE_OK
                                      : pv_fail(s->context, PAVE_ERR_LIMIT,
                                                "%lld windows are beyond the limit of %d: give more memory",
                                                (long long)windows, (int)PV_MOST_WINDOWS);
}

void pv_stream_part(const pv_stream *s, int32_t k, char path[PV_PATH + PV_PART])
{
    snprintf(path, PV_PATH + PV_PART, "%s/%06d.stones", s->folder, (int)k);
}

/* Was this window laid before, from the same drawing and parameters? */
static int is_done(const pv_stream *s, const char *path, const pv_rect *w)
{
    pv_stone_file_head head;
    const char *reason;
    if (pv_stones_file_look(path, &head, &reason))
        return 0;
    if (s->plan.cvd.stones) /* follows from it */
        head.cvd.half_side = s->plan.cvd.half_side;
    const pv_manifest *plan = &s->plan;
    pv_making making = { plan->hash, &plan->threshold, &plan->palette, &plan->field, &plan->cvd, &plan->stones };
    return head.x == w->x && head.y == w->y && head.width == w->width && head.height == w->height &&
           pv_stones_file_same(&head, &making);
}

/* As much of the drawing as a window needs: where it repeats that may lie beyond its borders, but one period is enough
 * of it, in itself. */
static pv_rect choose_region(const pv_stream *s, pv_rect window, int32_t margin)
{
    const pv_rect plane = { 0, 0, s->drawing.width, s->drawing.height };
    const pv_rect everywhere = { -(1 << 29), -(1 << 29), 1 << 30, 1 << 30 };
    pv_rect region = pv_rect_grown(window, margin, s->plan.field.periodic ? everywhere : plane);
    double around = s->plan.field.periodic ? 2 * whole_around(&s->plan.cvd) : 0;
    double whole = (plane.width + around) * (plane.height + around);
    return (double)region.width * region.height < whole ? region : plane;
}

/* A part of the drawing; where thin features are widened, from some more of it. */
static pave_result cut_drawing(pv_stream *s, pv_rect region, pave_image **out)
{
    const pave_palette *palette = &s->plan.palette.palette;
    const pv_bitmap *from = &s->drawing;
    int32_t w = from->width, h = from->height, repeats = s->plan.field.periodic;
    double least = pv_stones_thin_width(w, h, &s->plan.cvd, &s->plan.stones);
    int32_t around = least > 1 ? pv_widen_reach((int32_t)ceil(least)) : 0;
    const pv_rect plane = { 0, 0, w, h }, everywhere = { -(1 << 29), -(1 << 29), 1 << 30, 1 << 30 };
    int whole = region.width == w && region.height == h;
    pv_rect more = whole ? region : pv_rect_grown(region, around, repeats ? everywhere : plane);
    pave_image *wide = NULL;
    pave_result result = pv_drawing_cut(s->context, from, palette, more.x, more.y, more.width, more.height, &wide);
    if (!result)
        result = pv_stones_widen(s->context, &s->plan.cvd, &s->plan.stones, repeats, &wide);
    *out = wide;
    if (result || (more.width == region.width && more.height == region.height))
        return result;
    pv_place part = { region.x - more.x, region.y - more.y, region.width, region.height };
    result = pv_image_crop(s->context, wide, part, out);
    pave_image_free(&wide);
    return result;
}

/* The stones of a window from so much of the drawing around it; NULL, and a larger margin, if that is too little. */
static pave_result lay_region(pv_stream *s, pv_rect window, int32_t *margin, pave_stones **out)
{
    pave_context *context = s->context;
    pv_rect region = choose_region(s, window, *margin);
    pave_image *drawing = NULL;
    pave_field *field = NULL;
    pave_cvd *cvd = NULL;
    int32_t needed = 0;
    pave_cvd_params params = s->plan.cvd;
    memcpy(params.window, &window, sizeof params.window);
    pave_result result = cut_drawing(s, region, &drawing);
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

pave_result pv_stream_lay(pv_stream *s, int32_t k, const char *path)
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

pave_result pv_stream_set_folder(pv_stream *s, const char *folder, const char *output)
{
    int length = snprintf(s->folder, sizeof s->folder, "%s%s", folder ? folder : output, folder ? "" : ".parts");
    if (length >= (int)sizeof s->folder)
        return pv_fail(s->context, PAVE_ERR_ARGUMENT, "%s: the name is too long", output);
    return PAVE_OK;
}

pave_result pv_stream_make_folder(const pv_stream *s)
{
    if (mkdir(s->folder, 0777) && errno != EEXIST)
        return pv_fail(s->context, PAVE_ERR_IO, "%s: cannot be made: %s", s->folder, pv_system_error(errno));
    return PAVE_OK;
}

/* The names of all parts, one after the other, and where each begins. */
static pave_result name_parts(pv_stream *s, char **names, const char ***paths)
{
    int32_t parts = pv_stream_windows(s);
    size_t length = strlen(s->folder) + PV_PART;
    pave_result result = PAVE_OK;
    *names = pv_allocate(s->context, (size_t)parts, length, &result);
    *paths = result ? NULL : pv_allocate(s->context, (size_t)parts, sizeof **paths, &result);
    for (int32_t k = 0; k < parts && !result; k++) {
        char path[PV_PATH + PV_PART];
        pv_stream_part(s, k, path);
        (*paths)[k] = strcpy(*names + (size_t)k * length, path);
    }
    return result;
}

pave_result pv_stream_merge(pv_stream *s, const char *const *outputs, int32_t count)
{
    char *names = NULL;
    const char **paths = NULL;
    pave_result result = name_parts(s, &names, &paths);
    for (int32_t i = 0; i < count && !result; i++) {
        pv_call call = pv_call_begin(s->context, "merge", (double)i / count, (i + 1.0) / count);
        result = pave_stones_merge(s->context, paths, pv_stream_windows(s), outputs[i], NULL);
        pv_call_end(s->context, call);
    }
    pv_release(paths);
    pv_release(names);
    return result;
}

static void remove_parts(const pv_stream *s)
{
    char path[PV_PATH + PV_PART];
    for (int32_t k = 0; k < pv_stream_windows(s); k++) {
        pv_stream_part(s, k, path);
        unlink(path);
    }
    rmdir(s->folder);
}

pave_result pv_stream_read(pv_stream *s, const char *drawing, pv_room room, double to, uint64_t *hash)
{
    pave_palette_params *p = &s->plan.palette;
    pave_result result = PAVE_OK;
    int finds = p->colours && !p->palette.count;
    pv_call call = pv_call_begin(s->context, "read", 0, finds ? to / 2 : 0);
    if (finds)
        result = pv_palette_read(s->context, drawing, p->colours, &room, &p->palette);
    pv_call_end(s->context, call);
    p->colours = p->palette.count; /* as a drawing in memory has it */
    call = pv_call_begin(s->context, "read", finds ? to / 2 : 0, to);
    if (!result)
        result = pv_drawing_read(s->context, drawing, &s->plan.threshold, &p->palette, &room, &s->drawing);
    if (!result)
        result = pv_bitmap_hash(s->context, &s->drawing, hash);
    pv_call_end(s->context, call);
    return result;
}

pave_result pv_stream_plan(pv_stream *s, const char *drawing, const pave_lay_params *given, int64_t memory,
                           const char *beside, double to)
{
    memory = memory ? memory : DEFAULT_MEMORY;
    pv_room room = { memory > BASE ? memory - BASE : 0, beside };
    pave_result result = read_params(s, given);
    if (!result)
        result = pv_stream_read(s, drawing, room, to, &s->plan.hash);
    if (result)
        return result;
    s->plan.width = s->drawing.width;
    s->plan.height = s->drawing.height;
    return divide(s, memory);
}

pv_room pv_stream_room(const pv_stream *s, const char *beside)
{
    pv_rect w = pv_manifest_window(&s->plan, 0);
    int64_t margin = 2 * (int64_t)s->plan.margin, most = DEFAULT_MEMORY - BASE;
    double bytes = (double)(w.width + margin) * (double)(w.height + margin) * bytes_a_pixel(s);
    return (pv_room){ bytes > (double)most ? (int64_t)bytes : most, beside };
}

static pave_result lay_all(pv_stream *s, const pave_stream_params *params, const char *drawing,
                           const pave_lay_params *given, const char *const *outputs, int32_t count)
{
    pave_context *context = s->context;
    pave_result result = pv_stream_plan(s, drawing, given, params->memory, outputs[0], 0.03);
    if (!result)
        result = pv_stream_set_folder(s, params->folder, outputs[0]);
    if (!result)
        result = pv_stream_make_folder(s);
    int32_t windows = pv_stream_windows(s);
    for (int32_t k = 0; k < windows && !result; k++) {
        char path[PV_PATH + PV_PART];
        pv_stream_part(s, k, path);
        pv_call call = pv_call_begin(context, "lay", 0.03 + 0.92 * k / windows, 0.03 + 0.92 * (k + 1) / windows);
        result = pv_stream_lay(s, k, path);
        pv_call_end(context, call);
    }
    pv_call call = pv_call_begin(context, "merge", 0.95, 1);
    if (!result)
        result = pv_stream_merge(s, outputs, count);
    pv_call_end(context, call);
    if (!result)
        remove_parts(s);
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

pv_stream *pv_stream_begin(pave_context *context, pave_result *result)
{
    pv_stream *s = pv_allocate_zeroed(context, 1, sizeof *s, result);
    if (s)
        s->context = context;
    return s;
}

void pv_stream_end(pv_stream *s)
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
    pv_stream *s = result ? NULL : pv_stream_begin(context, &result);
    if (!s)
        return result;
    pv_call call = pv_call_begin(context, "lay", 0, 1);
    result = lay_all(s, &params, drawing, given, outputs, count);
    pv_call_end(context, call);
    pv_stream_end(s);
    errno = before;
    return result;
}
