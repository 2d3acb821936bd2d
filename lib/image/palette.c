/* The colours of a drawing, found: a histogram, and k-means on its bins in OKLab. */
#include "image/palette.h"

#include "base/params.h"
#include "util/fixed.h"

#include <stdlib.h>
#include <string.h>

static const pave_palette_params default_params = PAVE_PALETTE_PARAMS_INIT;

static const pv_param palette_rows[] = {
    PV_INTEGER(pave_palette_params, colours, "", 0, 256, "find so many colours in the drawing; 0: black and white"),
    { "palette", PAVE_PARAM_PALETTE, "", 0, 256, NULL, "or lay it in these: #rrggbb,#rrggbb..., or a file of them",
      offsetof(pave_palette_params, palette) },
};

const pv_table pv_palette_table = PV_TABLE("palette", default_params, palette_rows);

void pave_palette_params_init(pave_palette_params *params, size_t size)
{
    pv_params_init(&pv_palette_table, params, size);
}

/* Bins of 8 x 8 x 8 colours, made when first needed. */
enum { BINS = 32 * 32 * 32, COLOURS = 512, CLOSE = 330 /* 0.02: hardly to be told apart */, ROUNDS = 64 };

struct pv_histogram {
    uint32_t *bin[BINS]; /* of COLOURS counts */
};

static int32_t bin_of(pv_rgb c)
{
    return c.r >> 3 << 10 | c.g >> 3 << 5 | c.b >> 3;
}

static int32_t place_of(pv_rgb c)
{
    return (c.r & 7) << 6 | (c.g & 7) << 3 | (c.b & 7);
}

static pv_rgb colour_of(int32_t bin, int32_t place)
{
    return (pv_rgb){ (uint8_t)(bin >> 10 << 3 | place >> 6), (uint8_t)((bin >> 5 & 31) << 3 | (place >> 3 & 7)),
                     (uint8_t)((bin & 31) << 3 | (place & 7)) };
}

pave_result pv_histogram_create(pave_context *context, pv_histogram **out)
{
    pave_result result = PAVE_OK;
    *out = pv_allocate_zeroed(context, 1, sizeof **out, &result);
    return result;
}

void pv_histogram_free(pv_histogram *histogram)
{
    for (int32_t i = 0; histogram && i < BINS; i++)
        pv_release(histogram->bin[i]);
    pv_release(histogram);
}

pave_result pv_histogram_add(pave_context *context, pv_histogram *histogram, const pave_image *image)
{
    pv_pixels_of pixels = pv_pixels_begin(image);
    int64_t count = (int64_t)image->width * image->height;
    pave_result result = PAVE_OK;
    for (int64_t i = 0; i < count && !result; i++) {
        pv_rgb c = pv_pixel_rgb(&pixels, i);
        uint32_t **bin = &histogram->bin[bin_of(c)];
        if (!*bin)
            *bin = pv_allocate_zeroed(context, COLOURS, sizeof **bin, &result);
        if (*bin && (*bin)[place_of(c)] < UINT32_MAX)
            (*bin)[place_of(c)]++;
        if (i % (1 << 20) == 0 && !result)
            result = pv_progress(context, (double)i / (double)count);
    }
    return result;
}

/* Colours taken together: how many pixels, and sums over them. */
typedef struct colours {
    int64_t pixels;
    int64_t light[3];
    int64_t l, a, b;
    int64_t most; /* pixels of the most frequent colour, */
    pv_rgb peak;  /* which is this one */
} colours;

static void add_colour(const pv_oklab *tables, pv_rgb c, int64_t pixels, colours *sum)
{
    pv_lab lab = pv_oklab_of(tables, c);
    sum->pixels += pixels;
    sum->light[0] += pixels * tables->light[c.r];
    sum->light[1] += pixels * tables->light[c.g];
    sum->light[2] += pixels * tables->light[c.b];
    sum->l += pixels * lab.l;
    sum->a += pixels * lab.a;
    sum->b += pixels * lab.b;
    if (pixels > sum->most)
        sum->most = pixels, sum->peak = c;
}

static pv_lab mean_of(const colours *sum)
{
    int64_t n = sum->pixels ? sum->pixels : 1;
    return (pv_lab){ (int32_t)pv_floor_div(sum->l, n), (int32_t)pv_floor_div(sum->a, n),
                     (int32_t)pv_floor_div(sum->b, n) };
}

/* What k-means works on. */
typedef struct clustering {
    const pv_histogram *histogram;
    pv_oklab tables;
    int32_t bins, clusters;
    int32_t number[BINS]; /* of a bin that is not empty, */
    colours sum[BINS];    /* its pixels, */
    pv_lab mean[BINS];
    int32_t cluster[BINS]; /* and whose it is */
    pv_lab centre[256];
} clustering;

static void sum_bins(clustering *k)
{
    for (int32_t i = 0; i < BINS; i++) {
        const uint32_t *bin = k->histogram->bin[i];
        if (!bin)
            continue;
        k->number[k->bins] = i;
        for (int32_t j = 0; j < COLOURS; j++)
            if (bin[j])
                add_colour(&k->tables, colour_of(i, j), bin[j], &k->sum[k->bins]);
        k->mean[k->bins] = mean_of(&k->sum[k->bins]);
        k->bins++;
    }
}

/* The first centre is the most frequent colour; each further one the colour that is most missed, by how often it comes
 * and how far it is from all before. */
static int32_t most_missed(const clustering *k, const int64_t *distance)
{
    int32_t best = 0;
    double most = -1;
    for (int32_t i = 0; i < k->bins; i++) {
        double missed = (double)k->sum[i].most * (double)distance[i];
        if (missed > most)
            most = missed, best = i;
    }
    return most > 0 ? best : -1;
}

static pave_result choose_centres(pave_context *context, clustering *k, int32_t wanted)
{
    pave_result result = PAVE_OK;
    int64_t *distance = pv_allocate(context, (size_t)k->bins, sizeof *distance, &result);
    for (int32_t i = 0; i < k->bins && distance; i++)
        distance[i] = 1;
    while (distance && k->clusters < wanted) {
        int32_t next = most_missed(k, distance);
        if (next < 0)
            break;
        pv_lab centre = k->centre[k->clusters++] = pv_oklab_of(&k->tables, k->sum[next].peak);
        for (int32_t i = 0; i < k->bins; i++) {
            int64_t d = pv_lab_distance(k->mean[i], centre);
            distance[i] = k->clusters == 1 || d < distance[i] ? d : distance[i];
        }
        distance[next] = 0;
    }
    pv_release(distance);
    return result;
}

/* Gives every bin to its nearest centre; the lower one among equals. */
static int32_t assign(clustering *k)
{
    int32_t changes = 0;
    for (int32_t i = 0; i < k->bins; i++) {
        int64_t least = INT64_MAX;
        int32_t best = 0;
        for (int32_t c = 0; c < k->clusters; c++) {
            int64_t d = pv_lab_distance(k->mean[i], k->centre[c]);
            if (d < least)
                least = d, best = c;
        }
        changes += k->cluster[i] != best;
        k->cluster[i] = best;
    }
    return changes;
}

static void add_all(colours *sum, const colours *part)
{
    sum->pixels += part->pixels;
    for (int c = 0; c < 3; c++)
        sum->light[c] += part->light[c];
    sum->l += part->l;
    sum->a += part->a;
    sum->b += part->b;
    if (part->most > sum->most)
        sum->most = part->most, sum->peak = part->peak;
}

/* An empty cluster keeps its centre. */
static void move_centres(clustering *k, colours *sums)
{
    memset(sums, 0, 256 * sizeof *sums);
    for (int32_t i = 0; i < k->bins; i++)
        add_all(&sums[k->cluster[i]], &k->sum[i]);
    for (int32_t c = 0; c < k->clusters; c++)
        if (sums[c].pixels)
            k->centre[c] = mean_of(&sums[c]);
}

static pave_result cluster(pave_context *context, clustering *k, colours *sums)
{
    pave_result result = PAVE_OK;
    memset(k->cluster, -1, sizeof k->cluster);
    for (int32_t round = 0; round < ROUNDS && !result && assign(k); round++) {
        move_centres(k, sums);
        result = pv_progress(context, 0.9);
    }
    return result;
}

/* Those of a cluster's colours that are close to its most frequent one. */
static colours close_to_peak(const clustering *k, int32_t cluster_number, pv_rgb peak)
{
    colours sum = { 0 };
    pv_lab centre = pv_oklab_of(&k->tables, peak);
    for (int32_t i = 0; i < k->bins; i++) {
        const uint32_t *bin = k->histogram->bin[k->number[i]];
        for (int32_t j = 0; j < COLOURS && k->cluster[i] == cluster_number; j++) {
            pv_rgb c = colour_of(k->number[i], j);
            if (bin[j] && pv_lab_distance(pv_oklab_of(&k->tables, c), centre) <= CLOSE * CLOSE)
                add_colour(&k->tables, c, bin[j], &sum);
        }
    }
    return sum;
}

static pv_rgb mean_light(const pv_oklab *tables, const colours *sum)
{
    return (pv_rgb){ pv_display_of(tables, sum->light[0] / sum->pixels),
                     pv_display_of(tables, sum->light[1] / sum->pixels),
                     pv_display_of(tables, sum->light[2] / sum->pixels) };
}

static pv_rgb entry_of(const clustering *k, int32_t cluster_number, const colours *all)
{
    if (2 * all->most >= all->pixels)
        return all->peak;
    colours close = close_to_peak(k, cluster_number, all->peak);
    return mean_light(&k->tables, 2 * close.pixels >= all->pixels ? &close : all);
}

/* An entry with what it is put in order by. */
typedef struct entry {
    pv_lab lab;
    pv_rgb colour;
} entry;

static int by_light(const void *a, const void *b)
{
    const entry *p = a, *q = b;
    int32_t p_keys[3] = { p->lab.l, p->lab.a, p->lab.b }, q_keys[3] = { q->lab.l, q->lab.a, q->lab.b };
    for (int i = 0; i < 3; i++)
        if (p_keys[i] != q_keys[i])
            return (p_keys[i] > q_keys[i]) - (p_keys[i] < q_keys[i]);
    return memcmp(&p->colour, &q->colour, sizeof p->colour);
}

static void list_entries(const clustering *k, const colours *sums, pave_palette *out)
{
    entry entries[256];
    int32_t count = 0;
    memset(out, 0, sizeof *out);
    for (int32_t c = 0; c < k->clusters; c++) {
        if (!sums[c].pixels)
            continue;
        pv_rgb colour = entry_of(k, c, &sums[c]);
        entries[count++] = (entry){ pv_oklab_of(&k->tables, colour), colour };
    }
    qsort(entries, (size_t)count, sizeof *entries, by_light);
    for (int32_t i = 0; i < count; i++)
        if (!i || memcmp(&entries[i].colour, &entries[i - 1].colour, sizeof(pv_rgb)))
            memcpy(out->rgb + 3 * out->count++, &entries[i].colour, 3);
}

pave_result pv_histogram_palette(pave_context *context, const pv_histogram *histogram, int32_t wanted,
                                 pave_palette *out)
{
    pave_result result = PAVE_OK;
    clustering *k = pv_allocate_zeroed(context, 1, sizeof *k, &result);
    colours *sums = result ? NULL : pv_allocate_zeroed(context, 256, sizeof *sums, &result);
    if (!result) {
        k->histogram = histogram;
        pv_oklab_begin(&k->tables);
        sum_bins(k);
        result = choose_centres(context, k, wanted);
    }
    if (!result)
        result = cluster(context, k, sums);
    if (!result)
        list_entries(k, sums, out);
    pv_release(sums);
    pv_release(k);
    return result;
}

pave_result pave_palette_find(pave_context *context, const pave_image *image, int32_t wanted, pave_palette *out)
{
    if (out)
        memset(out, 0, sizeof *out);
    if (!context || !image || !out)
        return PAVE_ERR_ARGUMENT;
    if (wanted < 2 || wanted > 256)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "colours is %d, but must be 2 .. 256", (int)wanted);
    pv_histogram *histogram = NULL;
    pv_call call = pv_call_begin(context, "palette", 0, 1);
    pave_result result = pv_histogram_create(context, &histogram);
    if (!result)
        result = pv_histogram_add(context, histogram, image);
    if (!result)
        result = pv_histogram_palette(context, histogram, wanted, out);
    pv_histogram_free(histogram);
    pv_call_end(context, call);
    return result;
}
