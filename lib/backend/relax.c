/* One site's move: centroid, push off the edge, turn. Integers only, so that every backend moves it alike. */
#include "backend/relax.h"

#include "util/fixed.h"
#include "util/noise.h"
#include "util/random.h"

static int32_t clamp(int32_t v, int32_t low, int32_t high)
{
    return v < low ? low : v < high ? v : high;
}

static int32_t edge_at(const pv_plane *plane, int32_t x, int32_t y)
{
    x = clamp(x, 0, plane->width - 1);
    y = clamp(y, 0, plane->height - 1);
    return plane->edge[(int64_t)y * plane->width + x];
}

static int32_t across(const pv_plane *plane)
{
    return (plane->width + PV_NEAR - 1) / PV_NEAR;
}

/* Is some pixel of the square around near an edge? The squares fit a cache, and the edges of a large plane do not. */
static inline int may_be_near(const pv_plane *plane, int32_t px, int32_t py)
{
    return plane->edge && !plane->direction &&
           (!plane->near || plane->near[(int64_t)(py / PV_NEAR) * across(plane) + px / PV_NEAR]);
}

static int any_below(const uint16_t *edge, int64_t stride, int32_t columns, int32_t rows, int32_t limit)
{
    int any = 0;
    for (int32_t y = 0; y < rows; y++, edge += stride)
        for (int32_t x = 0; x < columns; x++)
            any |= edge[x] < limit;
    return any;
}

void pv_near_row(const pv_plane *plane, int32_t row, uint8_t *near)
{
    int32_t y = row * PV_NEAR, rows = y + PV_NEAR < plane->height ? PV_NEAR : plane->height - y;
    int32_t limit = (int32_t)pv_ceil_div(plane->push_within, 1 << plane->edge_shift);
    const uint16_t *edge = plane->edge + (int64_t)y * plane->width;
    for (int32_t x = 0; x < plane->width; x += PV_NEAR) {
        int32_t columns = x + PV_NEAR < plane->width ? PV_NEAR : plane->width - x;
        near[x / PV_NEAR] = (uint8_t)any_below(edge + x, plane->width, columns, rows, limit);
    }
}

void pv_site_prefetch(const pv_plane *plane, const pave_site *site)
{
    int32_t px = site->x >> 8, py = site->y >> 8;
    if (!may_be_near(plane, px, py))
        return;
    for (int32_t y = py - 1; y <= py + 1; y++)
        __builtin_prefetch(&plane->edge[(int64_t)clamp(y, 0, plane->height - 1) * plane->width + px]);
}

typedef struct edge_near {
    int32_t distance; /* 1/256 px */
    int32_t nx, ny;   /* unit gradient, away from the edge, 1/65536 */
} edge_near;

static int32_t divide_rounded(int64_t a, int64_t b)
{
    return (int32_t)(a < 0 ? -((b / 2 - a) / b) : (b / 2 + a) / b);
}

/* Scales a vector below 2^20 to 65536, correctly rounded but for the last bit. 0 if it has no direction. */
static int normalise(int64_t x, int64_t y, int32_t *nx, int32_t *ny)
{
    if (!x && !y)
        return 0;
    int32_t lacking = __builtin_clzll((uint64_t)(x * x + y * y)) - 27; /* bits, to 2^36 */
    int64_t scale = (int64_t)1 << (lacking > 0 ? (lacking + 1) / 2 : 0);
    x *= scale;
    y *= scale;
    int64_t length = pv_isqrt((uint64_t)(x * x + y * y) << 22); /* 1/2048 */
    *nx = divide_rounded(x * (1 << 27), length);
    *ny = divide_rounded(y * (1 << 27), length);
    return 1;
}

/* Is (x, y) within push_within of an edge, and how does the distance change there? Sobel, normalised. */
static int near_edge(const pv_plane *plane, int32_t x, int32_t y, edge_near *out)
{
    int32_t px = x >> 8, py = y >> 8;
    if (!may_be_near(plane, px, py))
        return 0;
    out->distance = edge_at(plane, px, py) << plane->edge_shift;
    if (out->distance >= plane->push_within)
        return 0;
    int32_t nw = edge_at(plane, px - 1, py - 1), n = edge_at(plane, px, py - 1), ne = edge_at(plane, px + 1, py - 1);
    int32_t w = edge_at(plane, px - 1, py), e = edge_at(plane, px + 1, py);
    int32_t sw = edge_at(plane, px - 1, py + 1), s = edge_at(plane, px, py + 1), se = edge_at(plane, px + 1, py + 1);
    int64_t gx = (ne - nw) + 2 * (e - w) + (se - sw), gy = (sw - nw) + 2 * (s - n) + (se - ne);
    return normalise(gx, gy, &out->nx, &out->ny);
}

/* Eq. 3: a quarter turn from the gradient */
static void turn_by_edge(const edge_near *edge, pave_site *site)
{
    site->cosine = edge->ny;
    site->sine = -edge->nx;
}

/* Away from edges a site is turned by the noise, or everywhere by the directions that were given. */
void pv_site_turn_by_noise(const pv_plane *plane, pv_noise_cell *cell, pave_site *site)
{
    if (plane->direction) {
        int32_t x = clamp(site->x >> 8, 0, plane->width - 1), y = clamp(site->y >> 8, 0, plane->height - 1);
        pv_turn(plane->direction[(int64_t)y * plane->width + x], &site->cosine, &site->sine);
        return;
    }
    pv_lattice across = pv_lattice_of(plane->noise_wave, plane->period_x);
    pv_lattice down = pv_lattice_of(plane->noise_wave, plane->period_y);
    int64_t noise = pv_noise(cell, plane->noise_key, &across, &down, site->x + plane->origin_x,
                             site->y + plane->origin_y);
    pv_turn((int32_t)(noise * plane->noise_swing >> 16), &site->cosine, &site->sine);
}

void pv_site_turn(const pv_plane *plane, pave_site *site)
{
    edge_near edge;
    pv_noise_cell cell = { .known = 0 };
    if (near_edge(plane, site->x, site->y, &edge))
        turn_by_edge(&edge, site);
    else
        pv_site_turn_by_noise(plane, &cell, site);
}

static int32_t mean(int64_t sum, int64_t count)
{
    return (int32_t)(128 + pv_floor_div(256 * sum + count / 2, count));
}

/* Another place in the same cell. */
static int32_t elsewhere(int32_t place, int32_t origin, pv_lattice lattice, uint32_t word)
{
    int32_t at = pv_lattice_place(&lattice, place + origin), cell = pv_lattice_cell(&lattice, at);
    int32_t start = (int32_t)pv_lattice_start(&lattice, cell), end = (int32_t)pv_lattice_start(&lattice, cell + 1);
    return place - at + start + (int32_t)pv_below(word, (uint32_t)(end - start));
}

/* An empty cell lies under the boxes of its neighbours; a new place at random in the lattice cell where the site lies
 * gets it out. */
static void revive(const pv_plane *plane, int32_t index, int32_t iteration, pave_site *site)
{
    const pv_home *home = &plane->home[index];
    pv_random r = pv_draw(plane->seed, PV_DRAW_REVIVE, (uint32_t)home->x, (uint32_t)home->y,
                          (uint32_t)(iteration * 64 + home->slot));
    site->x = elsewhere(site->x, plane->origin_x, pv_lattice_of(plane->cell, plane->period_x), r.word[0]);
    site->y = elsewhere(site->y, plane->origin_y, pv_lattice_of(plane->cell, plane->period_y), r.word[1]);
}

static int32_t beyond(int32_t place, int32_t origin, pv_lattice lattice, int32_t cell)
{
    int64_t at = (int64_t)place + origin, start = pv_lattice_start(&lattice, cell);
    int64_t end = pv_lattice_start(&lattice, cell + 1);
    return (int32_t)(at < start ? start - at : at > end ? at - end : 0);
}

int32_t pv_site_stray(const pv_plane *plane, int32_t index, const pave_site *site)
{
    const pv_home *home = &plane->home[index];
    int32_t x = beyond(site->x, plane->origin_x, pv_lattice_of(plane->cell, plane->period_x), home->x);
    int32_t y = beyond(site->y, plane->origin_y, pv_lattice_of(plane->cell, plane->period_y), home->y);
    return x > y ? x : y;
}

void pv_site_copy(const pv_plane *plane, int32_t index, pave_site *sites)
{
    const pv_home *home = &plane->home[index];
    pave_site *site = &sites[index];
    *site = sites[home->original - 1];
    site->x = clamp(site->x + home->x, 0, 256 * plane->width - 1);
    site->y = clamp(site->y + home->y, 0, 256 * plane->height - 1);
}

/* So far beyond the centroid as the relaxation says, or short of it; windows rely on the bound. */
static int32_t past_centroid(const pv_plane *plane, int32_t from, int32_t centroid)
{
    int64_t way = ((int64_t)plane->excess * (centroid - from) + 32768) >> 16;
    return centroid + clamp((int32_t)way, -plane->cell, plane->cell);
}

int pv_site_relax(const pv_plane *plane, int32_t index, int32_t iteration, const pv_sum *sum, pave_site *site)
{
    if (sum->count) {
        site->x = past_centroid(plane, site->x, mean(sum->x, sum->count));
        site->y = past_centroid(plane, site->y, mean(sum->y, sum->count));
    } else {
        revive(plane, index, iteration, site);
    }
    int32_t right = 256 * plane->width - 1, bottom = 256 * plane->height - 1;
    site->x = clamp(site->x, 0, right);
    site->y = clamp(site->y, 0, bottom);
    edge_near edge;
    if (!near_edge(plane, site->x, site->y, &edge))
        return 1;
    int64_t way = plane->push_to - edge.distance;
    site->x = clamp(site->x + (int32_t)((way * edge.nx + 32768) >> 16), 0, right);
    site->y = clamp(site->y + (int32_t)((way * edge.ny + 32768) >> 16), 0, bottom);
    turn_by_edge(&edge, site);
    return 0;
}
