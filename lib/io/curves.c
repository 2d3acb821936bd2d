/* Curves out of an SVG file: the outlines of its shapes, whatever their style. Elements that are not drawn themselves,
 * <defs>, <clipPath>, <mask>, <symbol>, <pattern> and <marker>, are passed over. */
#include "io/outline.h"
#include "mosaic/mosaic.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { DEPTH = 64, MOST_BYTES = 1 << 26 };

/* The file, taken apart tag by tag. */
typedef struct drawing {
    pave_context *context;
    const char *path;
    pv_outlines out;
    pv_transform stack[DEPTH]; /* of the elements that are open */
    int32_t depth, hidden;     /* hidden: the depth from which nothing is drawn; 0: none */
} drawing;

static pv_transform product(const pv_transform *o, const pv_transform *i)
{
    return (pv_transform){ o->a * i->a + o->c * i->b,        o->b * i->a + o->d * i->b,
                           o->a * i->c + o->c * i->d,        o->b * i->c + o->d * i->d,
                           o->a * i->e + o->c * i->f + o->e, o->b * i->e + o->d * i->f + o->f };
}

static pv_transform one_transform(const char *name, size_t length, const double *v, int count)
{
    pv_transform t = { 1, 0, 0, 1, 0, 0 };
    double turn = (count ? v[0] : 0) * (6.283185307179586 / 360);
    if (length == 6 && !strncmp(name, "matrix", 6) && count == 6)
        t = (pv_transform){ v[0], v[1], v[2], v[3], v[4], v[5] };
    else if (length == 9 && !strncmp(name, "translate", 9) && count)
        t.e = v[0], t.f = count > 1 ? v[1] : 0;
    else if (length == 5 && !strncmp(name, "scale", 5) && count)
        t.a = v[0], t.d = count > 1 ? v[1] : v[0];
    else if (length == 5 && !strncmp(name, "skewX", 5))
        t.c = tan(turn);
    else if (length == 5 && !strncmp(name, "skewY", 5))
        t.b = tan(turn);
    else if (length == 6 && !strncmp(name, "rotate", 6)) {
        double x = count == 3 ? v[1] : 0, y = count == 3 ? v[2] : 0, c = cos(turn), s = sin(turn);
        t = (pv_transform){ c, s, -s, c, x - c * x + s * y, y - s * x - c * y };
    }
    return t;
}

static pv_transform read_transform(const char *text)
{
    pv_transform all = { 1, 0, 0, 1, 0, 0 };
    while (text && (text = strpbrk(text, "mtsr")) != NULL) {
        size_t length = 0;
        double v[6];
        int count = 0;
        while (isalpha((unsigned char)text[length]))
            length++;
        const char *at = strchr(text, '('), *next;
        for (at = at ? at + 1 : NULL; at && count < 6 && (next = pv_outline_number(at, &v[count])) != NULL; at = next)
            count++;
        pv_transform one = one_transform(text, length, v, count);
        all = product(&all, &one);
        text = strchr(text, ')');
    }
    return all;
}

/* The value of an attribute in a tag, which is cut out in place; NULL if there is none. */
static char *attribute(char *tag, const char *name)
{
    size_t length = strlen(name);
    for (char *at = tag; (at = strstr(at, name)) != NULL; at += length) {
        char *end = at + length;
        end += strspn(end, " \t\r\n");
        if (at == tag || !isspace((unsigned char)at[-1]) || *end != '=')
            continue;
        end += 1 + strspn(end + 1, " \t\r\n");
        if (*end == '"' || *end == '\'')
            return end + 1;
    }
    return NULL;
}

static double number_of(char *tag, const char *name)
{
    double v = 0;
    const char *value = attribute(tag, name);
    return value && pv_outline_number(value, &v) ? v : 0;
}

static void read_points(drawing *d, const pv_transform *t, const char *text, int close)
{
    double x, y, first_x = 0, first_y = 0;
    int count = 0;
    for (const char *next; text && (next = pv_outline_number(text, &x)) != NULL; count++) {
        text = pv_outline_number(next, &y);
        if (!text)
            break;
        if (!count) {
            pv_outline_begin(&d->out, t, first_x = x, first_y = y);
            continue;
        }
        pv_outline_line(&d->out, t, x, y);
    }
    if (close && count)
        pv_outline_line(&d->out, t, first_x, first_y);
}

static void read_rectangle(drawing *d, const pv_transform *t, char *tag)
{
    double x = number_of(tag, "x"), y = number_of(tag, "y"), w = number_of(tag, "width"), h = number_of(tag, "height");
    if (!(w > 0 && h > 0))
        return;
    pv_outline_begin(&d->out, t, x, y);
    pv_outline_line(&d->out, t, x + w, y);
    pv_outline_line(&d->out, t, x + w, y + h);
    pv_outline_line(&d->out, t, x, y + h);
    pv_outline_line(&d->out, t, x, y);
}

static int is(const char *tag, const char *name)
{
    size_t n = strlen(name);
    return !strncmp(tag, name, n) && (isspace((unsigned char)tag[n]) || tag[n] == '/' || !tag[n]);
}

static void read_shape(drawing *d, const pv_transform *t, char *tag)
{
    if (is(tag, "path")) {
        char *data = attribute(tag, "d"), *end = data ? data + strcspn(data, "\"'") : NULL;
        char quote = end ? *end : 0;
        if (!data)
            return;
        *end = 0;
        if (!pv_outline_path(&d->out, t, data))
            pv_note(d->context, PAVE_MESSAGE_WARNING, "%s: a path is drawn only so far as it is well formed", d->path);
        *end = quote;
    } else if (is(tag, "polyline") || is(tag, "polygon")) {
        read_points(d, t, attribute(tag, "points"), is(tag, "polygon"));
    } else if (is(tag, "line")) {
        pv_outline_begin(&d->out, t, number_of(tag, "x1"), number_of(tag, "y1"));
        pv_outline_line(&d->out, t, number_of(tag, "x2"), number_of(tag, "y2"));
    } else if (is(tag, "rect")) {
        read_rectangle(d, t, tag);
    } else if (is(tag, "circle")) {
        double r = number_of(tag, "r");
        pv_outline_ellipse(&d->out, t, number_of(tag, "cx"), number_of(tag, "cy"), r, r);
    } else if (is(tag, "ellipse")) {
        pv_outline_ellipse(&d->out, t, number_of(tag, "cx"), number_of(tag, "cy"), number_of(tag, "rx"),
                           number_of(tag, "ry"));
    }
}

static int is_hidden(const char *tag)
{
    static const char *const names[] = { "defs", "clipPath", "mask", "symbol", "pattern", "marker", "text" };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (is(tag, names[i]))
            return 1;
    return 0;
}

/* A tag without its brackets. */
static pave_result read_tag(drawing *d, char *tag)
{
    size_t length = strlen(tag);
    if (*tag == '/') {
        d->depth -= d->depth > 0;
        d->hidden = d->hidden > d->depth ? 0 : d->hidden;
        return PAVE_OK;
    }
    if (d->depth + 1 == DEPTH)
        return pv_fail(d->context, PAVE_ERR_FORMAT, "%s: is nested more than %d deep", d->path, DEPTH - 2);
    char *value = attribute(tag, "transform"), *end = value ? value + strcspn(value, "\"'") : NULL;
    char quote = end ? *end : 0;
    pv_transform own = { 1, 0, 0, 1, 0, 0 };
    if (end) {
        *end = 0;
        own = read_transform(value);
        *end = quote;
    }
    d->stack[d->depth + 1] = product(&d->stack[d->depth], &own);
    if (!d->hidden && is_hidden(tag))
        d->hidden = d->depth + 1;
    if (!d->hidden)
        read_shape(d, &d->stack[d->depth + 1], tag);
    if (length && tag[length - 1] == '/')
        d->hidden = d->hidden == d->depth + 1 ? 0 : d->hidden;
    else
        d->depth++;
    return d->out.result;
}

static char *end_of(char *at, const char *what)
{
    char *end = strstr(at, what);
    return end ? end + strlen(what) : NULL;
}

static char *end_of_tag(char *at)
{
    for (char quote = 0; *at; at++) {
        if (quote ? *at == quote : *at == '"' || *at == '\'')
            quote = quote ? 0 : *at;
        else if (*at == '>' && !quote)
            return at;
    }
    return NULL;
}

static pave_result read_text(drawing *d, char *at)
{
    pave_result result = PAVE_OK;
    int known = 0;
    while (!result && (at = strchr(at, '<')) != NULL) {
        if (!strncmp(at, "<!--", 4) || at[1] == '?' || at[1] == '!') {
            at = !strncmp(at, "<!--", 4) ? end_of(at, "-->") : end_of(at, ">");
        } else {
            char *end = end_of_tag(++at);
            if (!end)
                return pv_fail(d->context, PAVE_ERR_FORMAT, "%s: ends within a tag", d->path);
            *end = 0;
            known |= is(at, "svg");
            result = read_tag(d, at);
            at = end + 1;
        }
        if (!at)
            break;
        if (!result)
            result = pv_progress(d->context, 0);
    }
    if (!result && !known)
        result = pv_fail(d->context, PAVE_ERR_FORMAT, "%s: is no SVG file", d->path);
    return result;
}

static pave_result read_file(pave_context *context, const char *path, char **text)
{
    struct stat info;
    pave_result result = PAVE_OK;
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    int64_t done = 0;
    *text = NULL;
    if (file < 0 || fstat(file, &info) || !S_ISREG(info.st_mode))
        result = pv_fail(context, PAVE_ERR_IO, "%s: cannot be read", path);
    else if (info.st_size > MOST_BYTES)
        result = pv_fail(context, PAVE_ERR_LIMIT, "%s: more than %d MiB of curves", path, MOST_BYTES >> 20);
    else
        *text = pv_allocate_zeroed(context, (size_t)info.st_size + 1, 1, &result);
    while (!result && done < info.st_size) {
        ssize_t n = read(file, *text + done, (size_t)(info.st_size - done));
        if (n > 0)
            done += n;
        else if (n == 0 || errno != EINTR)
            result = pv_fail(context, PAVE_ERR_IO, "%s: cannot be read", path);
    }
    if (file >= 0)
        close(file);
    return result;
}

static pave_result read_curves(pave_context *context, const char *path, pave_curves **out)
{
    drawing d = { .context = context, .path = path, .out = { .context = context }, .stack = { { 1, 0, 0, 1, 0, 0 } } };
    char *text;
    pave_result result = read_file(context, path, &text);
    if (!result)
        result = read_text(&d, text);
    if (!result && !d.out.count)
        result = pv_fail(context, PAVE_ERR_FORMAT, "%s: has no curves", path);
    for (int64_t i = 0; !result && i < 2 * d.out.starts[d.out.count]; i++)
        if (!isfinite(d.out.points[i]))
            result = pv_fail(context, PAVE_ERR_FORMAT, "%s: a curve leads beyond all numbers", path);
    if (!result)
        result = pave_curves_create(context, d.out.count, d.out.starts, d.out.points, out);
    pv_release(text);
    pv_release(d.out.starts);
    pv_release(d.out.points);
    return result;
}

pave_result pave_curves_read(pave_context *context, const char *path, pave_curves **out)
{
    if (out)
        *out = NULL;
    if (!context || !path || !out)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pv_call call = pv_call_begin(context, "read", 0, 1);
    pave_result result = read_curves(context, path, out);
    pv_call_end(context, call);
    errno = before;
    return result;
}
