/* Radiance pictures: a header in text, then rows of mantissas and a common exponent, run-length encoded or plain. */
#include "io/radiance.h"

#include "util/text.h"

#include <math.h>
#include <string.h>

enum { MOST_HEADER = 65536, LEAST_ENCODED = 8, MOST_ENCODED = 32767 };

typedef struct radiance {
    pv_input *input;
    const uint8_t *bytes;
    size_t size, at;
    int32_t width, height;
    int from_bottom;
    size_t *row; /* where each of the file's rows begins */
    uint8_t *line; /* one row: mantissas and exponents, component by component */
    float scale;
} radiance;

int pv_is_radiance(const uint8_t *bytes, size_t size)
{
    return size >= 10 && (!memcmp(bytes, "#?RADIANCE", 10) || !memcmp(bytes, "#?RGBE", 6));
}

static pave_result damaged(const radiance *r, const char *reason)
{
    return pv_fail(r->input->context, PAVE_ERR_FORMAT, "%s: is a damaged Radiance picture: %s", r->input->path, reason);
}

/* The next line of the header, without its end; 0 if there is none. */
static int next_line(radiance *r, char *out, size_t room)
{
    const uint8_t *from = r->bytes + r->at;
    size_t left = r->size - r->at < MOST_HEADER ? r->size - r->at : MOST_HEADER;
    const uint8_t *end = memchr(from, '\n', left);
    if (!end)
        return 0;
    size_t length = (size_t)(end - from), kept = length < room - 1 ? length : room - 1;
    memcpy(out, from, kept);
    out[kept] = 0;
    r->at += length + 1;
    return 1;
}

/* Digits up to a space or the end; 0 if they are no length. */
static int32_t length_in(const char **text)
{
    int64_t value = 0;
    const char *p = *text;
    while (*p >= '0' && *p <= '9' && value < 1 << 24)
        value = 10 * value + (*p++ - '0');
    *text = p;
    return (int32_t)value;
}

static pave_result read_size(radiance *r, const char *line)
{
    int rows_first = line[1] == 'Y';
    const char *p = line + 3;
    int32_t first = strlen(line) > 3 ? length_in(&p) : 0;
    int spaced = first && *p == ' ' && strlen(p) > 4 && p[3] == ' ';
    const char *axis = p + 1;
    p += spaced ? 4 : 0;
    int32_t second = spaced ? length_in(&p) : 0;
    int known = spaced && second && line[2] == ' ' &&
                (rows_first ? (line[0] == '-' || line[0] == '+') && !memcmp(axis, "+X", 2)
                            : !memcmp(line, "+X", 2) && !memcmp(axis, "-Y", 2));
    if (!known)
        return pv_fail(r->input->context, PAVE_ERR_UNSUPPORTED, "%s: its rows lie in a way that is not read: %.40s",
                       r->input->path, line);
    r->width = rows_first ? second : first;
    r->height = rows_first ? first : second;
    r->from_bottom = !rows_first || line[0] == '+';
    return pv_check_size(r->input->context, r->input->path, r->width, r->height);
}

static pave_result read_header(radiance *r)
{
    char line[256];
    double exposure = 1, value;
    while (next_line(r, line, sizeof line) && line[0]) {
        if (!strncmp(line, "FORMAT=", 7) && strcmp(line + 7, "32-bit_rle_rgbe"))
            return pv_fail(r->input->context, PAVE_ERR_UNSUPPORTED, "%s: its values are not RGBE but %.40s",
                           r->input->path, line + 7);
        if (!strncmp(line, "EXPOSURE=", 9) && pv_parse_number(line + 9 + strspn(line + 9, " "), &value) && value > 0)
            exposure *= value;
    }
    if (!next_line(r, line, sizeof line))
        return damaged(r, "it has no picture");
    r->scale = (float)(1 / exposure);
    return read_size(r, line);
}

static int is_encoded(const radiance *r, size_t at)
{
    const uint8_t *p = r->bytes + at;
    return r->width >= LEAST_ENCODED && r->width <= MOST_ENCODED && r->size - at >= 4 && p[0] == 2 && p[1] == 2 &&
           (p[2] << 8 | p[3]) == r->width;
}

/* One row's four components, each in runs; how many bytes it took, or 0. `out` may be NULL. */
static size_t unpack(const radiance *r, size_t at, uint8_t *out)
{
    size_t begin = at;
    at += 4;
    for (int c = 0; c < 4; c++)
        for (int32_t x = 0; x < r->width;) {
            if (r->size - at < 2)
                return 0;
            int run = r->bytes[at] > 128, count = run ? r->bytes[at] - 128 : r->bytes[at];
            at++;
            if (!count || count > r->width - x || (size_t)(run ? 1 : count) > r->size - at)
                return 0;
            uint8_t *to = out ? out + (size_t)c * (size_t)r->width + x : NULL;
            if (to && run)
                memset(to, r->bytes[at], (size_t)count);
            else if (to)
                memcpy(to, r->bytes + at, (size_t)count);
            at += run ? 1 : (size_t)count;
            x += count;
        }
    return at - begin;
}

static pave_result find_rows(radiance *r)
{
    pave_result result = PAVE_OK;
    if ((size_t)r->height > r->size / 4)
        return damaged(r, "it is cut short");
    r->row = pv_allocate(r->input->context, (size_t)r->height, sizeof *r->row, &result);
    if (!result)
        r->line = pv_allocate(r->input->context, (size_t)r->width, 4, &result);
    for (int32_t y = 0; y < r->height && !result; y++) {
        size_t length = is_encoded(r, r->at) ? unpack(r, r->at, NULL) : (size_t)r->width * 4;
        if (!length || length > r->size - r->at)
            return damaged(r, "it is cut short");
        r->row[y] = r->at;
        r->at += length;
    }
    return result;
}

/* Mantissas stand for the middle of what they were rounded down from (Ward 1991); exponent 0 is black. */
static void read_row(const radiance *r, int32_t y, float *out)
{
    size_t at = r->row[r->from_bottom ? r->height - 1 - y : y], width = (size_t)r->width;
    int encoded = is_encoded(r, at);
    if (encoded)
        unpack(r, at, r->line);
    for (size_t x = 0; x < width; x++) {
        const uint8_t *p = r->bytes + at + 4 * x;
        int exponent = encoded ? r->line[3 * width + x] : p[3];
        float unit = exponent ? ldexpf(r->scale, exponent - 136) : 0;
        for (size_t c = 0; c < 3; c++)
            out[3 * x + c] = ((float)(encoded ? r->line[c * width + x] : p[c]) + 0.5f) * unit;
    }
}

static pave_result read_part(void *user, pv_rect part, void *pixels)
{
    const radiance *r = user;
    for (int32_t y = 0; y < part.height; y++)
        read_row(r, part.y + y, (float *)pixels + (size_t)y * (size_t)part.width * 3);
    return PAVE_OK;
}

pave_result pv_radiance_read(pave_context *context, pv_input *input, const pv_target *target)
{
    radiance r = { .input = input, .size = (size_t)input->size };
    uint8_t *bytes = NULL;
    pave_result result = pv_input_load(input, &bytes);
    r.bytes = bytes;
    if (!result)
        result = read_header(&r);
    if (!result)
        result = find_rows(&r);
    if (!result) {
        pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
        shape.width = r.width;
        shape.height = r.height;
        shape.channels = 3;
        shape.type = PAVE_F32;
        shape.encoding = PAVE_LINEAR;
        shape.alpha = -1;
        shape.names = "R,G,B";
        pv_blocks blocks = { input->path, shape, r.width, 1, 0, input->size, 0, read_part, &r };
        result = pv_blocks_read(context, &blocks, target);
    }
    pv_release(r.row);
    pv_release(r.line);
    pv_release(bytes);
    return result;
}
