/* Stones from SVG: polygons and straight paths in one plain colour each. What would make figures wrong without a word
 * (curves, transforms, style sheets, holes) is refused. */
#include "image/image.h"
#include "io/collect.h"
#include "util/text.h"
#include "util/xml.h"

#include <string.h>

enum { DEPTH = 256, CORNERS = 1024, MOST = 1 << 21 }; /* px: no coordinate is beyond */

typedef struct rgb {
    uint8_t r, g, b, drawn;
} rgb;

typedef struct level {
    pv_span name;
    rgb fill;
    int passed_over; /* its inside is not part of the picture */
} level;

typedef struct reader {
    pave_context *context;
    const char *path;
    pv_collection *collection;
    pv_xml xml;
    int32_t depth, corners;
    level levels[DEPTH];
    int32_t xy[2 * CORNERS];
} reader;

static pave_result refuse(reader *r, pave_result result, const char *what, pv_span span)
{
    return pv_fail(r->context, result, "%s: line %d: %s%s%.*s%s", r->path, pv_xml_line(&r->xml), what,
                   span.size ? " '" : "", (int)(span.size < 40 ? span.size : 40), span.size ? span.at : "",
                   span.size ? "'" : "");
}

static pave_result broken(reader *r, const char *what)
{
    return refuse(r, PAVE_ERR_FORMAT, what, (pv_span){ 0 });
}

/* Numbers with white space and commas between them. */
static void pass_gap(pv_span *s)
{
    while (s->size && memchr(" \t\r\n,", *s->at, 5))
        s->at++, s->size--;
}

static int take_number(pv_span *s, int64_t *out)
{
    pass_gap(s);
    size_t n = pv_parse_millionths(s->at, s->size, out);
    s->at += n;
    s->size -= n;
    return n > 0 && *out <= (int64_t)MOST * 1000000 && *out >= -(int64_t)MOST * 1000000;
}

static int32_t to_thousandths(int64_t millionths)
{
    return (int32_t)(millionths >= 0 ? (millionths + 500) / 1000 : -((500 - millionths) / 1000));
}

static pave_result add_corner(reader *r, int64_t x, int64_t y)
{
    if (r->corners == CORNERS)
        return pv_fail(r->context, PAVE_ERR_LIMIT, "%s: line %d: a stone has more than %d corners", r->path,
                       pv_xml_line(&r->xml), CORNERS);
    if (x > (int64_t)MOST * 1000000 || x < -(int64_t)MOST * 1000000 || y > (int64_t)MOST * 1000000 ||
        y < -(int64_t)MOST * 1000000)
        return broken(r, "a coordinate is beyond what is read");
    r->xy[2 * r->corners] = to_thousandths(x);
    r->xy[2 * r->corners++ + 1] = to_thousandths(y);
    return PAVE_OK;
}

static pave_result read_points(reader *r, pv_span points)
{
    pave_result result = PAVE_OK;
    for (pass_gap(&points); points.size && !result; pass_gap(&points)) {
        int64_t x, y;
        if (!take_number(&points, &x) || !take_number(&points, &y))
            return refuse(r, PAVE_ERR_FORMAT, "polygon's points are not pairs of numbers at", points);
        result = add_corner(r, x, y);
    }
    return result;
}

/* One M, L, H or V in either case, from where the pen is. */
static int take_step(char command, pv_span *d, int64_t *x, int64_t *y)
{
    int64_t a, b = 0, relative = command >= 'a';
    char kind = (char)(command & ~32);
    if (!take_number(d, &a) || (kind != 'H' && kind != 'V' && !take_number(d, &b)))
        return 0;
    if (kind != 'V')
        *x = a + (relative ? *x : 0);
    if (kind == 'V')
        *y = a + (relative ? *y : 0);
    else if (kind != 'H')
        *y = b + (relative ? *y : 0);
    return 1;
}

static pave_result read_path(reader *r, pv_span d)
{
    int64_t x = 0, y = 0;
    char command = 0;
    pave_result result = PAVE_OK;
    for (pass_gap(&d); d.size && !result; pass_gap(&d)) {
        if ((*d.at >= 'a' && *d.at <= 'z') || (*d.at >= 'A' && *d.at <= 'Z')) {
            if (!memchr("MmLlHhVvZz", *d.at, 10))
                return refuse(r, PAVE_ERR_UNSUPPORTED, "a path with a command that is no straight line:",
                              (pv_span){ d.at, 1 });
            if (command && (command == 'z' || (*d.at & ~32) == 'M'))
                return broken(r, "a path of more than one ring is not one stone");
            command = *d.at == 'Z' ? 'z' : *d.at;
            d.at++, d.size--;
            if (command == 'z')
                continue;
        }
        if (!command || command == 'z' || (!r->corners && (command & ~32) != 'M') || !take_step(command, &d, &x, &y))
            return refuse(r, PAVE_ERR_FORMAT, "a path is not well formed at", d);
        result = add_corner(r, x, y);
        command = command == 'M' ? 'L' : command == 'm' ? 'l' : command;
    }
    return result;
}

static int hex(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
}

static int read_hex(pv_span s, rgb *out)
{
    int v[6], wide = s.size == 7;
    if (s.size != 4 && s.size != 7)
        return 0;
    for (int i = 0; i < 6; i++)
        if ((v[i] = hex(s.at[1 + (wide ? i : i / 2)])) < 0)
            return 0;
    *out = (rgb){ (uint8_t)(16 * v[0] + v[1]), (uint8_t)(16 * v[2] + v[3]), (uint8_t)(16 * v[4] + v[5]), 1 };
    return 1;
}

/* rgb(12, 34, 56) */
static int read_rgb(pv_span s, rgb *out)
{
    int64_t v[3];
    if (s.size < 5 || memcmp(s.at, "rgb(", 4) || s.at[s.size - 1] != ')')
        return 0;
    s = (pv_span){ s.at + 4, s.size - 5 };
    for (int i = 0; i < 3; i++)
        if (!take_number(&s, &v[i]) || v[i] < 0 || v[i] > 255000000 || v[i] % 1000000)
            return 0;
    *out = (rgb){ (uint8_t)(v[0] / 1000000), (uint8_t)(v[1] / 1000000), (uint8_t)(v[2] / 1000000), 1 };
    pass_gap(&s);
    return !s.size;
}

static int read_name(pv_span s, rgb *out)
{
    static const struct { const char *name; rgb colour; } names[] = {
        { "none", { 0, 0, 0, 0 } },          { "transparent", { 0, 0, 0, 0 } }, { "black", { 0, 0, 0, 1 } },
        { "white", { 255, 255, 255, 1 } },   { "gray", { 128, 128, 128, 1 } },  { "grey", { 128, 128, 128, 1 } },
        { "silver", { 192, 192, 192, 1 } },  { "red", { 255, 0, 0, 1 } },       { "maroon", { 128, 0, 0, 1 } },
        { "yellow", { 255, 255, 0, 1 } },    { "olive", { 128, 128, 0, 1 } },   { "lime", { 0, 255, 0, 1 } },
        { "green", { 0, 128, 0, 1 } },       { "aqua", { 0, 255, 255, 1 } },    { "teal", { 0, 128, 128, 1 } },
        { "blue", { 0, 0, 255, 1 } },        { "navy", { 0, 0, 128, 1 } },      { "fuchsia", { 255, 0, 255, 1 } },
        { "purple", { 128, 0, 128, 1 } },
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (pv_span_is(s, names[i].name)) {
            *out = names[i].colour;
            return 1;
        }
    return 0;
}

static pv_span trimmed(pv_span s)
{
    while (s.size && memchr(" \t\r\n", *s.at, 4))
        s.at++, s.size--;
    while (s.size && memchr(" \t\r\n", s.at[s.size - 1], 4))
        s.size--;
    return s;
}

/* The value of `fill` in style="stroke: none; fill: #fff". */
static int style_fill(pv_span style, pv_span *fill)
{
    while (style.size) {
        const char *end = memchr(style.at, ';', style.size);
        size_t n = end ? (size_t)(end - style.at) : style.size;
        const char *colon = memchr(style.at, ':', n);
        if (colon && pv_span_is(trimmed((pv_span){ style.at, (size_t)(colon - style.at) }), "fill")) {
            *fill = (pv_span){ colon + 1, n - (size_t)(colon + 1 - style.at) };
            return 1;
        }
        style = (pv_span){ style.at + n + (end != NULL), style.size - n - (end != NULL) };
    }
    return 0;
}

/* The element's own fill, or else the one around it. */
static pave_result read_fill(reader *r, rgb *fill)
{
    pv_span value, style;
    if (!(pv_xml_attribute(&r->xml, "style", &style) && style_fill(style, &value)) &&
        !pv_xml_attribute(&r->xml, "fill", &value))
        return PAVE_OK;
    value = trimmed(value);
    if (pv_span_is(value, "inherit"))
        return PAVE_OK;
    if (!value.size || (*value.at == '#' ? !read_hex(value, fill) : !read_rgb(value, fill) && !read_name(value, fill)))
        return refuse(r, PAVE_ERR_UNSUPPORTED, "a fill that is not a plain colour (#rrggbb):", value);
    return PAVE_OK;
}

/* As the luma of black and white drawings has it. */
static uint8_t black_or_white(rgb c)
{
    return 299 * c.r + 587 * c.g + 114 * c.b >= 128000 ? 255 : 0;
}

static pave_result add_stone(reader *r, rgb fill)
{
    pave_stones *stones = r->collection->stones;
    int32_t last = r->corners - 1;
    if (!fill.drawn)
        return PAVE_OK;
    if (last > 0 && r->xy[0] == r->xy[2 * last] && r->xy[1] == r->xy[2 * last + 1])
        last--;
    pv_stone stone = { .number = stones->count, .corners = last + 1, .colour = black_or_white(fill), .xy = r->xy };
    return pv_collect_add(r->context, r->collection, &stone, (const uint8_t[3]){ fill.r, fill.g, fill.b });
}

static pave_result read_shape(reader *r, rgb fill)
{
    pv_span value;
    pave_result result = PAVE_OK;
    r->corners = 0;
    if (pv_span_is(r->xml.name, "polygon")) {
        if (pv_xml_attribute(&r->xml, "points", &value))
            result = read_points(r, value);
    } else {
        if (!pv_xml_attribute(&r->xml, "d", &value))
            return PAVE_OK;
        result = read_path(r, value);
    }
    return result ? result : add_stone(r, fill);
}

/* viewBox="0 0 W H": the window, in whole px. */
static pave_result read_window(reader *r)
{
    pv_span box;
    int64_t v[4];
    if (!pv_span_is(r->xml.name, "svg"))
        return broken(r, "is not SVG: its first tag is not <svg>");
    if (!pv_xml_attribute(&r->xml, "viewBox", &box))
        return broken(r, "<svg> has no viewBox, so that nobody knows the size of its plane");
    pv_span rest = box;
    for (int i = 0; i < 4; i++)
        if (!take_number(&rest, &v[i]) || v[i] % 1000000 || v[i] < 0 || v[i] / 1000000 > 1 << 20)
            return refuse(r, PAVE_ERR_FORMAT, "the viewBox must be X Y WIDTH HEIGHT in whole px, not", box);
    pave_stones *s = r->collection->stones;
    s->x = (int32_t)(v[0] / 1000000);
    s->y = (int32_t)(v[1] / 1000000);
    s->width = (int32_t)(v[2] / 1000000);
    s->height = (int32_t)(v[3] / 1000000);
    s->plane_width = s->x + s->width;
    s->plane_height = s->y + s->height;
    return pv_check_size(r->context, r->path, s->width, s->height);
}

static int is_passed_over(pv_span name)
{
    static const char *const names[] = { "defs", "clipPath", "mask", "pattern", "symbol", "marker", "metadata",
                                         "title", "desc", "linearGradient", "radialGradient", "text" };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (pv_span_is(name, names[i]))
            return 1;
    return 0;
}

static pave_result open_element(reader *r)
{
    pv_span value;
    level here = { r->xml.name, { 0, 0, 0, 1 }, 0 };
    pave_result result = r->depth ? PAVE_OK : read_window(r);
    if (r->depth == DEPTH)
        return broken(r, "tags are nested too deep");
    if (r->depth) {
        here.fill = r->levels[r->depth - 1].fill;
        here.passed_over = r->levels[r->depth - 1].passed_over || is_passed_over(r->xml.name);
    }
    if (!result && !here.passed_over && pv_xml_attribute(&r->xml, "transform", &value))
        return refuse(r, PAVE_ERR_UNSUPPORTED, "transforms are not read:", value);
    if (!result && !here.passed_over)
        result = read_fill(r, &here.fill);
    if (!result && !here.passed_over && (pv_span_is(r->xml.name, "polygon") || pv_span_is(r->xml.name, "path")))
        result = read_shape(r, here.fill);
    if (!r->xml.empty)
        r->levels[r->depth++] = here;
    return result;
}

static pave_result close_element(reader *r)
{
    pv_span name = r->depth ? r->levels[r->depth - 1].name : (pv_span){ "", 0 };
    if (!r->depth || name.size != r->xml.name.size || memcmp(name.at, r->xml.name.at, name.size))
        return refuse(r, PAVE_ERR_FORMAT, "a tag is closed that was not the last one opened:", r->xml.name);
    r->depth--;
    return PAVE_OK;
}

static pave_result read_text(reader *r)
{
    if (!r->depth)
        return broken(r, "is not SVG: there is text outside of all tags");
    if (pv_span_is(r->levels[r->depth - 1].name, "style") && !r->levels[r->depth - 1].passed_over)
        return refuse(r, PAVE_ERR_UNSUPPORTED, "style sheets are not read", (pv_span){ 0 });
    return PAVE_OK;
}

static pave_result read_all(reader *r)
{
    pave_result result = PAVE_OK;
    int what = PV_XML_TEXT, roots = 0;
    for (int64_t k = 0; !result && (what = pv_xml_next(&r->xml)) != PV_XML_END; k++) {
        if (what == PV_XML_BROKEN)
            return broken(r, r->xml.reason);
        if (what == PV_XML_OPEN && !r->depth && roots++)
            return broken(r, "there is something after </svg>");
        result = what == PV_XML_OPEN ? open_element(r) : what == PV_XML_CLOSE ? close_element(r) : read_text(r);
        if (!result && k % 1024 == 0)
            result = pv_progress(r->context, (double)(r->xml.at - r->xml.begin) / (double)(r->xml.end - r->xml.begin));
    }
    if (!result && (r->depth || !roots))
        return broken(r, roots ? "ends before </svg>" : "is not SVG: there is no tag in it");
    return result;
}

pave_result pv_svg_read(pave_context *context, const char *path, const char *bytes, size_t size,
                        pv_collection *collection)
{
    pave_result result = PAVE_OK;
    reader *r = pv_allocate_zeroed(context, 1, sizeof *r, &result);
    if (!r)
        return result;
    r->context = context;
    r->path = path;
    r->collection = collection;
    pv_xml_begin(&r->xml, bytes, size);
    result = read_all(r);
    collection->stones->report.stones = collection->stones->count;
    pv_release(r);
    return result;
}
