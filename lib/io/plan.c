/* Plans of measurements as CSV: a line for each pair of view and light, in the order to measure. */
#include "btf/model.h"

#include <pave/io.h>

#include "io/input.h"
#include "io/output.h"
#include "util/text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

enum { COLUMNS = 8, MOST_LINE = 400 };

static const char *const names[COLUMNS] = { "number",      "view",      "light",     "view_theta",
                                            "view_phi",    "light_theta", "light_phi", "expected" };

static void put_angle(pv_output *output, float angle)
{
    char text[40];
    pv_text_number(text, sizeof text, round((double)angle / degree * 1e4) / 1e4 + 0.0);
    pv_output_text(output, ",");
    pv_output_text(output, text);
}

static void put_line(pv_output *output, const pave_btf_plan *plan, int32_t i)
{
    char text[80];
    snprintf(text, sizeof text, "%d,%d,%d", (int)i + 1, (int)plan->view[i], (int)plan->light[i]);
    pv_output_text(output, text);
    put_angle(output, plan->from[i].theta);
    put_angle(output, plan->from[i].phi);
    put_angle(output, plan->to[i].theta);
    put_angle(output, plan->to[i].phi);
    pv_text_number(text, sizeof text, plan->expected[i]);
    pv_output_text(output, ",");
    pv_output_text(output, plan->expected[i] > 0 ? text : "");
    pv_output_text(output, "\n");
}

pave_result pave_btf_plan_write(pave_context *context, const pave_btf_plan *plan, const char *path)
{
    pv_output *output;
    if (!context || !plan || !path)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    for (int c = 0; c < COLUMNS; c++) {
        pv_output_text(output, c ? "," : "");
        pv_output_text(output, names[c]);
    }
    pv_output_text(output, "\n");
    for (int32_t i = 0; i < plan->count; i++)
        put_line(output, plan, i);
    result = pv_output_close(output, PAVE_OK);
    errno = before;
    return result;
}

/* ---- Reading: the columns "view" and "light" count, wherever they stand ---- */

typedef struct sheet {
    pave_context *context;
    const char *path;
    const char *at, *end;
    int32_t line, view, light; /* columns */
} sheet;

static pave_result wrong(const sheet *s, const char *what)
{
    return pv_fail(s->context, PAVE_ERR_FORMAT, "%s: line %d %s", s->path, (int)s->line, what);
}

/* The next line that is not empty, without its end. 0 if there is none, -1 if it is too long. */
static int next_line(sheet *s, char line[MOST_LINE])
{
    size_t length = 0;
    while (s->at < s->end && !length) {
        const char *stop = memchr(s->at, '\n', (size_t)(s->end - s->at)), *last = stop ? stop : s->end;
        s->line++;
        length = (size_t)(last - s->at);
        if (length >= MOST_LINE)
            return -1;
        memcpy(line, s->at, length);
        while (length && (line[length - 1] == '\r' || line[length - 1] == ' '))
            length--;
        s->at = stop ? stop + 1 : s->end;
    }
    line[length] = 0;
    return length > 0;
}

/* The text of a column; NULL if the line has not so many. */
static const char *column(const char *line, int32_t index, char *out, size_t room)
{
    for (; index > 0 && line; index--)
        line = strchr(line, ',') ? strchr(line, ',') + 1 : NULL;
    if (!line)
        return NULL;
    while (*line == ' ')
        line++;
    size_t length = strcspn(line, ", ");
    snprintf(out, room, "%.*s", (int)(length < room ? length : room - 1), line);
    return out;
}

static pave_result read_names(sheet *s)
{
    char line[MOST_LINE], name[40];
    s->view = s->light = -1;
    if (next_line(s, line) <= 0)
        return wrong(s, "is no head of a plan");
    for (int32_t c = 0; column(line, c, name, sizeof name); c++) {
        s->view = strcmp(name, "view") ? s->view : c;
        s->light = strcmp(name, "light") ? s->light : c;
    }
    return s->view < 0 || s->light < 0 ? wrong(s, "does not name the columns \"view\" and \"light\"") : PAVE_OK;
}

static int read_index(const char *line, int32_t index, int32_t count, int32_t *out)
{
    char text[40];
    uint64_t value;
    if (!column(line, index, text, sizeof text) || !pv_parse_whole(text, &value) || value >= (uint64_t)count)
        return 0;
    *out = (int32_t)value;
    return 1;
}

static pave_result read_pairs(sheet *s, const pave_btf_model *model, uint8_t *taken, int32_t *pairs, int32_t *count)
{
    char line[MOST_LINE];
    int more;
    while ((more = next_line(s, line)) > 0) {
        int32_t view, light;
        if (!read_index(line, s->view, model->views.count, &view) ||
            !read_index(line, s->light, model->lights.count, &light))
            return wrong(s, "has no view and light of the model");
        int32_t pair = view * model->lights.count + light;
        if (taken[pair])
            return wrong(s, "has a pair of view and light for the second time");
        taken[pair] = 1;
        pairs[(*count)++] = pair;
    }
    return more < 0 ? wrong(s, "is too long") : *count ? PAVE_OK : wrong(s, "is the last: there are no pairs");
}

static pave_result read_sheet(pave_context *context, const char *path, const char *text, int64_t size,
                              const pave_btf_model *model, pave_btf_plan **out)
{
    sheet s = { .context = context, .path = path, .at = text, .end = text + size };
    size_t most = (size_t)pv_model_pairs(model);
    int32_t count = 0;
    pave_result result = read_names(&s);
    uint8_t *taken = result ? NULL : pv_allocate_zeroed(context, most, 1, &result);
    int32_t *pairs = result ? NULL : pv_allocate(context, most, sizeof *pairs, &result);
    if (!result)
        result = read_pairs(&s, model, taken, pairs, &count);
    if (!result)
        result = pv_plan_new(context, &model->views, &model->lights, pairs, count, out);
    pv_release(taken);
    pv_release(pairs);
    return result;
}

pave_result pave_btf_plan_read(pave_context *context, const pave_btf_model *model, const char *path,
                               pave_btf_plan **out)
{
    pv_input input;
    uint8_t *text = NULL;
    if (out)
        *out = NULL;
    if (!context || !model || !path || !out)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pave_result result = pv_input_open(context, path, &input);
    if (!result && input.size > (int64_t)MOST_LINE * (pv_model_pairs(model) + 1))
        result = pv_fail(context, PAVE_ERR_FORMAT, "%s: is too long for a plan of %lld pairs", path,
                         (long long)pv_model_pairs(model));
    if (!result)
        result = pv_input_load(&input, &text);
    if (!result)
        result = read_sheet(context, path, (const char *)text, input.size, model, out);
    pv_release(text);
    pv_input_close(&input);
    errno = before;
    return result;
}
