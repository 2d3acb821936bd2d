/* Piles of stones in files: the windows of one pavement, merged by the stones' numbers. */
#include "io/input.h"
#include "io/pile.h"
#include "io/stonefile.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

enum { LONGEST = PV_STONE_RECORD + 8 * PV_STONE_CORNERS, CHUNK = 16 * 1024 };

/* A file as it is read, chunk by chunk. */
typedef struct merge_part {
    const char *path;
    int64_t bytes; /* of its records */
    int64_t read;  /* of them, into the chunk or before */
    int32_t begin, end; /* what the chunk still holds */
    int32_t number; /* of the stone at `begin`; INT32_MAX: none is left */
    uint8_t *chunk; /* there only while its stones are among those that come next */
} merge_part;

typedef struct merge {
    int32_t count, last, part; /* last, part: of the stone before */
    int32_t *heap;       /* parts, the one with the lowest number first */
    merge_part *parts;
    int32_t xy[2 * PV_STONE_CORNERS];
} merge;

static pave_result damaged(pave_context *context, const merge_part *p)
{
    return pv_fail(context, PAVE_ERR_FORMAT, "%s: is a damaged file of stones", p->path);
}

static pave_result read_records(pave_context *context, const merge_part *p, int64_t from, void *bytes, int64_t size)
{
    int file = open(p->path, O_RDONLY | O_CLOEXEC);
    int64_t got = file < 0 ? -1 : pv_read_at(file, PV_STONE_FILE_HEAD + from, bytes, size);
    int error = errno;
    if (file >= 0)
        close(file);
    if (got < 0)
        return pv_unreadable(context, p->path, error);
    return got < size ? damaged(context, p) : PAVE_OK;
}

/* Fills the chunk up, if there is less than a whole stone in it. */
static pave_result refill(pave_context *context, merge_part *p)
{
    int32_t held = p->end - p->begin;
    pave_result result = PAVE_OK;
    if (held >= LONGEST || p->read == p->bytes)
        return PAVE_OK;
    if (!p->chunk)
        p->chunk = pv_allocate(context, CHUNK, 1, &result);
    if (result)
        return result;
    memmove(p->chunk, p->chunk + p->begin, (size_t)held);
    int64_t left = p->bytes - p->read, room = CHUNK - held, size = left < room ? left : room;
    result = read_records(context, p, p->read, p->chunk + held, size);
    p->read += size;
    p->begin = 0;
    p->end = held + (int32_t)size;
    return result;
}

static int32_t corners_at(const merge_part *p)
{
    uint16_t corners;
    memcpy(&corners, p->chunk + p->begin + 6, sizeof corners);
    return corners;
}

static void drop_chunk(merge_part *p)
{
    pv_release(p->chunk);
    p->chunk = NULL;
}

/* Looks at the part's next stone. */
static pave_result look(pave_context *context, merge_part *p)
{
    pave_result result = refill(context, p);
    if (result)
        return result;
    p->number = INT32_MAX;
    if (p->begin == p->end) {
        drop_chunk(p);
        return PAVE_OK;
    }
    if (p->end - p->begin < PV_STONE_RECORD || corners_at(p) < 3 || corners_at(p) > PV_STONE_CORNERS ||
        p->end - p->begin < PV_STONE_RECORD + 8 * corners_at(p))
        return damaged(context, p);
    memcpy(&p->number, p->chunk + p->begin, sizeof p->number);
    return p->number < 0 || p->number == INT32_MAX ? damaged(context, p) : PAVE_OK;
}

static void sink(merge *m, int32_t at)
{
    int32_t moving = m->heap[at];
    for (int32_t child; (child = 2 * at + 1) < m->count; at = child) {
        if (child + 1 < m->count && m->parts[m->heap[child + 1]].number < m->parts[m->heap[child]].number)
            child++;
        if (m->parts[m->heap[child]].number >= m->parts[moving].number)
            break;
        m->heap[at] = m->heap[child];
    }
    m->heap[at] = moving;
}

/* Only the number of the first stone: parts wait without a chunk until it is their turn. */
static pave_result peek(pave_context *context, merge_part *p)
{
    p->number = INT32_MAX;
    pave_result result = p->bytes ? read_records(context, p, 0, &p->number, sizeof p->number) : PAVE_OK;
    return !result && p->bytes && p->number == INT32_MAX ? damaged(context, p) : result;
}

static pave_result merge_start(pave_context *context, merge *m)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < m->count && !result; i++) {
        m->heap[i] = i;
        result = peek(context, &m->parts[i]);
    }
    for (int32_t i = m->count / 2; i-- > 0 && !result;)
        sink(m, i);
    m->last = -1;
    return result;
}

static pave_result merge_next(pave_context *context, pv_pile *pile, pv_stone *out)
{
    merge *m = pile->source;
    pave_result result = m->last == -2 ? merge_start(context, m) : PAVE_OK;
    merge_part *p = &m->parts[m->heap[0]];
    *out = (pv_stone){ .xy = m->xy };
    if (!result && !p->chunk && p->number < INT32_MAX)
        result = look(context, p);
    if (result || p->number == INT32_MAX)
        return result;
    out->part = p->chunk[p->begin + 5];
    if (p->number < m->last || (p->number == m->last && out->part != (m->part + 1) % 256))
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: stone %d comes twice", p->path, (int)p->number);
    m->part = out->part;
    out->number = m->last = p->number;
    out->colour = p->chunk[p->begin + 4];
    out->corners = corners_at(p);
    memcpy(m->xy, p->chunk + p->begin + PV_STONE_RECORD, 8 * (size_t)out->corners);
    p->begin += PV_STONE_RECORD + 8 * out->corners;
    result = look(context, p);
    sink(m, 0);
    return result;
}

static void merge_rewind(pv_pile *pile)
{
    merge *m = pile->source;
    m->last = -2; /* begins with the next stone */
    for (int32_t i = 0; i < m->count; i++) {
        drop_chunk(&m->parts[i]);
        m->parts[i].read = m->parts[i].begin = m->parts[i].end = 0;
    }
}

static void merge_close(pv_pile *pile)
{
    merge *m = pile->source;
    if (!m)
        return;
    for (int32_t i = 0; i < m->count && m->parts; i++)
        drop_chunk(&m->parts[i]);
    pv_release(m->heap);
    pv_release(m->parts);
    pv_release(m);
}

static pave_result merge_create(pave_context *context, int32_t count, merge **out)
{
    pave_result result = PAVE_OK;
    merge *m = *out = pv_allocate_zeroed(context, 1, sizeof *m, &result);
    if (!m)
        return result;
    m->count = count;
    m->heap = pv_allocate(context, (size_t)count, sizeof *m->heap, &result);
    if (!result)
        m->parts = pv_allocate_zeroed(context, (size_t)count, sizeof *m->parts, &result);
    return result;
}

/* The window that holds both. */
static void unite(pave_stones *head, const pv_stone_file_head *part)
{
    int32_t right = head->x + head->width, bottom = head->y + head->height;
    int32_t part_right = part->x + part->width, part_bottom = part->y + part->height;
    head->x = part->x < head->x ? part->x : head->x;
    head->y = part->y < head->y ? part->y : head->y;
    head->width = (part_right > right ? part_right : right) - head->x;
    head->height = (part_bottom > bottom ? part_bottom : bottom) - head->y;
}

static void add_counts(int64_t *sum, const int64_t *counts, int32_t n)
{
    for (int32_t i = 0; i < n; i++)
        sum[i] += counts[i];
}

/* Adds a part's report; areas are kept as sums until all are there. */
static void add_report(pave_report *sum, const pave_report *part)
{
    double n = part->stones, mean = part->area_mean, deviation = part->area_deviation;
    sum->sites += part->sites;
    sum->stones += part->stones;
    sum->lost += part->lost;
    sum->repaired += part->repaired;
    sum->vanished += part->vanished;
    sum->reduced += part->reduced;
    add_counts(sum->corners_before, part->corners_before, PAVE_REPORT_BINS);
    add_counts(sum->corners_after, part->corners_after, PAVE_REPORT_BINS);
    add_counts(sum->areas, part->areas, PAVE_REPORT_BINS);
    sum->area_mean += n * mean;
    sum->area_deviation += n * (mean * mean + deviation * deviation);
    sum->seconds_field += part->seconds_field;
    sum->seconds_cvd += part->seconds_cvd;
    sum->seconds_stones += part->seconds_stones;
}

static void finish_report(pave_stones *head)
{
    pave_report *m = &head->report;
    double n = m->stones ? m->stones : 1, area = m->area_mean, mean = area / n;
    double variance = m->area_deviation / n - mean * mean;
    m->area_mean = mean;
    m->area_deviation = variance > 0 ? sqrt(variance) : 0;
    m->coverage = area / ((double)head->width * head->height);
}

static void begin_head(pave_stones *head, const pv_stone_file_head *part)
{
    head->x = part->x;
    head->y = part->y;
    head->width = part->width;
    head->height = part->height;
    head->drawing = part->drawing;
    head->plane_width = part->plane_width;
    head->plane_height = part->plane_height;
    head->report.size = sizeof head->report;
    head->report.area_step = part->report.area_step;
    head->report.half_side = part->report.half_side;
    head->report.steps = part->report.steps;
    head->report.movement = -1;
    head->cvd = part->cvd;
    memset(head->cvd.window, 0, sizeof head->cvd.window);
    head->params = part->stones;
    head->field = part->field;
    head->threshold = part->threshold;
    head->palette = part->palette;
    head->backend = part->backend;
    memcpy(head->backend_name, part->backend_name, sizeof head->backend_name);
}

static int same_pavement(const pave_stones *head, const pv_stone_file_head *part)
{
    pv_making making = { head->drawing, &head->threshold, &head->palette, &head->field, &head->cvd, &head->params };
    return head->plane_width == part->plane_width && head->plane_height == part->plane_height &&
           pv_stones_file_same(part, &making);
}

/* Where windows straddle the borders of a plane that repeats, it is as if they had been cut along them. */
static void fit_in_plane(pave_stones *head, double area)
{
    int whole = area >= (double)head->plane_width * head->plane_height;
    if (head->field.periodic && (whole || head->width > head->plane_width)) {
        head->x = 0;
        head->width = head->plane_width;
    }
    if (head->field.periodic && (whole || head->height > head->plane_height)) {
        head->y = 0;
        head->height = head->plane_height;
    }
}

static pave_result add_part(pave_context *context, const char *path, int32_t i, pv_pile *pile, double *area)
{
    merge *m = pile->source;
    pv_stone_file_head head;
    pave_result result = pv_stones_file_head(context, path, &head);
    if (result)
        return result;
    if (!i)
        begin_head(&pile->head, &head);
    if (!same_pavement(&pile->head, &head))
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: belongs to another pavement", path);
    if (head.count > INT32_MAX - pile->head.count)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: with it there are more than 2^31 stones", path);
    unite(&pile->head, &head);
    add_report(&pile->head.report, &head.report);
    add_counts(pile->counts, head.counts, 256);
    *area += (double)head.width * head.height;
    pile->head.count += head.count;
    m->parts[i].path = path;
    m->parts[i].bytes = head.bytes;
    return PAVE_OK;
}

pave_result pv_pile_open(pave_context *context, const char *const *paths, int32_t count, pv_pile *out)
{
    merge *m;
    double area = 0;
    *out = (pv_pile){ .next = merge_next, .rewind = merge_rewind, .close = merge_close };
    pave_result result = merge_create(context, count, &m);
    out->source = m;
    for (int32_t i = 0; i < count && !result; i++)
        result = add_part(context, paths[i], i, out, &area);
    if (!result) {
        fit_in_plane(&out->head, area);
        finish_report(&out->head);
        merge_rewind(out);
        if (area < (double)out->head.width * out->head.height)
            pv_note(context, PAVE_MESSAGE_WARNING, "the windows do not fill %d x %d px: some are missing",
                    (int)out->head.width, (int)out->head.height);
    } else {
        merge_close(out);
    }
    return result;
}
