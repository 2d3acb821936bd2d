/* Stones to a binary file, and its head back. */
#include "io/stonefile.h"

#include "cvd/cvd.h"
#include "field/field.h"
#include "io/input.h"
#include "io/output.h"
#include "io/pile.h"

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

_Static_assert(sizeof(pv_stone_file_head) <= PV_STONE_FILE_HEAD, "the head has outgrown its place");

static void set_sizes(int32_t *sizes)
{
    sizes[0] = sizeof(pv_stone_file_head);
    sizes[1] = sizeof(pave_report);
    sizes[2] = sizeof(pave_cvd_params);
    sizes[3] = sizeof(pave_stones_params);
    sizes[4] = sizeof(pave_threshold_params);
}

static void fill_head(const pv_pile *pile, int64_t bytes, pv_stone_file_head *head)
{
    const pave_stones *s = &pile->head;
    memset(head, 0, sizeof *head);
    memcpy(head->magic, PV_STONE_FILE_MAGIC, sizeof head->magic);
    head->mark = 0x01020304;
    set_sizes(head->sizes);
    head->x = s->x;
    head->y = s->y;
    head->width = s->width;
    head->height = s->height;
    head->drawing = s->drawing;
    head->plane_width = s->plane_width;
    head->plane_height = s->plane_height;
    head->count = s->count;
    head->bytes = bytes;
    memcpy(head->counts, pile->counts, sizeof head->counts);
    head->report = s->report;
    head->cvd = s->cvd;
    head->stones = s->params;
    head->field = s->field;
    head->threshold = s->threshold;
    head->palette = s->palette;
    head->backend = s->backend;
    memcpy(head->backend_name, s->backend_name, sizeof head->backend_name);
}

static void put_stone(pv_output *output, const pv_stone *stone)
{
    uint8_t record[PV_STONE_RECORD] = { 0 };
    uint16_t corners = (uint16_t)stone->corners;
    memcpy(record, &stone->number, 4);
    record[4] = stone->colour;
    record[5] = (uint8_t)stone->part;
    memcpy(record + 6, &corners, 2);
    pv_output_bytes(output, record, sizeof record);
    pv_output_bytes(output, stone->xy, (size_t)stone->corners * 2 * sizeof(int32_t));
}

static pave_result put_stones(pave_context *context, pv_pile *pile, pv_output *output, int64_t *bytes)
{
    static const char nothing[PV_STONE_FILE_HEAD];
    pv_stone stone;
    pave_result result = PAVE_OK;
    pv_output_bytes(output, nothing, sizeof nothing);
    pile->rewind(pile);
    for (int64_t done = 0; !result; done++) {
        result = pile->next(context, pile, &stone);
        if (result || !stone.corners)
            break;
        put_stone(output, &stone);
        *bytes += PV_STONE_RECORD + (int64_t)stone.corners * 8;
        if (done % 4096 == 0)
            result = pv_progress(context, (double)done / pile->head.count);
    }
    return result;
}

pave_result pv_stones_file_write(pave_context *context, pv_pile *pile, const char *path)
{
    pv_output *output;
    pv_stone_file_head head;
    int64_t bytes = 0;
    pave_result result = pv_output_open(context, path, 1, &output);
    if (result)
        return result;
    result = put_stones(context, pile, output, &bytes);
    fill_head(pile, bytes, &head);
    return pv_output_close_head(output, result, &head, sizeof head);
}

/* Where a diagram was computed says nothing of what it is. */
static int same_diagram(pave_cvd_params a, pave_cvd_params b)
{
    memcpy(a.window, b.window, sizeof a.window);
    a.window_margin = b.window_margin;
    return pv_params_same(&pv_cvd_table, &a, &b, sizeof a);
}

int pv_stones_file_same(const pv_stone_file_head *head, const pv_making *making)
{
    return head->drawing == making->drawing &&
           same_diagram(head->cvd, *making->cvd) &&
           pv_params_same(&pv_stones_table, &head->stones, making->stones, sizeof head->stones) &&
           pv_params_same(&pv_field_table, &head->field, making->field, sizeof head->field) &&
           pv_params_same(&pv_palette_table, &head->palette, making->palette, sizeof head->palette) &&
           pv_params_same(&pv_threshold_table, &head->threshold, making->threshold, sizeof head->threshold);
}

/* Does the window lie in the plane, and do the colours add up? */
/* Does a window lie in the plane? In one that repeats it may lie across the border. */
static int good_span(int32_t start, int32_t length, int32_t plane, int periodic)
{
    return plane <= 1 << 20 && start >= 0 && length > 0 && length <= plane && start <= plane - (periodic ? 1 : length);
}

static int good_head(const pv_stone_file_head *head)
{
    int64_t counted = 0;
    int periodic = head->field.periodic;
    int good = head->count >= 0 && head->bytes >= head->count * (int64_t)PV_STONE_RECORD;
    for (int i = 0; i < 256 && good; i++) {
        good &= head->counts[i] >= 0 && head->counts[i] <= head->count;
        counted += head->counts[i];
    }
    return good && counted == head->count && good_span(head->x, head->width, head->plane_width, periodic) &&
           good_span(head->y, head->height, head->plane_height, periodic);
}

static pave_result check_head(const pv_stone_file_head *head, int64_t size, const char **reason)
{
    int32_t sizes[5];
    set_sizes(sizes);
    *reason = NULL;
    if (memcmp(head->magic, PV_STONE_FILE_MAGIC, sizeof head->magic))
        *reason = "is not a file of stones";
    else if (head->mark != 0x01020304 || memcmp(head->sizes, sizes, sizeof sizes))
        *reason = "was written by another version of libpave";
    else if (head->bytes < 0 || size - PV_STONE_FILE_HEAD != head->bytes)
        *reason = "is a damaged file of stones: its size is wrong";
    else if (!good_head(head))
        *reason = "is a damaged file of stones: its head contradicts itself";
    return *reason ? PAVE_ERR_FORMAT : PAVE_OK;
}

pave_result pv_stones_file_look(const char *path, pv_stone_file_head *head, const char **reason)
{
    struct stat info;
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    int64_t got = file < 0 || fstat(file, &info) ? -1 : pv_read_at(file, 0, head, sizeof *head);
    int error = errno;
    if (file >= 0)
        close(file);
    if (got < 0) {
        *reason = pv_system_error(error);
        return PAVE_ERR_IO;
    }
    head->backend_name[sizeof head->backend_name - 1] = 0;
    if (got == (int64_t)sizeof *head && S_ISREG(info.st_mode))
        return check_head(head, info.st_size, reason);
    *reason = "is not a file of stones";
    return PAVE_ERR_FORMAT;
}

pave_result pv_stones_file_head(pave_context *context, const char *path, pv_stone_file_head *head)
{
    const char *reason;
    pave_result result = pv_stones_file_look(path, head, &reason);
    return result ? pv_fail(context, result, "%s: %s%s", path, result == PAVE_ERR_IO ? "cannot be read: " : "", reason)
                  : PAVE_OK;
}
