/* The OpenGL ES engine, the paper's own way: every site's frustum drawn into a depth buffer, the nearest one is seen.
 *
 * A frustum is drawn as its box grown by a margin. Where the label seen is no farther than the margin, no site that is
 * nearer can have been left out, so it is right: that is tested for every pixel. If too many fail the margin grows and
 * the tile is drawn again; what is left, and all beyond the reach of 32 bits, is labelled by the CPU, in tiles of its
 * own. The plane is drawn in tiles of about PIXELS, and these in slices of about FRAGMENTS, between which the engine
 * can be cancelled. */
#include "backend/egl/raster.h"
#include "backend/metric.h"

#include "base/parallel.h"
#include "util/fixed.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

enum {
    PIXELS = 1 << 20,
    MOST_SIDE = 4096,    /* px: floats hold places within a tile to 1/16 of the grid of sites */
    FEW = 8,             /* a tile is drawn again if more than one in so many CPU tiles fails */
    RARE = 64,           /* the next step's margin would have failed in one CPU tile in so many */
};

typedef struct job {
    pv_gl_raster *r;
    const pv_gl_tile *t;
    int32_t *labels; /* of the whole plane; NULL: not wanted */
} job;

static int32_t cpu_tiles(int32_t pixels)
{
    return (pixels + PV_TILE - 1) / PV_TILE;
}

static int32_t run_end(const uint32_t *row, int32_t x, int32_t end)
{
    uint32_t label = row[x];
    while (x < end && row[x] == label)
        x++;
    return x;
}

/* Distance of a pixel in px, rounded up, with the metric's errors on top. */
static int32_t away(int32_t metric, const pave_site *site, int32_t x, int32_t y)
{
    uint64_t d = pv_metric(metric, site, 256 * x + 128, 256 * y + 128);
    if (d >= (uint64_t)PV_METRIC_NARROW * PV_METRIC_NARROW)
        return PV_GL_UNPROVEN;
    return ((int32_t)sqrtf((float)d) + PV_GL_SLACK) / 256 + 1;
}

/* How far the pixels of a row of CPU tiles are from their sites. All metrics are convex: of a run of pixels only the
 * ends are measured. */
static void measure_task(void *data, int32_t ty, int32_t worker)
{
    (void)worker;
    const job *j = data;
    const pv_gl_raster *r = j->r;
    const pv_gl_tile *t = j->t;
    int32_t metric = r->cpu->plane.metric;
    uint8_t *worst = r->worst + ty * cpu_tiles(t->width);
    memset(worst, 0, (size_t)cpu_tiles(t->width));
    for (int32_t y = ty * PV_TILE; y < pv_gl_min((ty + 1) * PV_TILE, t->height); y++) {
        const uint32_t *row = r->labels + (size_t)y * (size_t)t->width;
        for (int32_t x = 0, end; x < t->width; x = end) {
            end = run_end(row, x, t->width);
            int32_t d = PV_GL_UNPROVEN;
            if (row[x] < (uint32_t)r->cpu->plane.sites) {
                const pave_site *site = &r->cpu->sites[row[x]];
                d = pv_gl_max(away(metric, site, t->x + x, t->y + y), away(metric, site, t->x + end - 1, t->y + y));
            }
            for (int32_t tx = x / PV_TILE; tx <= (end - 1) / PV_TILE; tx++)
                worst[tx] = (uint8_t)pv_gl_max(worst[tx], d);
        }
    }
}

static void take_unmasked(const job *j, int32_t from, int32_t to, int32_t y, pv_sum *sums)
{
    const pv_gl_tile *t = j->t;
    pv_sum *sum = &sums[j->r->labels[(size_t)y * (size_t)t->width + (size_t)from]];
    for (int32_t x = from; x < to; x++)
        if (!pv_masked(&j->r->cpu->plane, t->x + x, t->y + y))
            pv_sum_add(sum, 1, t->x + x, t->y + y);
}

/* Takes over proven pixels: columns from..to of a row of CPU tiles. */
static void take(const job *j, int32_t ty, int32_t from, int32_t to, pv_sum *sums)
{
    const pv_gl_tile *t = j->t;
    for (int32_t y = ty * PV_TILE; y < pv_gl_min((ty + 1) * PV_TILE, t->height); y++) {
        const uint32_t *row = j->r->labels + (size_t)y * (size_t)t->width;
        for (int32_t x = from, end; x < to; x = end) {
            end = run_end(row, x, to);
            int64_t count = end - x;
            if (!j->r->cpu->plane.mask)
                pv_sum_add(&sums[row[x]], count, count * (2 * t->x + x + end - 1) / 2, count * (t->y + y));
            else
                take_unmasked(j, x, end, y, sums);
        }
        if (j->labels)
            memcpy(j->labels + (int64_t)(t->y + y) * j->r->cpu->plane.width + t->x + from, row + from,
                   (size_t)(to - from) * sizeof *row);
    }
}

/* How far a pixel of a proven CPU tile can be from its site, if the tile counts. */
static int32_t distance_in(const job *j, int32_t tx, int32_t ty)
{
    const pv_gl_tile *t = j->t;
    int counts = pv_watched(j->r->cpu, t->x + tx * PV_TILE, t->y + ty * PV_TILE);
    return counts ? pv_cpu_range(j->r->cpu, 256 * j->r->worst[ty * cpu_tiles(t->width) + tx]) : 0;
}

/* Takes over what is proven of a row of CPU tiles, and labels the rest. */
static void collect_task(void *data, int32_t ty, int32_t worker)
{
    const job *j = data;
    const pv_gl_tile *t = j->t;
    const pv_cpu *cpu = j->r->cpu;
    int32_t across = cpu_tiles(t->width), margin = j->r->margin;
    const uint8_t *worst = j->r->worst + ty * across;
    pv_sum *sums = cpu->sums + (size_t)worker * (size_t)cpu->plane.sites;
    int32_t radius = 0;
    for (int32_t tx = 0, end; tx < across; tx = end) {
        end = tx + 1;
        if (worst[tx] > margin) {
            int32_t x = t->x + tx * PV_TILE, y = t->y + ty * PV_TILE;
            int32_t here = pv_label_tile_portable(cpu, x, y, sums, j->labels);
            radius = pv_watched(cpu, x, y) ? pv_gl_max(radius, here) : radius;
            continue;
        }
        radius = pv_gl_max(radius, distance_in(j, tx, ty));
        for (; end < across && worst[end] <= margin; end++)
            radius = pv_gl_max(radius, distance_in(j, end, ty));
        take(j, ty, tx * PV_TILE, pv_gl_min(end * PV_TILE, t->width), sums);
    }
    pv_raise(&j->r->radius, radius);
}

static int32_t unproven(const pv_gl_raster *r, int32_t tiles)
{
    int32_t count = 0;
    for (int32_t i = 0; i < tiles; i++)
        count += r->worst[i] > r->margin;
    return count;
}

/* Draws the tile until few enough CPU tiles are unproven. */
static pave_result see(pave_context *context, pv_gl_raster *r, job *j, double done)
{
    int32_t tiles = cpu_tiles(j->t->width) * cpu_tiles(j->t->height);
    pave_result result;
    for (;;) {
        result = pv_gl_draw(context, r, j->t, done);
        if (!result)
            result = pv_parallel(context, cpu_tiles(j->t->height), measure_task, j, done, done);
        if (result || r->margin == r->most || unproven(r, tiles) <= tiles / FEW)
            return result;
        r->margin = pv_gl_min(r->margin + r->margin / 2 + 1, r->most);
    }
}

static pave_result label_tile(pave_context *context, pv_gl_raster *r, const pv_gl_tile *t, int32_t *labels,
                              double from, double to)
{
    job j = { r, t, labels };
    int32_t tiles = cpu_tiles(t->width) * cpu_tiles(t->height);
    pave_result result = PAVE_OK;
    if (r->margin)
        result = see(context, r, &j, from);
    else
        memset(r->worst, PV_GL_UNPROVEN, (size_t)tiles);
    if (result)
        return result;
    for (int32_t i = 0; i < tiles; i++)
        r->found[r->worst[i]]++;
    r->tiles += tiles;
    r->mended += unproven(r, tiles);
    return pv_parallel(context, cpu_tiles(t->height), collect_task, &j, from, to);
}

/* Sites move little from step to step: the margin that would have been right is right for the next. Where it is not
 * known it grows slowly, for at first the distances shrink by themselves. */
static void adapt(pv_gl_raster *r)
{
    int64_t all = 0, beyond = 0;
    for (int32_t i = 0; i <= PV_GL_UNPROVEN; i++)
        all += r->found[i];
    int32_t px = PV_GL_UNPROVEN;
    for (; px > 1 && beyond + r->found[px] <= all / RARE; px--)
        beyond += r->found[px];
    r->margin = pv_gl_min(px < PV_GL_UNPROVEN ? px : r->margin + r->margin / 4 + 1, r->most);
    memset(r->found, 0, sizeof r->found);
}

static pave_result label_all(pave_context *context, pv_gl_raster *r, int32_t *labels, double from, double to)
{
    const pv_plane *plane = &r->cpu->plane;
    int32_t across = (int32_t)pv_ceil_div(plane->width, r->width), tile_count;
    tile_count = across * (int32_t)pv_ceil_div(plane->height, r->height);
    double share = (to - from) / tile_count;
    pave_result result = pv_cpu_sort(context, r->cpu, from);
    atomic_store(&r->radius, 0);
    for (int32_t i = 0; i < tile_count && !result; i++) {
        pv_gl_tile t = { .x = i % across * r->width, .y = i / across * r->height };
        t.width = pv_gl_min(plane->width - t.x, r->width);
        t.height = pv_gl_min(plane->height - t.y, r->height);
        result = label_tile(context, r, &t, labels, from + i * share, from + (i + 1) * share);
    }
    if (!result)
        adapt(r);
    return result;
}

static pave_result gles_step(pave_context *context, void *engine, int32_t iteration, double from, double to,
                             pv_step *out)
{
    pv_gl_raster *r = engine;
    double middle = from + 0.9 * (to - from);
    pv_cpu_watch(r->cpu, out->deep);
    pave_result result = label_all(context, r, NULL, from, middle);
    out->radius = atomic_load(&r->radius);
    return result ? result : pv_cpu_relax(context, r->cpu, iteration, middle, to, out);
}

static pave_result gles_labels(pave_context *context, void *engine, double from, double to, int32_t *labels)
{
    return label_all(context, engine, labels, from, to);
}

static pave_result gles_sites(pave_context *context, void *engine, pave_site *sites)
{
    const pv_gl_raster *r = engine;
    (void)context;
    memcpy(sites, r->cpu->sites, (size_t)r->cpu->plane.sites * sizeof *sites);
    return PAVE_OK;
}

double pv_gles_mended(const void *engine)
{
    const pv_gl_raster *r = engine;
    return (double)r->mended / (double)r->tiles;
}

static void gles_close(void *engine)
{
    pv_gl_raster *r = engine;
    if (!r)
        return;
    pv_gl_close(&r->gl);
    pv_cpu_close(r->cpu);
    pv_release(r->records);
    pv_release(r->marks);
    pv_release(r->labels);
    pv_release(r->worst);
    pv_release(r);
}

/* Tiles are as square as the plane lets them be. */
static void choose_sides(pv_gl_raster *r, const pv_plane *plane)
{
    int32_t width = cpu_tiles(plane->width) * PV_TILE, height = cpu_tiles(plane->height) * PV_TILE;
    int32_t most = pv_gl_min(r->gl.most_side, MOST_SIDE) / PV_TILE * PV_TILE, side = pv_gl_min(most, 1024);
    r->width = pv_gl_min(width, pv_gl_min(most, PIXELS / pv_gl_min(height, side) / PV_TILE * PV_TILE));
    r->height = pv_gl_min(height, pv_gl_min(most, PIXELS / r->width / PV_TILE * PV_TILE));
}

/* Of one site after the other, from the slice in the buffer. */
static void describe_records(const pv_gl *gl)
{
    static const size_t offset[] = { offsetof(pv_gl_record, x), offsetof(pv_gl_record, half_x) };
    static const GLint components[] = { 4, 3 };
    GLuint buffer;
    gl->GenBuffers(1, &buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, buffer);
    for (GLuint i = 0; i < 2; i++) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribIPointer(i, components[i], GL_INT, sizeof(pv_gl_record), (const void *)offset[i]);
        gl->VertexAttribDivisor(i, 1);
    }
}

static const char *set_up_drawing(pv_gl_raster *r, int32_t metric)
{
    pv_gl *gl = &r->gl;
    const char *reason = pv_gl_targets(gl, r->width, r->height);
    if (!reason)
        reason = pv_gl_program(gl);
    if (reason)
        return reason;
    describe_records(gl);
    float x = (float)(r->width + 2 * PV_GL_FRAME), y = (float)(r->height + 2 * PV_GL_FRAME);
    gl->Uniform1i(gl->metric, metric);
    gl->Uniform4f(gl->frame, 2 / (256 * x), 2 / (256 * y), 2 * PV_GL_FRAME / x - 1, 2 * PV_GL_FRAME / y - 1);
    return NULL;
}

static pave_result open_device(pave_context *context, pv_gl_raster *r, const pv_plane *plane, char *name)
{
    pv_gl_host host;
    const char *reason = pv_gl_open(&r->gl);
    if (reason)
        return pv_fail(context, PAVE_ERR_DEVICE, "OpenGL ES cannot be used: %s", reason);
    choose_sides(r, plane);
    pave_result result = pv_gl_raster_enter(context, r, &host);
    if (result)
        return result;
    const char *renderer = (const char *)r->gl.GetString(GL_RENDERER);
    snprintf(name, 128, "gles on %.100s", renderer ? renderer : "an unnamed device");
    reason = set_up_drawing(r, plane->metric);
    result = pv_gl_raster_leave(context, r, &host);
    return reason && !result ? pv_fail(context, PAVE_ERR_DEVICE, "OpenGL ES cannot be used: %s", reason) : result;
}

static pave_result allocate(pave_context *context, pv_gl_raster *r, const pv_plane *plane)
{
    pave_result result = PAVE_OK;
    size_t pixels = (size_t)r->width * (size_t)r->height;
    r->records = pv_allocate(context, PV_GL_RECORDS, sizeof *r->records, &result);
    if (!result)
        r->marks = pv_allocate_zeroed(context, (size_t)plane->sites / 64 + 1, sizeof *r->marks, &result);
    if (!result)
        r->labels = pv_allocate(context, pixels * (size_t)r->gl.components, sizeof *r->labels, &result);
    if (!result)
        r->worst = pv_allocate(context, pixels / (PV_TILE * PV_TILE), sizeof *r->worst, &result);
    return result;
}

static pave_result gles_open(pave_context *context, const pv_plane *plane, void **engine, char *name)
{
    pave_result result;
    pv_gl_raster *r = pv_allocate_zeroed(context, 1, sizeof *r, &result);
    if (!r)
        return result;
    void *cpu = NULL;
    result = open_device(context, r, plane, name);
    if (!result)
        result = allocate(context, r, plane);
    if (!result)
        result = pv_cpu_open(context, plane, pv_label_row_portable, &cpu);
    r->cpu = cpu;
    if (result) {
        gles_close(r);
        return result;
    }
    r->most = pv_gl_max((int32_t)((PV_METRIC_NARROW - r->cpu->reach) / r->cpu->stretch - PV_GL_SLACK) / 256, 0);
    r->margin = pv_gl_min(3 * plane->cell / 1024 + 2, r->most);
    *engine = r;
    return PAVE_OK;
}

const pv_backend pv_gles_backend = {
    PAVE_BACKEND_GLES, gles_open, gles_step, gles_labels, gles_sites, gles_close, pv_gles_list,
};
