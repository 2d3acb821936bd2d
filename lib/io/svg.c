/* Stones as SVG: one polygon a stone, on a ground of grout; grouped by colour, but for mosaics, whose tiles have their
 * own colours and their order. */
#include "io/output.h"
#include "io/pavement.h"
#include "stones/copies.h"
#include "stones/palette.h"

#include <stdio.h>

static void put_colour(pv_output *output, pv_colour colour)
{
    char text[8];
    snprintf(text, sizeof text, "#%02x%02x%02x", colour.r, colour.g, colour.b);
    pv_output_text(output, text);
}

static void put_head(pv_output *output, const pave_stones *stones)
{
    char text[256];
    int32_t x = stones->x, y = stones->y, w = stones->width, h = stones->height;
    snprintf(text, sizeof text,
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"%d %d %d %d\">\n"
             "<title>%s of %d %s</title>\n<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"",
             w, h, x, y, w, h, stones->mosaic ? "Mosaic" : "Pavement", stones->count,
             stones->mosaic ? "tiles" : "stones", x, y, w, h);
    pv_output_text(output, text);
    put_colour(output, pv_grout);
    pv_output_text(output, "\"/>\n");
}

static void put_name(pv_output *output, const pv_stone *stone)
{
    pv_output_text(output, "s");
    pv_output_whole(output, stone->number);
    if (!stone->part)
        return;
    pv_output_text(output, "-");
    pv_output_whole(output, stone->part);
}

/* Where the plane repeats, a stone may be seen more than once. */
static void put_copies(pv_output *output, const pave_stones *head, const pv_stone *stone)
{
    pv_copies c = pv_copies_seen(head, stone->xy, stone->corners);
    for (int32_t y = c.first_y; y <= c.last_y; y++)
        for (int32_t x = c.first_x; x <= c.last_x; x++) {
            if (!x && !y)
                continue;
            pv_output_text(output, "<use href=\"#");
            put_name(output, stone);
            pv_output_text(output, "\" x=\"");
            pv_output_whole(output, (int64_t)x * head->plane_width);
            pv_output_text(output, "\" y=\"");
            pv_output_whole(output, (int64_t)y * head->plane_height);
            pv_output_text(output, "\"/>\n");
        }
}

static void put_stone(pv_output *output, const pv_stone *stone)
{
    pv_output_text(output, "<polygon id=\"");
    put_name(output, stone);
    pv_output_text(output, "\" points=\"");
    for (int32_t i = 0; i < stone->corners; i++) {
        if (i)
            pv_output_text(output, " ");
        pv_output_thousandths(output, stone->xy[2 * i]);
        pv_output_text(output, ",");
        pv_output_thousandths(output, stone->xy[2 * i + 1]);
    }
    if (stone->rgb) {
        pv_output_text(output, "\" fill=\"");
        put_colour(output, (pv_colour){ stone->rgb[0], stone->rgb[1], stone->rgb[2] });
    }
    pv_output_text(output, "\"/>\n");
}

static void put_group_head(pv_output *output, const pave_stones *stones, int32_t value)
{
    int coloured = stones->palette.palette.count > 0;
    pv_output_text(output, "<g id=\"");
    pv_output_text(output, coloured ? "colour" : value == 0 ? "black" : value == 255 ? "white" : "grey");
    if (coloured || (value > 0 && value < 255))
        pv_output_whole(output, value);
    pv_output_text(output, "\" fill=\"");
    put_colour(output, pv_laid_colour(stones, (uint8_t)value));
    pv_output_text(output, "\">\n");
}

/* One pass over the pile for each colour: nothing is kept. */
static pave_result put_group(pave_context *context, pv_output *output, pv_pile *pile, int32_t value, double *done)
{
    pave_result result = PAVE_OK;
    pv_stone stone;
    put_group_head(output, &pile->head, value);
    pile->rewind(pile);
    for (int64_t seen = 0; !result; seen++) {
        result = pile->next(context, pile, &stone);
        if (result || !stone.corners)
            break;
        if (stone.colour != value)
            continue;
        put_stone(output, &stone);
        put_copies(output, &pile->head, &stone);
        if ((int64_t)(*done += 1) % 4096 == 0)
            result = pv_progress(context, *done / pile->head.count);
    }
    pv_output_text(output, "</g>\n");
    return result;
}

static pave_result put_tiles(pave_context *context, pv_output *output, pv_pile *pile)
{
    pave_result result = PAVE_OK;
    pv_stone stone;
    pile->rewind(pile);
    for (int64_t seen = 1; !result; seen++) {
        result = pile->next(context, pile, &stone);
        if (result || !stone.corners)
            break;
        put_stone(output, &stone);
        put_copies(output, &pile->head, &stone);
        if (seen % 4096 == 0)
            result = pv_progress(context, (double)seen / pile->head.count);
    }
    return result;
}

pave_result pv_svg_write(pave_context *context, pv_pile *pile, const char *path)
{
    pv_output *output;
    pave_result result = pv_output_open(context, path, 0, &output);
    double done = 0;
    if (result)
        return result;
    put_head(output, &pile->head);
    if (pile->head.mosaic)
        result = put_tiles(context, output, pile);
    for (int32_t value = 0; value < 256 && !result && !pile->head.mosaic; value++)
        if (pile->counts[value])
            result = put_group(context, output, pile, value, &done);
    pv_output_text(output, "</svg>\n");
    return pv_output_close(output, result);
}
