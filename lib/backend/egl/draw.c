/* Drawing a tile: the sites around it, in the order of their indices, slice by slice. */
#include "backend/egl/raster.h"

enum {
    FRAGMENTS = 1 << 22,
    SPREAD = 34, /* the slack, and two subpixels of 1/16 px by which a corner may be drawn off its place */
};

pave_result pv_gl_raster_enter(pave_context *context, const pv_gl_raster *r, pv_gl_host *host)
{
    if (pv_gl_enter(&r->gl, host))
        return PAVE_OK;
    return pv_fail(context, PAVE_ERR_DEVICE, "OpenGL ES cannot be used: its context cannot be made current");
}

/* Between enter and leave nothing may call back, so faults are told afterwards. */
pave_result pv_gl_raster_leave(pave_context *context, const pv_gl_raster *r, const pv_gl_host *host)
{
    const char *fault = pv_gl_fault(&r->gl);
    pv_gl_leave(&r->gl, host);
    return *fault ? pv_fail(context, PAVE_ERR_DEVICE, "OpenGL ES failed: %s", fault) : PAVE_OK;
}

static void mark_row(pv_gl_raster *r, const pv_gl_tile *t, int32_t from, int32_t to, int32_t around)
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
        r->low = pv_gl_min(r->low, word);
        r->high = pv_gl_max(r->high, word + 1);
    }
}

/* Marks the sites that a pixel of the tile may be within the margin of. */
static void mark(pv_gl_raster *r, const pv_gl_tile *t)
{
    const pv_cpu *cpu = r->cpu;
    int32_t around = pv_cpu_range(cpu, 256 * r->margin + PV_GL_SLACK), bucket = cpu->bucket;
    int32_t left = pv_gl_max(256 * t->x - around, 0) / bucket, top = pv_gl_max(256 * t->y - around, 0) / bucket;
    int32_t right = pv_gl_min((256 * (t->x + t->width) + around) / bucket, cpu->across - 1);
    int32_t bottom = pv_gl_min((256 * (t->y + t->height) + around) / bucket, cpu->down - 1);
    r->low = INT32_MAX;
    r->high = 0;
    for (int32_t row = top; row <= bottom; row++) {
        const int32_t *first = cpu->first + (int64_t)row * cpu->across;
        mark_row(r, t, first[left], first[right + 1], around);
    }
}

static pave_result begin(pave_context *context, const pv_gl_raster *r, const pv_gl_tile *t)
{
    static const GLuint none[4] = { UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX };
    static const GLfloat farthest = 1;
    const pv_gl *gl = &r->gl;
    pv_gl_host host;
    pave_result result = pv_gl_raster_enter(context, r, &host);
    if (result)
        return result;
    gl->Scissor(0, 0, t->width, t->height);
    gl->ClearBufferuiv(GL_COLOR, 0, none);
    gl->ClearBufferfv(GL_DEPTH, 0, &farthest);
    gl->Uniform1f(gl->margin, (GLfloat)(256 * r->margin + SPREAD));
    return pv_gl_raster_leave(context, r, &host);
}

/* Draws the slice. */
static pave_result draw_slice(pave_context *context, pv_gl_raster *r, double done)
{
    const pv_gl *gl = &r->gl;
    pv_gl_host host;
    pave_result result = pv_gl_raster_enter(context, r, &host);
    if (result)
        return result;
    gl->BufferData(GL_ARRAY_BUFFER, r->count * (GLsizeiptr)sizeof *r->records, r->records, GL_STREAM_DRAW);
    gl->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, r->count);
    gl->Finish();
    r->count = 0;
    r->fragments = 0;
    result = pv_gl_raster_leave(context, r, &host);
    return result ? result : pv_progress(context, done);
}

static void add_record(pv_gl_raster *r, const pv_gl_tile *t, int32_t index)
{
    const pave_site *s = &r->cpu->sites[index];
    r->records[r->count++] = (pv_gl_record){
        s->x - 256 * t->x, s->y - 256 * t->y, s->cosine, s->sine, s->half_x, s->half_y, index,
    };
    if (r->cpu->plane.metric == PAVE_METRIC_BOX)
        r->fragments += 4 * (s->half_x / 256.0 + r->margin) * (s->half_y / 256.0 + r->margin);
    else
        r->fragments += 4 * (65536.0 * r->margin / s->half_x) * (65536.0 * r->margin / s->half_y);
}

/* Draws the marked sites in the order of their indices, and takes the marks away. */
static pave_result draw_marked(pave_context *context, pv_gl_raster *r, const pv_gl_tile *t, double done)
{
    pave_result result = PAVE_OK;
    r->count = 0;
    r->fragments = 0;
    for (int32_t word = r->low; word < r->high; word++) {
        for (uint64_t bits = r->marks[word]; bits && !result; bits &= bits - 1) {
            add_record(r, t, 64 * word + __builtin_ctzll(bits));
            if (r->count == PV_GL_RECORDS || r->fragments > FRAGMENTS)
                result = draw_slice(context, r, done);
        }
        r->marks[word] = 0;
    }
    return result || !r->count ? result : draw_slice(context, r, done);
}

static pave_result read_labels(pave_context *context, pv_gl_raster *r, const pv_gl_tile *t)
{
    const pv_gl *gl = &r->gl;
    size_t pixels = (size_t)t->width * (size_t)t->height;
    pv_gl_host host;
    pave_result result = pv_gl_raster_enter(context, r, &host);
    if (result)
        return result;
    gl->ReadPixels(0, 0, t->width, t->height, gl->components == 1 ? GL_RED_INTEGER : GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                   r->labels);
    for (size_t i = 1; i < pixels && gl->components > 1; i++)
        r->labels[i] = r->labels[i * (size_t)gl->components];
    return pv_gl_raster_leave(context, r, &host);
}

pave_result pv_gl_draw(pave_context *context, pv_gl_raster *r, const pv_gl_tile *t, double done)
{
    pave_result result = begin(context, r, t);
    if (result)
        return result;
    mark(r, t);
    result = draw_marked(context, r, t, done);
    return result ? result : read_labels(context, r, t);
}
