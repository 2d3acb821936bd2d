/* SVG's path language, flattened. */
#include "io/outline.h"

#include "util/text.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

enum { PIECES = 16 }; /* of a curve: a mosaic's tiles see no more */

static void add(pv_outlines *o, const pv_transform *t, double x, double y)
{
    if (o->result)
        return;
    if (o->point_count == o->points_room) {
        int64_t room = o->points_room ? 2 * o->points_room : 256;
        double *points = pv_resize(o->context, o->points, (size_t)o->points_room * 2, (size_t)room * 2, sizeof *points,
                                   &o->result);
        if (!points)
            return;
        o->points = points;
        o->points_room = room;
    }
    o->points[2 * o->point_count] = t->a * x + t->c * y + t->e;
    o->points[2 * o->point_count++ + 1] = t->b * x + t->d * y + t->f;
    o->starts[o->count] = o->point_count;
    o->x = x;
    o->y = y;
}

void pv_outline_begin(pv_outlines *o, const pv_transform *t, double x, double y)
{
    if (o->result)
        return;
    if (o->count + 2 > o->starts_room) {
        int64_t room = o->starts_room ? 2 * o->starts_room : 64;
        int64_t *starts = pv_resize(o->context, o->starts, (size_t)o->starts_room, (size_t)room, sizeof *starts,
                                    &o->result);
        if (!starts)
            return;
        if (!o->starts_room)
            starts[0] = 0;
        o->starts = starts;
        o->starts_room = room;
    }
    o->count++;
    add(o, t, x, y);
}

void pv_outline_line(pv_outlines *o, const pv_transform *t, double x, double y)
{
    add(o, t, x, y);
}

void pv_outline_cubic(pv_outlines *o, const pv_transform *t, const double c[6])
{
    double x = o->x, y = o->y;
    for (int i = 1; i <= PIECES; i++) {
        double u = (double)i / PIECES, v = 1 - u;
        double p = v * v * v, q = 3 * v * v * u, r = 3 * v * u * u, s = u * u * u;
        add(o, t, p * x + q * c[0] + r * c[2] + s * c[4], p * y + q * c[1] + r * c[3] + s * c[5]);
    }
}

static const double turn_once = 6.283185307179586;

void pv_outline_ellipse(pv_outlines *o, const pv_transform *t, double cx, double cy, double rx, double ry)
{
    pv_outline_begin(o, t, cx + rx, cy);
    for (int i = 1; i <= 4 * PIECES; i++)
        add(o, t, cx + rx * cos(turn_once * i / (4 * PIECES)), cy + ry * sin(turn_once * i / (4 * PIECES)));
}

void pv_outline_arc(pv_outlines *o, const pv_transform *t, double rx, double ry, double turn, int large, int sweep,
                    double x, double y)
{
    double c = cos(turn * turn_once / 360), s = sin(turn * turn_once / 360), dx = (o->x - x) / 2, dy = (o->y - y) / 2;
    double px = c * dx + s * dy, py = c * dy - s * dx;
    rx = fabs(rx), ry = fabs(ry);
    if (rx > 0 && ry > 0) {
        double grow = sqrt(px * px / (rx * rx) + py * py / (ry * ry));
        rx *= grow > 1 ? grow : 1, ry *= grow > 1 ? grow : 1;
        double rest = rx * rx * py * py + ry * ry * px * px, over = fmax(0, rx * rx * ry * ry - rest);
        double k = rest > 0 ? sqrt(over / rest) * (large == sweep ? -1 : 1) : 0;
        double mx = k * rx * py / ry, my = -k * ry * px / rx;
        double cx = c * mx - s * my + (o->x + x) / 2, cy = s * mx + c * my + (o->y + y) / 2;
        double from = atan2((py - my) / ry, (px - mx) / rx), way = atan2((-py - my) / ry, (-px - mx) / rx) - from;
        way += sweep && way < 0 ? turn_once : !sweep && way > 0 ? -turn_once : 0;
        for (int i = 1; i < 2 * PIECES; i++) {
            double a = from + way * i / (2 * PIECES), u = rx * cos(a), v = ry * sin(a);
            add(o, t, cx + c * u - s * v, cy + s * u + c * v);
        }
    }
    add(o, t, x, y);
}

static const char *skip(const char *text)
{
    while (*text == ',' || isspace((unsigned char)*text))
        text++;
    return text;
}

const char *pv_outline_number(const char *text, double *number)
{
    char word[64];
    size_t n = 0;
    int point = 0, power = 0;
    text = skip(text);
    for (; n < sizeof word - 1; n++) { /* "1-2" and "1.5.5" are two numbers each */
        char c = text[n], before = n ? text[n - 1] : 'e';
        int sign = (c == '+' || c == '-') && (before == 'e' || before == 'E');
        if (!(isdigit((unsigned char)c) || sign || (c == '.' && !point && !power) ||
              ((c == 'e' || c == 'E') && n && !power)))
            break;
        point |= c == '.';
        power |= c == 'e' || c == 'E';
        word[n] = c;
    }
    word[n] = 0;
    return n && pv_parse_number(word, number) && isfinite(*number) ? text + n : NULL;
}

/* A flag may stand without a space after it. */
static const char *read_flag(const char *text, double *flag)
{
    text = skip(text);
    *flag = *text == '1';
    return *text == '0' || *text == '1' ? text + 1 : NULL;
}

static int arguments_of(char command)
{
    const char *at = strchr("M2L2H1V1C6S4Q4T2A7Z0", toupper((unsigned char)command));
    return at && isalpha((unsigned char)command) ? at[1] - '0' : -1;
}

static const char *read_arguments(const char *data, char command, int count, double *v)
{
    for (int i = 0; i < count && data; i++)
        data = command == 'A' && (i == 3 || i == 4) ? read_flag(data, &v[i]) : pv_outline_number(data, &v[i]);
    return data;
}

typedef struct pen {
    double start_x, start_y;     /* of the subpath */
    double control_x, control_y; /* the last curve's second control point, the current point after other commands */
    char kind;                   /* of the last command: C, Q or another */
} pen;

static void make_absolute(char command, int count, double x, double y, double *v)
{
    if (command == 'H' || command == 'V')
        v[0] += command == 'H' ? x : y;
    else
        for (int i = command == 'A' ? 5 : 0; i < count; i++)
            v[i] += (i + (command == 'A')) % 2 ? y : x;
}

static void draw_curve(pv_outlines *o, const pv_transform *t, pen *p, char command, const double *v)
{
    double x = o->x, y = o->y, c[6];
    int smooth = command == 'S' || command == 'T', cubic = command == 'C' || command == 'S';
    int same = p->kind == (cubic ? 'C' : 'Q');
    double mx = same ? 2 * x - p->control_x : x, my = same ? 2 * y - p->control_y : y;
    const double *end = v + (command == 'T' ? 0 : command == 'C' ? 4 : 2);
    if (cubic) {
        c[0] = smooth ? mx : v[0], c[1] = smooth ? my : v[1];
        c[2] = p->control_x = smooth ? v[0] : v[2], c[3] = p->control_y = smooth ? v[1] : v[3];
    } else {
        double qx = smooth ? mx : v[0], qy = smooth ? my : v[1];
        c[0] = x + (qx - x) * 2 / 3, c[1] = y + (qy - y) * 2 / 3;
        c[2] = end[0] + (qx - end[0]) * 2 / 3, c[3] = end[1] + (qy - end[1]) * 2 / 3;
        p->control_x = qx, p->control_y = qy;
    }
    c[4] = end[0], c[5] = end[1];
    pv_outline_cubic(o, t, c);
    p->kind = cubic ? 'C' : 'Q';
}

static void draw(pv_outlines *o, const pv_transform *t, pen *p, char command, const double *v)
{
    switch (command) {
    case 'M':
        pv_outline_begin(o, t, v[0], v[1]);
        p->start_x = v[0], p->start_y = v[1];
        break;
    case 'L': pv_outline_line(o, t, v[0], v[1]); break;
    case 'H': pv_outline_line(o, t, v[0], o->y); break;
    case 'V': pv_outline_line(o, t, o->x, v[0]); break;
    case 'A': pv_outline_arc(o, t, v[0], v[1], v[2], v[3] != 0, v[4] != 0, v[5], v[6]); break;
    case 'Z': pv_outline_line(o, t, p->start_x, p->start_y); break;
    default: draw_curve(o, t, p, command, v); return;
    }
    p->kind = command;
}

int pv_outline_path(pv_outlines *o, const pv_transform *t, const char *data)
{
    pen p = { .kind = 0 };
    char letter = 0;
    int begun = 0;
    o->x = o->y = 0;
    for (data = skip(data); *data && !o->result; data = skip(data)) {
        double v[7];
        int fresh = isalpha((unsigned char)*data);
        if (fresh)
            letter = *data++;
        char command = (char)toupper((unsigned char)letter);
        int count = arguments_of(letter);
        if (count < 0 || (!fresh && !count) || (!begun && command != 'M'))
            return 0;
        data = read_arguments(data, command, count, v);
        if (!data)
            return 0;
        if (islower((unsigned char)letter))
            make_absolute(command, count, begun ? o->x : 0, begun ? o->y : 0, v);
        draw(o, t, &p, command, v);
        begun = 1;
        letter = letter == 'M' ? 'L' : letter == 'm' ? 'l' : letter;
    }
    return 1;
}
