/* The OpenGL ES engine, the paper's own way: every site's frustum drawn into a depth buffer, the nearest one is seen.
 *
 * A frustum is drawn as its box grown by a margin. Where the label seen is no farther than the margin, no site that is
 * nearer can have been left out, so it is right: that is tested for every pixel. If too many fail the margin grows and
 * the tile is drawn again; what is left, and all beyond the reach of 32 bits, is labelled by the CPU, in tiles of its
 * own. The plane is drawn in tiles of about PIXELS, and these in slices of about FRAGMENTS, between which the engine
 * can be cancelled. */
#include "backend/cpu.h"
#include "backend/egl/egl.h"
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
    FRAGMENTS = 1 << 22,
    RECORDS = 1 << 14,   /* sites in a slice */
    SLACK = 8,           /* more than the metric's errors within its narrow range, twice: 1/256 px */
    SPREAD = 32,         /* the same, and two subpixels of 1/16 px by which a corner may be drawn off its place */
    UNPROVEN = UINT8_MAX,
    FEW = 8,             /* a tile is drawn again if more than one in so many CPU tiles fails */
    RARE = 64,           /* the next step's margin would have failed in one CPU tile in so many */
};

/* A site as the vertex shader takes it, relative to the tile. */
typedef struct record {
    int32_t x, y, cosine, sine, half_x, half_y, index;
} record;

typedef struct tile {
    int32_t x, y, width, height; /* px */
} tile;

typedef struct raster {
    pv_gl gl;
    pv_cpu *cpu;
    int32_t width, height;   /* of the targets, px */
    int32_t margin, most;    /* px */
    record *records;         /* the slice */
    int32_t count;
    double fragments;
    uint64_t *marks;         /* a bit for each site that is near the tile */
    int32_t low, high;       /* words of it, from .. to, that may have bits */
    uint32_t *labels;        /* of the tile, as seen */
    uint8_t *worst;          /* for each CPU tile, the greatest distance of a pixel in px, rounded up; or UNPROVEN */
    int64_t found[UINT8_MAX + 1]; /* CPU tiles of this pass, by their worst */
    atomic_int radius;            /* no pixel of this pass is farther from its site, 1/256 px */
    int64_t tiles, mended;        /* CPU tiles since the engine was opened, and those that were unproven */
} raster;

static int32_t min(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t max(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static pave_result enter(pave_context *context, const raster *r, pv_gl_host *host)
{
    if (pv_gl_enter(&r->gl, host))
        return PAVE_OK;
    return pv_fail(context, PAVE_ERR_DEVICE, "OpenGL ES cannot be used: its context cannot be made current");
}

/* Between enter and leave nothing may call back, so faults are told afterwards. */
static pave_result leave(pave_context *context, const raster *r, const pv_gl_host *host)
{
    const char *fault = pv_gl_fault(&r->gl);
    pv_gl_leave(&r->gl, host);
    return *fault ? pv_fail(context, PAVE_ERR_DEVICE, "OpenGL ES failed: %s", fault) : PAVE_OK;
}

static void mark_row(raster *r, const tile *t, int32_t from, int32_t to, int32_t around)
{
    const pv_cpu *cpu = r->cpu;
    int32_t left = 256 * t->x - around, right = 256 * (t->x + t->width) + around;
    int32_t top = 256 * t->y - around, bottom = 256 * (t->y + t->height) + around;
    for (int32_t i = from; i < to; i++) {
        const pave_site *s = pv_cpu_sorted(cpu, i);
        if (s->x < left || s->x > right || s->y < top || s->y > bottom)
            continue;
        int32_t word = cpu->index[i] / 64;
        r->marks[word] |= (uint64_t)1 << cpu->index[i] % 64;
        r->low = min(r->low, word);
        r->high = max(r->high, word + 1);
    }
}

/* Marks the sites that a pixel of the tile may be within the margin of. */
static void mark(raster *r, const tile *t)
{
    const pv_cpu *cpu = r->cpu;
    int32_t around = 256 * r->margin + cpu->reach + SLACK, bucket = cpu->bucket;
    int32_t left = max(256 * t->x - around, 0) / bucket, top = max(256 * t->y - around, 0) / bucket;
    int32_t right = min((256 * (t->x + t->width) + around) / bucket, cpu->across - 1);
    int32_t bottom = min((256 * (t->y + t->height) + around) / bucket, cpu->down - 1);
    r->low = INT32_MAX;
    r->high = 0;
    for (int32_t row = top; row <= bottom; row++) {
        const int32_t *first = cpu->first + (int64_t)row * cpu->across;
        mark_row(r, t, first[left], first[right + 1], around);
    }
}

static pave_result begin(pave_context *context, const raster *r, const tile *t)
{
    static const GLuint none[4] = { UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX };
    static const GLfloat farthest = 1;
    const pv_gl *gl = &r->gl;
    pv_gl_host host;
    pave_result result = enter(context, r, &host);
    if (result)
        return result;
    gl->Scissor(0, 0, t->width, t->height);
    gl->ClearBufferuiv(GL_COLOR, 0, none);
    gl->ClearBufferfv(GL_DEPTH, 0, &farthest);
    gl->Uniform1f(gl->margin, (GLfloat)(256 * r->margin + SPREAD));
    return leave(context, r, &host);
}

/* Draws the slice. */
static pave_result draw_slice(pave_context *context, raster *r, double done)
{
    const pv_gl *gl = &r->gl;
    pv_gl_host host;
    pave_result result = enter(context, r, &host);
    if (result)
        return result;
    gl->BufferData(GL_ARRAY_BUFFER, r->count * (GLsizeiptr)sizeof *r->records, r->records, GL_STREAM_DRAW);
    gl->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, r->count);
    gl->Finish();
    r->count = 0;
    r->fragments = 0;
    result = leave(context, r, &host);
    return result ? result : pv_progress(context, done);
}

static void add_record(raster *r, const tile *t, int32_t index)
{
    const pave_site *s = &r->cpu->sites[index];
    r->records[r->count++] = (record){ s->x - 256 * t->x, s->y - 256 * t->y, s->cosine, s->sine, s->half_x, s->half_y,
                                       index };
    r->fragments += 4 * (s->half_x / 256.0 + r->margin) * (s->half_y / 256.0 + r->margin);
}

/* Draws the marked sites in the order of their indices, and takes the marks away. */
static pave_result draw_marked(pave_context *context, raster *r, const tile *t, double done)
{
    pave_result result = PAVE_OK;
    r->count = 0;
    r->fragments = 0;
    for (int32_t word = r->low; word < r->high; word++) {
        for (uint64_t bits = r->marks[word]; bits && !result; bits &= bits - 1) {
            add_record(r, t, 64 * word + __builtin_ctzll(bits));
            if (r->count == RECORDS || r->fragments > FRAGMENTS)
                result = draw_slice(context, r, done);
        }
        r->marks[word] = 0;
    }
    return result || !r->count ? result : draw_slice(context, r, done);
}

static pave_result read_labels(pave_context *context, raster *r, const tile *t)
{
    const pv_gl *gl = &r->gl;
    size_t pixels = (size_t)t->width * (size_t)t->height;
    pv_gl_host host;
    pave_result result = enter(context, r, &host);
    if (result)
        return result;
    gl->ReadPixels(0, 0, t->width, t->height, gl->components == 1 ? GL_RED_INTEGER : GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                   r->labels);
    for (size_t i = 1; i < pixels && gl->components > 1; i++)
        r->labels[i] = r->labels[i * (size_t)gl->components];
    return leave(context, r, &host);
}

static pave_result draw(pave_context *context, raster *r, const tile *t, double done)
{
    pave_result result = begin(context, r, t);
    if (result)
        return result;
    mark(r, t);
    result = draw_marked(context, r, t, done);
    return result ? result : read_labels(context, r, t);
}

typedef struct job {
    raster *r;
    const tile *t;
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
static int32_t away(const pave_site *site, int32_t x, int32_t y)
{
    uint64_t d = pv_metric(site, 256 * x + 128, 256 * y + 128);
    return d < (uint64_t)PV_METRIC_NARROW * PV_METRIC_NARROW ? ((int32_t)sqrtf((float)d) + SLACK) / 256 + 1 : UNPROVEN;
}

/* How far the pixels of a row of CPU tiles are from their sites. The distance to a box is convex: of a run of pixels
 * only the ends are measured. */
static void measure_task(void *data, int32_t ty, int32_t worker)
{
    (void)worker;
    const job *j = data;
    const raster *r = j->r;
    const tile *t = j->t;
    uint8_t *worst = r->worst + ty * cpu_tiles(t->width);
    memset(worst, 0, (size_t)cpu_tiles(t->width));
    for (int32_t y = ty * PV_TILE; y < min((ty + 1) * PV_TILE, t->height); y++) {
        const uint32_t *row = r->labels + (size_t)y * (size_t)t->width;
        for (int32_t x = 0, end; x < t->width; x = end) {
            end = run_end(row, x, t->width);
            int32_t d = UNPROVEN;
            if (row[x] < (uint32_t)r->cpu->plane.sites) {
                const pave_site *site = &r->cpu->sites[row[x]];
                d = max(away(site, t->x + x, t->y + y), away(site, t->x + end - 1, t->y + y));
            }
            for (int32_t tx = x / PV_TILE; tx <= (end - 1) / PV_TILE; tx++)
                worst[tx] = (uint8_t)max(worst[tx], d);
        }
    }
}

/* Takes over proven pixels: columns from..to of a row of CPU tiles. */
static void take(const job *j, int32_t ty, int32_t from, int32_t to, pv_sum *sums)
{
    const tile *t = j->t;
    for (int32_t y = ty * PV_TILE; y < min((ty + 1) * PV_TILE, t->height); y++) {
        const uint32_t *row = j->r->labels + (size_t)y * (size_t)t->width;
        for (int32_t x = from, end; x < to; x = end) {
            end = run_end(row, x, to);
            int64_t count = end - x;
            pv_sum_add(&sums[row[x]], count, count * (2 * t->x + x + end - 1) / 2, count * (t->y + y));
        }
        if (j->labels)
            memcpy(j->labels + (int64_t)(t->y + y) * j->r->cpu->plane.width + t->x + from, row + from,
                   (size_t)(to - from) * sizeof *row);
    }
}

/* Takes over what is proven of a row of CPU tiles, and labels the rest. */
static void collect_task(void *data, int32_t ty, int32_t worker)
{
    const job *j = data;
    const tile *t = j->t;
    const pv_cpu *cpu = j->r->cpu;
    int32_t across = cpu_tiles(t->width), margin = j->r->margin;
    const uint8_t *worst = j->r->worst + ty * across;
    pv_sum *sums = cpu->sums + (size_t)worker * (size_t)cpu->plane.sites;
    int32_t radius = 0;
    for (int32_t tx = 0, end; tx < across; tx = end) {
        end = tx + 1;
        if (worst[tx] > margin) {
            int32_t x = t->x + tx * PV_TILE, y = t->y + ty * PV_TILE;
            radius = max(radius, pv_label_tile_portable(cpu, x, y, sums, j->labels));
            continue;
        }
        radius = max(radius, 256 * worst[tx] + cpu->reach);
        for (; end < across && worst[end] <= margin; end++)
            radius = max(radius, 256 * worst[end] + cpu->reach);
        take(j, ty, tx * PV_TILE, min(end * PV_TILE, t->width), sums);
    }
    pv_raise(&j->r->radius, radius);
}

static int32_t unproven(const raster *r, int32_t tiles)
{
    int32_t count = 0;
    for (int32_t i = 0; i < tiles; i++)
        count += r->worst[i] > r->margin;
    return count;
}

/* Draws the tile until few enough CPU tiles are unproven. */
static pave_result see(pave_context *context, raster *r, job *j, double done)
{
    int32_t tiles = cpu_tiles(j->t->width) * cpu_tiles(j->t->height);
    pave_result result;
    for (;;) {
        result = draw(context, r, j->t, done);
        if (!result)
            result = pv_parallel(context, cpu_tiles(j->t->height), measure_task, j, done, done);
        if (result || r->margin == r->most || unproven(r, tiles) <= tiles / FEW)
            return result;
        r->margin = min(r->margin + r->margin / 2 + 1, r->most);
    }
}

static pave_result label_tile(pave_context *context, raster *r, const tile *t, int32_t *labels, double from, double to)
{
    job j = { r, t, labels };
    int32_t tiles = cpu_tiles(t->width) * cpu_tiles(t->height);
    pave_result result = PAVE_OK;
    if (r->margin)
        result = see(context, r, &j, from);
    else
        memset(r->worst, UNPROVEN, (size_t)tiles);
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
static void adapt(raster *r)
{
    int64_t all = 0, beyond = 0;
    for (int32_t i = 0; i <= UNPROVEN; i++)
        all += r->found[i];
    int32_t px = UNPROVEN;
    for (; px > 1 && beyond + r->found[px] <= all / RARE; px--)
        beyond += r->found[px];
    r->margin = min(px < UNPROVEN ? px : r->margin + r->margin / 4 + 1, r->most);
    memset(r->found, 0, sizeof r->found);
}

static pave_result label_all(pave_context *context, raster *r, int32_t *labels, double from, double to)
{
    const pv_plane *plane = &r->cpu->plane;
    int32_t across = (int32_t)pv_ceil_div(plane->width, r->width), tile_count;
    tile_count = across * (int32_t)pv_ceil_div(plane->height, r->height);
    double share = (to - from) / tile_count;
    pave_result result = pv_cpu_sort(context, r->cpu, from);
    atomic_store(&r->radius, 0);
    for (int32_t i = 0; i < tile_count && !result; i++) {
        tile t = { .x = i % across * r->width, .y = i / across * r->height };
        t.width = min(plane->width - t.x, r->width);
        t.height = min(plane->height - t.y, r->height);
        result = label_tile(context, r, &t, labels, from + i * share, from + (i + 1) * share);
    }
    if (!result)
        adapt(r);
    return result;
}

static pave_result gles_step(pave_context *context, void *engine, int32_t iteration, double from, double to,
                             pv_step *out)
{
    raster *r = engine;
    double middle = from + 0.9 * (to - from);
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
    const raster *r = engine;
    (void)context;
    memcpy(sites, r->cpu->sites, (size_t)r->cpu->plane.sites * sizeof *sites);
    return PAVE_OK;
}

double pv_gles_mended(const void *engine)
{
    const raster *r = engine;
    return (double)r->mended / (double)r->tiles;
}

static void gles_close(void *engine)
{
    raster *r = engine;
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
static void choose_sides(raster *r, const pv_plane *plane)
{
    int32_t width = cpu_tiles(plane->width) * PV_TILE, height = cpu_tiles(plane->height) * PV_TILE;
    int32_t most = min(r->gl.most_side, MOST_SIDE) / PV_TILE * PV_TILE, side = min(most, 1024);
    r->width = min(width, min(most, PIXELS / min(height, side) / PV_TILE * PV_TILE));
    r->height = min(height, min(most, PIXELS / r->width / PV_TILE * PV_TILE));
}

/* Of one site after the other, from the slice in the buffer. */
static void describe_records(const pv_gl *gl)
{
    static const size_t offset[] = { offsetof(record, x), offsetof(record, half_x) };
    static const GLint components[] = { 4, 3 };
    GLuint buffer;
    gl->GenBuffers(1, &buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, buffer);
    for (GLuint i = 0; i < 2; i++) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribIPointer(i, components[i], GL_INT, sizeof(record), (const void *)offset[i]);
        gl->VertexAttribDivisor(i, 1);
    }
}

static const char *set_up_drawing(raster *r)
{
    pv_gl *gl = &r->gl;
    const char *reason = pv_gl_targets(gl, r->width, r->height);
    if (!reason)
        reason = pv_gl_program(gl);
    if (reason)
        return reason;
    describe_records(gl);
    float x = (float)(r->width + 2 * PV_GL_FRAME), y = (float)(r->height + 2 * PV_GL_FRAME);
    gl->Uniform4f(gl->frame, 2 / (256 * x), 2 / (256 * y), 2 * PV_GL_FRAME / x - 1, 2 * PV_GL_FRAME / y - 1);
    return NULL;
}

static pave_result open_device(pave_context *context, raster *r, const pv_plane *plane, char *name)
{
    pv_gl_host host;
    const char *reason = pv_gl_open(&r->gl);
    if (reason)
        return pv_fail(context, PAVE_ERR_DEVICE, "OpenGL ES cannot be used: %s", reason);
    choose_sides(r, plane);
    pave_result result = enter(context, r, &host);
    if (result)
        return result;
    const char *renderer = (const char *)r->gl.GetString(GL_RENDERER);
    snprintf(name, 128, "gles on %.100s", renderer ? renderer : "an unnamed device");
    reason = set_up_drawing(r);
    result = leave(context, r, &host);
    return reason && !result ? pv_fail(context, PAVE_ERR_DEVICE, "OpenGL ES cannot be used: %s", reason) : result;
}

static pave_result allocate(pave_context *context, raster *r, const pv_plane *plane)
{
    pave_result result = PAVE_OK;
    size_t pixels = (size_t)r->width * (size_t)r->height;
    r->records = pv_allocate(context, RECORDS, sizeof *r->records, &result);
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
    raster *r = pv_allocate_zeroed(context, 1, sizeof *r, &result);
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
    r->most = max((PV_METRIC_NARROW - r->cpu->reach - SLACK) / 256, 0);
    r->margin = min(3 * plane->cell / 1024 + 2, r->most);
    *engine = r;
    return PAVE_OK;
}

const pv_backend pv_gles_backend = {
    PAVE_BACKEND_GLES, gles_open, gles_step, gles_labels, gles_sites, gles_close, pv_gles_list,
};
