/* The bank: reads exemplars into sheets of values that are compared. */
#include "tiling/bank.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { JOINT_FAR = 18 /* thirds of a px */, USUAL = 70 /* deviation of three channels together */ };

/* What the sheets are made from, while they are made. */
typedef struct making {
    pave_context *context;
    const pave_image *const *exemplars;
    const pave_tiling_params *params;
    pv_bank *bank;
    int32_t channels; /* that are compared */
    double least, most;
} making;

void pv_bank_free(pv_bank *bank)
{
    pv_release(bank->values);
    pv_release(bank->usable);
    pv_release(bank->blocked);
    pv_release(bank->border);
    pv_release(bank->bright);
    pv_release(bank->home);
    pv_release(bank->cell);
    pv_release(bank->stone);
    memset(bank, 0, sizeof *bank);
}

const pv_sheet *pv_bank_sheet(const pv_bank *bank, int32_t place)
{
    int32_t low = 0, high = bank->sheets - 1;
    while (low < high) {
        int32_t middle = (low + high + 1) / 2;
        if (place >= bank->sheet[middle].first - bank->stride - 1)
            low = middle;
        else
            high = middle - 1;
    }
    return &bank->sheet[low];
}

/* Where pixel (x, y) of a sheet is in its exemplar. */
static void unturn(const pv_sheet *sheet, int32_t x, int32_t y, int32_t *ex, int32_t *ey)
{
    int32_t right = sheet->width - 1, bottom = sheet->height - 1, across = sheet->turn & 1 ? bottom : right;
    switch (sheet->turn & 3) {
    case 0: *ex = x, *ey = y; break;
    case 1: *ex = y, *ey = right - x; break;
    case 2: *ex = right - x, *ey = bottom - y; break;
    default: *ex = bottom - y, *ey = x; break;
    }
    if (sheet->turn & 4)
        *ex = across - *ex;
}

pave_source pv_bank_source(const pv_bank *bank, int32_t place)
{
    const pv_sheet *sheet = pv_bank_sheet(bank, place);
    int32_t from = place - sheet->first, ex, ey;
    unturn(sheet, from % bank->stride, from / bank->stride, &ex, &ey);
    return (pave_source){ sheet->exemplar, ex, ey, sheet->turn };
}

static pave_result check_alike(const making *m, int32_t count)
{
    const pave_image *first = m->exemplars[0];
    for (int32_t i = 0; i < count; i++) {
        const pave_image *image = m->exemplars[i];
        if (!image)
            return pv_fail(m->context, PAVE_ERR_ARGUMENT, "exemplar %d is NULL", (int)i);
        if (image->channels != first->channels || image->type != first->type || image->alpha != first->alpha ||
            image->encoding != first->encoding)
            return pv_fail(m->context, PAVE_ERR_ARGUMENT,
                           "exemplar %d has other channels, or another type or encoding, than the first", (int)i);
    }
    return PAVE_OK;
}

static int allowed(const pave_tiling_params *params, int32_t turn)
{
    return !turn || ((params->turns || !(turn & 3)) && (params->flips || !(turn & 4)));
}

/* Lays out the sheets: upright ones first. */
static pave_result place_sheets(making *m, int32_t count)
{
    pv_bank *bank = m->bank;
    int64_t rows = 0;
    for (int32_t i = 0; i < count; i++) {
        int32_t side = m->exemplars[i]->width;
        if (m->params->turns && m->exemplars[i]->height > side)
            side = m->exemplars[i]->height;
        bank->stride = side + 2 > bank->stride ? side + 2 : bank->stride;
    }
    for (int32_t turn = 0; turn < PV_TURNS; turn++)
        for (int32_t i = 0; i < count && allowed(m->params, turn); i++) {
            const pave_image *image = m->exemplars[i];
            pv_sheet *sheet = &bank->sheet[bank->sheets++];
            *sheet = (pv_sheet){ i, turn, turn & 1 ? image->height : image->width,
                                 turn & 1 ? image->width : image->height, 0 };
            int64_t first = (rows + 1) * bank->stride + 1;
            rows += sheet->height + 2;
            if (rows * bank->stride > INT32_MAX / 2)
                return pv_fail(m->context, PAVE_ERR_LIMIT, "the exemplars are beyond 2^30 pixels");
            sheet->first = (int32_t)first;
        }
    bank->pixels = (int32_t)rows * bank->stride;
    return PAVE_OK;
}

static pave_result allocate(making *m)
{
    pave_result result = PAVE_OK;
    pv_bank *bank = m->bank;
    size_t n = (size_t)bank->pixels;
    bank->values = pv_allocate_zeroed(m->context, n * (size_t)bank->depth + PV_BANK_SPARE, sizeof *bank->values,
                                      &result);
    if (!result)
        bank->usable = pv_allocate_zeroed(m->context, n, 1, &result);
    if (!result)
        bank->border = pv_allocate_zeroed(m->context, n, 1, &result);
    if (!result)
        bank->stone = pv_allocate_zeroed(m->context, n, sizeof *bank->stone, &result);
    if (!result)
        bank->blocked = pv_allocate_zeroed(m->context, n, sizeof *bank->blocked, &result);
    if (!result)
        bank->bright = pv_allocate_zeroed(m->context, n, sizeof *bank->bright, &result);
    if (!result)
        bank->home = pv_allocate_zeroed(m->context, n, sizeof *bank->home, &result);
    if (!result)
        bank->cell = pv_allocate_zeroed(m->context, n, sizeof *bank->cell, &result);
    return result;
}

static int64_t value_index(const pave_image *image, int32_t x, int32_t y, int32_t channel)
{
    return ((int64_t)y * image->width + x) * image->channels + channel;
}

static int is_usable(const making *m, const pave_image *image, int32_t x, int32_t y)
{
    for (int32_t c = 0; c < image->channels; c++)
        if (!isfinite(pv_image_value(image, value_index(image, x, y, c))))
            return 0;
    return image->alpha < 0 || pv_image_value(image, value_index(image, x, y, image->alpha)) >= m->params->opaque;
}

/* Linear light is compared by its root, which is near to how it is seen. */
static double shown(const pave_image *image, double value)
{
    return image->encoding == PAVE_LINEAR && value > 0 ? sqrt(value) : value;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The values of every so many usable pixels of an exemplar. Returns how many. */
static int32_t some_values(const making *m, const pave_image *image, int32_t most, double *values)
{
    int64_t n = (int64_t)image->width * image->height, each = n / (most / image->channels) + 1;
    int32_t count = 0;
    for (int64_t k = 0; k < n; k += each)
        for (int32_t c = 0; c < image->channels; c++)
            if (c != image->alpha && is_usable(m, image, (int32_t)(k % image->width), (int32_t)(k / image->width)))
                values[count++] = shown(image, pv_image_value(image, k * image->channels + c));
    return count;
}

/* The range of what is compared, for types without one of their own. A few values far out would leave nothing of it to
 * all others: it reaches no further than its middle part of 99 in 100 values once more to either side. */
static pave_result find_range(making *m, int32_t count)
{
    enum { MOST = 1 << 14, TAIL = 200 };
    pave_result result = PAVE_OK;
    int32_t n = 0;
    double *values = pv_allocate(m->context, (size_t)count * MOST, sizeof *values, &result);
    for (int32_t i = 0; i < count && !result; i++)
        n += some_values(m, m->exemplars[i], MOST, values + n);
    if (n) {
        qsort(values, (size_t)n, sizeof *values, ascending);
        double low = values[n / TAIL], high = values[n - 1 - n / TAIL], far = high - low;
        m->least = far > 0 ? fmax(values[0], low - far) : values[0];
        m->most = far > 0 ? fmin(values[n - 1], high + far) : values[n - 1];
    }
    pv_release(values);
    return result;
}

static int32_t compared(const making *m, const pave_image *image, int64_t index)
{
    if (image->type == PAVE_U8)
        return ((const uint8_t *)image->pixels)[index];
    double value = shown(image, pv_image_value(image, index));
    if (!(m->most > m->least))
        return 0;
    value = floor((value - m->least) / (m->most - m->least) * m->bank->white + 0.5);
    return value > 0 ? value < m->bank->white ? (int32_t)value : m->bank->white : 0;
}

static void read_pixel(const making *m, const pave_image *image, int32_t x, int32_t y, int32_t place)
{
    pv_bank *bank = m->bank;
    int32_t sum = 0, k = 0;
    bank->usable[place] = (uint8_t)is_usable(m, image, x, y);
    bank->usable_count += bank->usable[place];
    bank->all++;
    for (int32_t c = 0; c < image->channels; c++) {
        if (c == image->alpha && image->channels > 1)
            continue;
        int32_t value = bank->usable[place] ? compared(m, image, value_index(image, x, y, c)) : 0;
        bank->values[(int64_t)place * bank->depth + k++] = (int16_t)value;
        sum += value;
    }
    bank->bright[place] = (int16_t)(sum / m->channels);
    bank->home[place] = place;
}

static void read_sheet(const making *m, const pv_sheet *sheet)
{
    for (int32_t y = 0; y < sheet->height; y++)
        for (int32_t x = 0; x < sheet->width; x++)
            read_pixel(m, m->exemplars[sheet->exemplar], x, y, sheet->first + y * m->bank->stride + x);
}

/* Takes slow changes of brightness out of all channels alike. */
static pave_result flatten(const making *m, const pv_sheet *sheet)
{
    pv_bank *bank = m->bank;
    pv_grey grey = { sheet->width, sheet->height, bank->stride, bank->white, bank->bright + sheet->first };
    int32_t n = sheet->width * sheet->height, side = sheet->width < sheet->height ? sheet->width : sheet->height;
    pave_result result = PAVE_OK;
    int32_t *slow = pv_allocate(m->context, (size_t)n, sizeof *slow, &result);
    if (!result)
        result = pv_box_mean(m->context, &grey, side / 6 + 1, slow);
    int64_t mean = 0;
    for (int32_t i = 0; !result && i < n; i++)
        mean += slow[i];
    for (int32_t i = 0; !result && i < n; i++) {
        int32_t place = sheet->first + i / sheet->width * bank->stride + i % sheet->width;
        int32_t less = (int32_t)((double)(slow[i] - mean / n) * m->params->flatten);
        for (int32_t c = 0; c < m->channels; c++) {
            int16_t *v = &bank->values[(int64_t)place * bank->depth + c];
            int32_t flat = *v - less;
            *v = (int16_t)(flat < 0 ? 0 : flat > bank->white ? bank->white : flat);
        }
    }
    pv_release(slow);
    return result;
}

/* The variance of all channels of a sheet together. */
static double spread_of(const making *m, const pv_sheet *sheet, int32_t from, int32_t to)
{
    double total = 0;
    for (int32_t c = from; c < to; c++) {
        double sum = 0, squares = 0, n = (double)sheet->width * sheet->height;
        for (int32_t i = 0; i < sheet->width * sheet->height; i++) {
            int32_t place = sheet->first + i / sheet->width * m->bank->stride + i % sheet->width;
            double v = m->bank->values[(int64_t)place * m->bank->depth + c];
            sum += v, squares += v * v;
        }
        total += squares / n - sum / n * (sum / n);
    }
    return total > 0 ? total : 0;
}

/* The last value of every pixel: the distance to the joints, of a deviation 0.7 times that of the others, and more
 * where joints enclose stones. */
static void store_distance(const making *m, const pv_sheet *sheet, const pv_joints *joints)
{
    pv_bank *bank = m->bank;
    int32_t at = bank->depth - 1;
    double weight = (joints->enclose ? 1.12 : 0.7) * m->params->joints;
    for (int pass = 0; pass < 2; pass++) {
        double own = pass ? sqrt(spread_of(m, sheet, at, bank->depth)) : 0;
        double factor = own > 0 ? weight * sqrt(spread_of(m, sheet, 0, at)) / own : 8;
        for (int32_t i = 0; i < sheet->width * sheet->height; i++) {
            int32_t place = sheet->first + i / sheet->width * bank->stride + i % sheet->width;
            int32_t d = joints->distance[i];
            d = d > JOINT_FAR ? JOINT_FAR : d < -JOINT_FAR / 2 ? -JOINT_FAR / 2 : d;
            double v = bank->white / 2 + floor(d * factor + 0.5);
            bank->values[(int64_t)place * bank->depth + at] = (int16_t)(v < 0 ? 0 : v > bank->white ? bank->white : v);
        }
    }
}

/* Two stones whose insides match would grow together: to cut through them costs 12 grey levels a px of depth. */
static void store_stones(const making *m, const pv_sheet *sheet, const pv_joints *joints)
{
    double each = 12 * PV_COST_UNIT * m->params->joints / 3;
    for (int32_t i = 0; i < sheet->width * sheet->height && joints->enclose; i++) {
        int32_t place = sheet->first + i / sheet->width * m->bank->stride + i % sheet->width, d = joints->distance[i];
        d = d > JOINT_FAR ? JOINT_FAR : d < 0 ? 0 : d;
        m->bank->stone[place] = (int16_t)fmin(d * each, INT16_MAX);
    }
}

static pave_result find_joints(const making *m, const pv_sheet *sheet, double *feature)
{
    pv_bank *bank = m->bank;
    pv_grey grey = { sheet->width, sheet->height, bank->stride, bank->white, bank->bright + sheet->first };
    pv_joints joints = { 0 };
    pave_result result = pv_joints_find(m->context, &grey, &joints);
    if (!result && bank->depth > m->channels) {
        store_distance(m, sheet, &joints);
        store_stones(m, sheet, &joints);
    }
    *feature = joints.feature;
    pv_joints_free(&joints);
    return result;
}

static void copy_place(pv_bank *bank, int32_t from, int32_t to)
{
    memcpy(bank->values + (int64_t)to * bank->depth, bank->values + (int64_t)from * bank->depth,
           (size_t)bank->depth * sizeof *bank->values);
    bank->bright[to] = bank->bright[from];
    bank->stone[to] = bank->stone[from];
    bank->home[to] = bank->home[from];
}

static void turn_sheet(pv_bank *bank, const pv_sheet *sheet)
{
    const pv_sheet *upright = &bank->sheet[sheet->exemplar];
    for (int32_t y = 0; y < sheet->height && sheet->turn; y++)
        for (int32_t x = 0; x < sheet->width; x++) {
            int32_t ex, ey, to = sheet->first + y * bank->stride + x;
            unturn(sheet, x, y, &ex, &ey);
            int32_t from = upright->first + ey * bank->stride + ex;
            copy_place(bank, from, to);
            bank->usable[to] = bank->usable[from];
        }
}

static void close_border(pv_bank *bank, const pv_sheet *sheet)
{
    for (int32_t y = -1; y <= sheet->height; y++)
        for (int32_t x = -1; x <= sheet->width; x += y < 0 || y == sheet->height ? 1 : sheet->width + 1) {
            int32_t u = x < 0 ? 0 : x < sheet->width ? x : sheet->width - 1;
            int32_t v = y < 0 ? 0 : y < sheet->height ? y : sheet->height - 1;
            int32_t to = sheet->first + y * bank->stride + x;
            copy_place(bank, sheet->first + v * bank->stride + u, to);
            bank->border[to] = 1;
        }
}

/* Cells are numbered sheet by sheet, row by row. */
static void number_cells(pv_bank *bank, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        const pv_sheet *sheet = &bank->sheet[i];
        int32_t across = (sheet->width + PV_CELL - 1) / PV_CELL;
        for (int32_t k = 0; k < sheet->width * sheet->height; k++) {
            int32_t x = k % sheet->width, y = k / sheet->width;
            bank->cell[sheet->first + y * bank->stride + x] = bank->cells + y / PV_CELL * across + x / PV_CELL;
        }
        bank->cells += across * ((sheet->height + PV_CELL - 1) / PV_CELL);
    }
    for (int32_t i = 0; i < bank->pixels; i++)
        bank->cell[i] = bank->cell[bank->home[i]];
}

static void count_blocked(pv_bank *bank)
{
    for (int32_t y = 0, row = 0; y < bank->pixels / bank->stride; y++, row = 0)
        for (int32_t x = 0; x < bank->stride; x++) {
            int32_t place = y * bank->stride + x;
            row += !bank->usable[place];
            bank->blocked[place] = row + (y ? bank->blocked[place - bank->stride] : 0);
        }
}

static pave_result fill(making *m, int32_t count)
{
    pv_bank *bank = m->bank;
    pave_result result = PAVE_OK;
    int paper = m->params->mode == PAVE_TILING_PAPER;
    for (int32_t i = 0; i < count && !result; i++) {
        double feature = 0;
        read_sheet(m, &bank->sheet[i]);
        double deviation = 255 * sqrt(spread_of(m, &bank->sheet[i], 0, m->channels) * 3 / m->channels) / bank->white;
        bank->contrast += fmin(fmax(deviation / USUAL, 0.1), 4) / count;
        result = find_joints(m, &bank->sheet[i], &feature);
        if (!result && !paper && m->params->flatten > 0)
            result = flatten(m, &bank->sheet[i]);
        bank->feature = feature > bank->feature ? feature : bank->feature;
        if (!result)
            result = pv_progress(m->context, 0);
    }
    for (int32_t i = 0; i < bank->sheets && !result; i++) {
        turn_sheet(bank, &bank->sheet[i]);
        close_border(bank, &bank->sheet[i]);
    }
    count_blocked(bank);
    number_cells(bank, count);
    if (!result && !bank->usable_count)
        return pv_fail(m->context, PAVE_ERR_ARGUMENT, "the exemplar has no usable pixel: all are transparent (see "
                       "opaque) or not finite");
    return result;
}

static int is_plain(const pv_bank *bank, int32_t count)
{
    size_t bytes = (size_t)bank->depth * sizeof *bank->values;
    for (int32_t i = 0; i < count; i++)
        for (int32_t k = 0; k < bank->sheet[i].width * bank->sheet[i].height; k++) {
            int32_t place = bank->sheet[i].first + k / bank->sheet[i].width * bank->stride + k % bank->sheet[i].width;
            if (!bank->usable[place] || memcmp(bank->values + (int64_t)place * bank->depth,
                                               bank->values + (int64_t)bank->sheet[0].first * bank->depth, bytes))
                return 0;
        }
    return 1;
}

pave_result pv_bank_create(pave_context *context, const pave_image *const *exemplars, int32_t count,
                           const pave_tiling_params *params, pv_bank *out)
{
    memset(out, 0, sizeof *out);
    making m = { context, exemplars, params, out, 0, 0, 0 };
    pave_result result = check_alike(&m, count);
    if (result)
        return result;
    m.channels = exemplars[0]->channels - (exemplars[0]->alpha >= 0 && exemplars[0]->channels > 1);
    out->white = exemplars[0]->type == PAVE_U8 ? 255 : 4095;
    out->depth = m.channels + (params->mode != PAVE_TILING_PAPER && params->joints > 0);
    if (exemplars[0]->type != PAVE_U8)
        result = find_range(&m, count);
    if (!result)
        result = place_sheets(&m, count);
    if (!result)
        result = allocate(&m);
    if (!result)
        result = fill(&m, count);
    if (!result)
        out->plain = is_plain(out, count);
    if (result)
        pv_bank_free(out);
    return result;
}
