/* Faces: each stone's own piece of a texture or of a volume. */
#include "maps/maps.h"

#include "util/fixed.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

enum { TRIES = 64 };
static const double most_deviations = 2;

static pv_random draw(const pv_bed *bed, const pv_laid *laid, uint32_t use, uint32_t which)
{
    return pv_draw(bed->params.seed, use, (uint32_t)laid->number, (uint32_t)laid->part, which);
}

/* A unit quaternion from four numbers within the unit ball: all directions are alike. */
static void turn_anyhow(const pv_bed *bed, const pv_laid *laid, double turn[3][3])
{
    double q[4] = { 1, 0, 0, 0 }, norm = 0;
    for (uint32_t i = 0; i < TRIES; i++) {
        pv_random r = draw(bed, laid, PV_DRAW_PLANE, i);
        double p[4];
        norm = 0;
        for (int k = 0; k < 4; k++) {
            p[k] = pv_signed_unit(r.word[k]);
            norm += p[k] * p[k];
        }
        if (norm > 1 || norm < 0.01)
            continue;
        for (int k = 0; k < 4; k++)
            q[k] = p[k] / sqrt(norm);
        break;
    }
    double w = q[0], x = q[1], y = q[2], z = q[3];
    const double rows[3][3] = { { 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y) },
                                { 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x) },
                                { 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y) } };
    memcpy(turn, rows, sizeof rows);
}

/* In the plane, by an angle of which 65536 make a turn. */
static void turn_flat(int32_t angle, double turn[3][3])
{
    int32_t cosine, sine;
    pv_turn(angle, &cosine, &sine);
    const double c = cosine / 65536.0, s = sine / 65536.0;
    const double rows[3][3] = { { c, -s, 0 }, { s, c, 0 }, { 0, 0, 1 } };
    memcpy(turn, rows, sizeof rows);
}

static void draw_turn(const pv_bed *bed, const pv_laid *laid, const pv_quarry *block, uint32_t word, double turn[3][3])
{
    if (bed->params.turns == PAVE_TURNS_ANY && block->size[2] > 1)
        turn_anyhow(bed, laid, turn);
    else
        turn_flat(bed->params.turns == PAVE_TURNS_NONE      ? 0
                  : bed->params.turns == PAVE_TURNS_QUARTER ? (int32_t)(word >> 30) << 14
                                                            : (int32_t)(word >> 16), turn);
}

/* Where the anchor comes to lie: on a corner between voxels, so that centres fall on centres. Mirrored blocks are met
 * in their middle if the stone fits in. */
static double draw_start(const pv_quarry *block, int axis, double radius, uint32_t word)
{
    int32_t size = block->size[axis], margin = 0;
    if (block->mirrors[axis] && 2 * radius < size)
        margin = (int32_t)radius;
    return margin + pv_below(word, (uint32_t)(size - 2 * margin)) - (axis == 2 ? 0 : 0.5);
}

/* Light stones have less contrast than dark ones, so that what is lighter than the mean stays under white. */
static void set_contrast(const pv_quarry *block, pv_face *face)
{
    for (int c = 0; c < 3; c++) {
        double room = 1 - face->paint[c], wanted = face->paint[c] * most_deviations * block->deviation[c];
        face->contrast[c] = wanted > room * block->mean[c] ? room * block->mean[c] / wanted : 1;
    }
}

void pv_face_draw(const pv_bed *bed, double radius, pv_laid *laid)
{
    pv_face *face = &laid->face;
    pv_random r = draw(bed, laid, PV_DRAW_FACE, 0), s = draw(bed, laid, PV_DRAW_FACE, 1);
    face->brightness = 1 + bed->params.variation * pv_signed_unit(s.word[0]);
    if (face->block < 0)
        return;
    const pv_quarry *block = &bed->block[face->block];
    draw_turn(bed, laid, block, r.word[3], face->turn);
    for (int a = 0; a < 3; a++)
        face->start[a] = draw_start(block, a, radius * bed->texels, r.word[a]);
    set_contrast(block, face);
}

/* The block's light, and by it the face's: the mean of a tinted block becomes the stone's own colour. */
static double paint(const pv_bed *bed, const pv_face *face, double light[3])
{
    const double *mean = bed->block[face->block].mean;
    double relief = pv_luminance(light) - pv_luminance(mean);
    for (int c = 0; c < 3; c++) {
        double of_mean = mean[c] < 1e-6 ? 1 : light[c] / mean[c];
        double own = face->tinted ? face->paint[c] * (1 + face->contrast[c] * (of_mean - 1)) : light[c];
        light[c] = face->brightness == 1 ? own : own * face->brightness;
    }
    return pv_clamped(relief, -1, 1);
}

static double face_at(const pv_bed *bed, const pv_laid *laid, const double at[3], double light[3])
{
    const pv_face *face = &laid->face;
    if (face->block < 0) {
        for (int c = 0; c < 3; c++)
            light[c] = face->paint[c] * face->brightness;
        return 0;
    }
    double ratio = bed->texels / bed->scale, place[3];
    const double way[3] = { (at[0] - face->anchor[0]) * ratio, (at[1] - face->anchor[1]) * ratio,
                            at[2] * bed->texels };
    for (int a = 0; a < 3; a++)
        place[a] = face->start[a] + face->turn[a][0] * way[0] + face->turn[a][1] * way[1] + face->turn[a][2] * way[2];
    pv_quarry_at(&bed->block[face->block], place, light);
    return paint(bed, face, light);
}

static void step(const pv_patch *patch, double across, double down, double out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = patch->at[a] + across * patch->across[a] + down * patch->down[a];
}

double pv_face_light(const pv_bed *bed, const pv_laid *laid, const pv_patch *patch, double light[3])
{
    int32_t n = laid->face.block < 0 ? 1 : bed->samples;
    double sum[4] = { 0, 0, 0, 0 }, part[3], at[3];
    for (int32_t i = 0; i < n * n; i++) {
        step(patch, (i % n + 0.5) / n - 0.5, (i / n + 0.5) / n - 0.5, at);
        sum[3] += face_at(bed, laid, at, part);
        for (int c = 0; c < 3; c++)
            sum[c] += part[c];
    }
    for (int c = 0; c < 3; c++)
        light[c] = n == 1 ? sum[c] : sum[c] / (n * n);
    return sum[3] / (n * n);
}

void pv_face_slope(const pv_bed *bed, const pv_laid *laid, const pv_patch *patch, double slope[2])
{
    double relief[4], light[3];
    for (int i = 0; i < 4; i++) {
        pv_patch beside = *patch;
        step(patch, i == 0 ? -1 : i == 1, i == 2 ? -1 : i == 3, beside.at);
        relief[i] = pv_face_light(bed, laid, &beside, light);
    }
    slope[0] = (relief[1] - relief[0]) / 2 * bed->relief * bed->scale;
    slope[1] = (relief[3] - relief[2]) / 2 * bed->relief * bed->scale;
}
