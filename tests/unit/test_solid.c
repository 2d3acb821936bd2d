/* Digital stones: same bytes on any number of threads, measurements kept, meshes filled, files read back, bad input. */
#include "failing.h"

#include "solid/bank.h"
#include "solid/grow.h"

#include <math.h>
#include <unistd.h>

enum { SAMPLE = THREAD_SANITIZED ? 28 : 48 };

/* Discs of two greys on black: grains some voxels wide. */
static uint8_t disc_value(int32_t x, int32_t y)
{
    int32_t cx = x / 8, cy = y / 8, dx = x - (8 * cx + 3 + cy % 2), dy = y - (8 * cy + 4 - cx % 2);
    uint32_t h = (uint32_t)(cx * 7 + cy * 13) * 2654435761u >> 28;
    return dx * dx + dy * dy <= 6 + (int32_t)h % 6 ? (h & 1 ? 255 : 160) : 0;
}

static pave_image *make_sample(pave_context *context, int32_t channels, int32_t type)
{
    pave_image_params p = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    uint8_t bytes[SAMPLE * SAMPLE * 3];
    uint16_t words[SAMPLE * SAMPLE * 3];
    p.width = p.height = SAMPLE;
    p.channels = channels;
    p.type = type;
    for (int32_t i = 0; i < SAMPLE * SAMPLE * channels; i++) {
        int32_t x = i / channels % SAMPLE, y = i / channels / SAMPLE;
        bytes[i] = disc_value(x, y);
        words[i] = (uint16_t)(bytes[i] * 200 + i % 97 * (i % channels + 1));
        if (channels > 1)
            bytes[i] = (uint8_t)(bytes[i] / (i % channels + 1) + x % 3);
    }
    assert_ok(pave_image_create(context, &p, type == PAVE_U8 ? (void *)bytes : (void *)words, &image));
    return image;
}

static pave_solid_params small(int32_t mode)
{
    pave_solid_params p = PAVE_SOLID_PARAMS_INIT;
    p.mode = mode;
    p.width = 18, p.height = 16, p.depth = 17;
    p.seeds = 5;
    return p;
}

static pave_volume *make(pave_context *context, const pave_image *sample, const pave_solid_params *params)
{
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    pave_volume *volume = NULL;
    in.exemplar[0] = sample;
    assert_ok(pave_solid_create(context, &in, params, &volume));
    return volume;
}

static size_t voxels(const pave_volume *v)
{
    return (size_t)pave_volume_width(v) * (size_t)pave_volume_height(v) * (size_t)pave_volume_depth(v);
}

static uint64_t hash_volume(const pave_volume *v)
{
    size_t bytes = pave_volume_type(v) == PAVE_U8 ? 1 : pave_volume_type(v) == PAVE_U16 ? 2 : 4;
    return hash_bytes(pave_volume_values(v), voxels(v) * (size_t)pave_volume_channels(v) * bytes);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    for (int32_t mode = PAVE_SOLID_PAPER; mode <= PAVE_SOLID_FAST; mode++) {
        uint64_t hash[4];
        for (int i = 0; i < 4; i++) {
            static const int32_t threads[] = { 1, 2, 7, 2 };
            pave_context *c = make_context(threads[i], i == 3 ? PAVE_BACKEND_CPU_PORTABLE : PAVE_BACKEND_CPU);
            pave_image *sample = make_sample(c, 1, PAVE_U8);
            pave_solid_params p = small(mode);
            if (THREAD_SANITIZED)
                p.width = p.height = p.depth = 10;
            pave_volume *v = make(c, sample, &p);
            hash[i] = hash_volume(v);
            pave_volume_free(&v);
            p.seed = 2;
            v = i ? NULL : make(c, sample, &p);
            assert_true(i || hash_volume(v) != hash[i]);
            pave_volume_free(&v);
            pave_image_free(&sample);
            pave_context_free(&c);
        }
        assert_true(hash[0] == hash[1] && hash[1] == hash[2] && hash[2] == hash[3]);
    }
}

static int is_outer(int32_t x, int32_t size)
{
    return x < 2 || x >= size - 2;
}

/* How much of the outermost two layers, and of all else, is background. */
static void measure_layers(const pave_volume *v, double share[2])
{
    const uint8_t *values = pave_volume_values(v);
    int32_t w = pave_volume_width(v), h = pave_volume_height(v), d = pave_volume_depth(v), count[2][2] = { { 0 } };
    for (int32_t i = 0; i < w * h * d; i++)
        count[is_outer(i % w, w) || is_outer(i / w % h, h) || is_outer(i / w / h, d)][values[i] == 0]++;
    for (int i = 0; i < 2; i++)
        share[i] = (double)count[i][1] / (count[i][0] + count[i][1]);
}

/* What is hard to place must not gather where fewer neighbours have a say. */
static void the_surface_is_as_the_inside(void **state)
{
    double wanted = 0, share[2];
    pave_context *c = *state;
    pave_image *sample = make_sample(c, 1, PAVE_U8);
    pave_solid_params p = PAVE_SOLID_PARAMS_INIT;
    if (THREAD_SANITIZED)
        skip(); /* slow, and nothing new to it */
    for (int32_t i = 0; i < SAMPLE * SAMPLE; i++)
        wanted += disc_value(i % SAMPLE, i / SAMPLE) == 0 ? 1.0 / (SAMPLE * SAMPLE) : 0;
    p.width = p.height = p.depth = 24;
    p.seed = 2;
    pave_volume *v = make(c, sample, &p);
    measure_layers(v, share);
    assert_true(fabs(share[0] - wanted) < 0.015 && fabs(share[1] - wanted) < 0.015);
    pave_volume_free(&v);
    pave_image_free(&sample);
}

/* The compute shaders, where there is a device: every mode, measurements, colours, layers, a period. */
static void a_device_makes_the_same(void **state)
{
    (void)state;
    if (SANITIZED)
        skip(); /* drivers leak, and lock as they like */
    for (int k = 0; k < 6; k++) {
        uint64_t hash[2];
        for (int device = 0; device < 2; device++) {
            pave_context *c = make_context(2, device ? PAVE_BACKEND_VULKAN_COMPUTE : PAVE_BACKEND_CPU);
            pave_image *sample = make_sample(c, k == 3 ? 3 : 1, k == 4 ? PAVE_U16 : PAVE_U8);
            pave_solid_params p = small(k < 3 ? k : PAVE_SOLID_BEST);
            const double points[] = { 3, 4, 5, 6, 7, 2 }, values[] = { 255, 160 };
            pave_solid_input in = PAVE_SOLID_INPUT_INIT;
            pave_volume *v = NULL;
            p.width = 9, p.height = 8, p.depth = 7;
            p.periodic = k == 5;
            in.point_count = k < 3 ? 2 : 0, in.points = points, in.point_values = values;
            in.exemplar[0] = sample;
            in.exemplar[1] = in.exemplar[2] = k == 4 ? sample : NULL;
            pave_result result = pave_solid_create(c, &in, &p, &v);
            if (device && (result == PAVE_ERR_DEVICE || result == PAVE_ERR_UNSUPPORTED)) {
                print_message("skipped: %s\n", pave_context_message(c));
                k = 6;
            } else
                assert_ok(result);
            hash[device] = v ? hash_volume(v) : hash[0];
            pave_volume_free(&v);
            pave_image_free(&sample);
            pave_context_free(&c);
        }
        assert_true(hash[0] == hash[1]);
    }
}

static void windows_of_equal_distance_agree(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pv_windows bank;
    uint8_t values[SAMPLE * SAMPLE];
    for (int32_t i = 0; i < SAMPLE * SAMPLE; i++)
        values[i] = (uint8_t)(i * i * 31 >> 5);
    pv_texels texels = { SAMPLE, SAMPLE, 1, values, values };
    assert_ok(pv_windows_create(context, &texels, 7, 1.5, 1, 1, 1, &bank));
    for (int32_t i = 0; i < bank.inner_count; i += 97) {
        const int16_t *patch = bank.patch + (size_t)bank.inner[i] * (size_t)bank.window.stride;
        static const int16_t all_ones = 1;
        int16_t *presence = NULL;
        assert_int_equal(posix_memalign((void **)&presence, 64, (size_t)bank.window.stride * sizeof *presence), 0);
        for (int32_t k = 0; k < bank.window.stride; k++)
            presence[k] = (int16_t)(k % 5 == 0 ? 4 : all_ones);
        int32_t a[3], b[3];
        const int32_t positions[3] = { bank.inner[0], bank.inner[i], bank.inner[bank.inner_count - 1] };
        pv_distances_choose(0)(&bank, patch, presence, positions, 3, a);
        pv_distances_choose(1)(&bank, patch, presence, positions, 3, b);
        assert_memory_equal(a, b, sizeof a);
        assert_int_equal(a[1], 0);
        assert_true(a[0] >= 0 && a[2] >= 0);
        free(presence);
    }
    for (int32_t p = 0; p < bank.positions; p++) /* the lists hold neighbourhoods that differ, the nearest first */
        for (int k = 0; k < PV_NEAREST && bank.inside[p]; k++)
            assert_true(bank.nearest[p * PV_NEAREST + k] != p);
    pv_windows_free(&bank);
}

/* Every voxel's level is above those of all that it sees before it, and cells are Voronoi cells of a box. */
static void a_flood_keeps_its_order(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pv_grid grid;
    pv_flood flood;
    const int32_t size[3] = { 15, 11, 13 };
    assert_ok(pv_grid_create(context, size, 0, 2, 1, &grid));
    assert_ok(pv_flood_create(context, &grid, 4, 9, &flood));
    assert_int_equal(flood.count, grid.voxels);
    assert_int_equal(flood.seeds, 4);
    int32_t level[15 * 11 * 13], seen[15 * 11 * 13] = { 0 };
    for (int32_t l = 0; l < flood.levels; l++)
        for (int64_t i = flood.level[l]; i < flood.level[l + 1]; i++) {
            level[flood.order[i]] = l;
            seen[flood.order[i]]++;
        }
    assert_int_equal(flood.level[flood.levels], flood.count);
    for (int32_t i = 0; i < grid.voxels; i++) {
        assert_int_equal(seen[i], 1);
        for (int32_t j = 0; j < grid.voxels; j++) {
            int32_t d[3] = { abs(i % 15 - j % 15), abs(i / 15 % 11 - j / 15 % 11), abs(i / 165 - j / 165) };
            int plane = d[0] == 0 || d[1] == 0 || d[2] == 0;
            if (i != j && plane && d[0] <= 2 && d[1] <= 2 && d[2] <= 2)
                assert_true(level[i] != level[j]);
        }
    }
    pv_flood_free(&flood);
    pv_grid_free(&grid);
}

static void measurements_are_kept(void **state)
{
    pave_context *context = *state;
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    const double points[] = { 3, 4, 5, 10, 2, 9, 0, 0, 0, 17, 15, 16 }, values[] = { 255, 0, 77, 160 };
    for (int32_t mode = PAVE_SOLID_PAPER; mode <= PAVE_SOLID_FAST; mode++) {
        pave_solid_input in = PAVE_SOLID_INPUT_INIT;
        pave_solid_params p = small(mode);
        pave_volume *v = NULL;
        in.exemplar[0] = sample;
        in.points = points;
        in.point_values = values;
        in.point_count = 4;
        assert_ok(pave_solid_create(context, &in, &p, &v));
        int64_t measured = 0;
        for (size_t i = 0; i < voxels(v); i++) {
            uint8_t value = ((const uint8_t *)pave_volume_values(v))[i];
            measured += pave_volume_states(v)[i] == PAVE_VOXEL_MEASURED;
            if (pave_volume_states(v)[i] == PAVE_VOXEL_FILLED)
                assert_true(value == 0 || value == 160 || value == 255);
        }
        assert_int_equal(measured, 4);
        for (int i = 0; i < 4; i++)
            assert_int_equal(((const uint8_t *)pave_volume_values(v))[((int)points[3 * i + 2] * 16 +
                             (int)points[3 * i + 1]) * 18 + (int)points[3 * i]], (int)values[i]);
        pave_volume_free(&v);
    }
    pave_image_free(&sample);
}

static void slices_and_partial_volumes_are_kept(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pave_image *sample = make_sample(context, 1, PAVE_U8), *cut = NULL;
    pave_solid_params p = small(PAVE_SOLID_BEST);
    pave_volume *v = make(context, sample, &p), *again = NULL;
    assert_ok(pave_volume_slice(context, v, 1, 7, &cut));
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    const pave_image *slices[] = { cut };
    const int32_t places[] = { 1, 3 };
    in.exemplar[0] = sample;
    in.slice_count = 1;
    in.slices = slices;
    in.slice_places = places;
    p.seed = 5;
    assert_ok(pave_solid_create(context, &in, &p, &again));
    pave_image *other = NULL;
    assert_ok(pave_volume_slice(context, again, 1, 3, &other));
    assert_memory_equal(pave_image_pixels(cut), pave_image_pixels(other), 18 * 17);
    pave_image_free(&other);
    pave_image_free(&cut);

    pave_volume_params shape = PAVE_VOLUME_PARAMS_INIT;
    pave_volume *partial = NULL, *filled = NULL;
    uint8_t states[18 * 16 * 17];
    shape.width = 18, shape.height = 16, shape.depth = 17;
    for (size_t i = 0; i < sizeof states; i++)
        states[i] = i % 18 < 9 ? PAVE_VOXEL_MEASURED : i % 18 == 17 ? PAVE_VOXEL_OUTSIDE : PAVE_VOXEL_FREE;
    assert_ok(pave_volume_create(context, &shape, pave_volume_values(v), states, &partial));
    pave_solid_input rest = PAVE_SOLID_INPUT_INIT;
    rest.exemplar[0] = sample;
    rest.partial = partial;
    assert_ok(pave_solid_create(context, &rest, &p, &filled));
    for (size_t i = 0; i < sizeof states; i++) {
        assert_int_equal(pave_volume_states(filled)[i], states[i] == PAVE_VOXEL_FREE ? PAVE_VOXEL_FILLED : states[i]);
        if (states[i] == PAVE_VOXEL_MEASURED)
            assert_int_equal(((const uint8_t *)pave_volume_values(filled))[i],
                             ((const uint8_t *)pave_volume_values(v))[i]);
    }
    pave_volume_free(&filled);
    pave_volume_free(&partial);
    pave_volume_free(&again);
    pave_volume_free(&v);
    pave_image_free(&sample);
}

static pave_solid_measure judge(pave_context *context, const pave_image *sample, const pave_volume *v)
{
    pave_solid_measure m = { .size = sizeof m };
    assert_ok(pave_solid_measure_against(context, sample, v, &m));
    return m;
}

/* What the paper calls early: its stones have no structure. Best mode must be far better, or it is broken. */
static void best_mode_beats_the_paper(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    pave_solid_measure m[2];
    for (int32_t mode = PAVE_SOLID_PAPER; mode <= PAVE_SOLID_BEST; mode++) {
        pave_solid_params p = small(mode);
        p.width = p.height = p.depth = 28;
        pave_volume *v = make(context, sample, &p);
        m[mode] = judge(context, sample, v);
        pave_volume_free(&v);
    }
    assert_true(m[1].emd < 0.5 && m[1].phase < 0.005);
    assert_true(m[1].sharpness > 0.8 && m[1].sharpness < 1.2);
    assert_true(fabs(m[1].correlation[0] - m[1].correlation_reference) < 0.1);
    assert_true(m[0].cov_error > 1.2 * m[1].cov_error);
    assert_true(m[0].correlation[0] < m[0].correlation_reference - 0.15);
    assert_true(m[0].sharpness > 1.3);
    assert_true(m[1].speckle < 0.01);
    pave_image_free(&sample);
}

/* Differences across the ends of all three axes, over those inside. */
static double seam(const pave_volume *v)
{
    const uint8_t *values = pave_volume_values(v);
    const int32_t size[3] = { pave_volume_width(v), pave_volume_height(v), pave_volume_depth(v) };
    const int64_t along[3] = { 1, size[0], (int64_t)size[0] * size[1] };
    double across = 0, inside = 0, ends = 0, pairs = 0;
    for (int64_t i = 0; i < (int64_t)voxels(v); i++)
        for (int a = 0; a < 3; a++) {
            int last = i / along[a] % size[a] + 1 == size[a];
            double d = abs(values[i] - values[last ? i - (size[a] - 1) * along[a] : i + along[a]]);
            *(last ? &across : &inside) += d;
            *(last ? &ends : &pairs) += 1;
        }
    return across / ends / (inside / pairs);
}

static void periodic_sides_fit(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    pave_solid_params p = small(PAVE_SOLID_BEST);
    p.width = 23, p.height = 24, p.depth = 20;
    pave_volume *open = make(context, sample, &p);
    p.periodic = 1;
    pave_volume *closed = make(context, sample, &p);
    assert_true(seam(closed) < 1.3);
    assert_true(seam(open) > 1.5);
    pave_volume_free(&open);
    pave_volume_free(&closed);
    pave_image_free(&sample);
}

static void layers_stay_layers(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pave_image_params p = PAVE_IMAGE_PARAMS_INIT;
    pave_image *layered = NULL, *flat = make_sample(context, 1, PAVE_U8);
    uint8_t pixels[SAMPLE * SAMPLE];
    for (int32_t i = 0; i < SAMPLE * SAMPLE; i++)
        pixels[i] = (uint8_t)(i / SAMPLE / 4 % 2 ? 200 : 40 + i % 7);
    p.width = p.height = SAMPLE;
    assert_ok(pave_image_create(context, &p, pixels, &layered));
    pave_image_free(&flat);
    for (int32_t i = 0; i < SAMPLE * SAMPLE; i++)
        pixels[i] = (uint8_t)((i / SAMPLE / 16 + i % SAMPLE / 16) % 2 ? 200 : 40 + i % 7);
    assert_ok(pave_image_create(context, &p, pixels, &flat));
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    pave_solid_params s = small(PAVE_SOLID_BEST);
    pave_volume *v = NULL;
    in.exemplar[0] = in.exemplar[1] = layered;
    in.exemplar[2] = flat;
    assert_ok(pave_solid_create(context, &in, &s, &v));
    pave_solid_measure m = judge(context, layered, v);
    assert_true(m.correlation[0] > m.correlation[2] + 0.15);
    assert_true(m.correlation[1] > m.correlation[2] + 0.15);
    pave_volume_free(&v);
    pave_image_free(&layered);
    pave_image_free(&flat);
}

/* Each voxel of a composition is a composition of the sample. */
static void vectors_and_deep_values_come_from_the_sample(void **state)
{
    pave_context *context = *state;
    for (int32_t type = PAVE_U8; type <= PAVE_U16; type++) {
        pave_image *sample = make_sample(context, 3, type);
        size_t each = type == PAVE_U8 ? 3 : 6;
        for (int32_t mode = PAVE_SOLID_PAPER; mode <= PAVE_SOLID_FAST; mode++) {
            pave_solid_params p = small(mode);
            p.width = p.height = p.depth = THREAD_SANITIZED ? 8 : 12;
            pave_volume *v = make(context, sample, &p);
            assert_int_equal(pave_volume_channels(v), 3);
            for (size_t i = 0; i < voxels(v); i++) {
                const char *value = (const char *)pave_volume_values(v) + i * each, *from = pave_image_pixels(sample);
                int found = 0;
                for (size_t k = 0; k < SAMPLE * SAMPLE && !found; k++)
                    found = !memcmp(value, from + k * each, each);
                assert_true(found);
            }
            pave_volume_free(&v);
        }
        pave_image_free(&sample);
    }
}

static void flat_pictures_by_the_same_code(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    pave_solid_params p = small(PAVE_SOLID_PAPER);
    p.width = p.height = 40;
    p.depth = 1;
    pave_volume *v = make(context, sample, &p);
    pave_solid_measure m = judge(context, sample, v);
    assert_true(m.correlation[0] > m.correlation_reference - 0.15); /* in a plane the paper's method works */
    assert_non_null(pave_volume_cells(v));
    pave_volume_free(&v);
    pave_image_free(&sample);
}

/* A box of 12 triangles from a to b, turned outwards. */
static void add_box(double *vertices, int32_t *triangles, int32_t which, const double a[3], const double b[3])
{
    static const int32_t faces[12][3] = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
                                          { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
    for (int32_t i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            vertices[(8 * which + i) * 3 + k] = i >> k & 1 ? b[k] : a[k];
    for (int32_t i = 0; i < 36; i++)
        triangles[36 * which + i] = 8 * which + faces[i / 3][i % 3];
}

static int64_t fill(pave_context *context, const double *vertices, int32_t vertex_count, const int32_t *triangles,
                    int32_t count, const char *shape)
{
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    pave_solid_params p = small(PAVE_SOLID_PAPER);
    pave_mesh *mesh = NULL;
    pave_volume *v = NULL;
    int64_t inside = 0;
    assert_ok(pave_mesh_create(context, vertices, vertex_count, triangles, count, &mesh));
    p.resolution = 20;
    p.window = 3;
    in.exemplar[0] = sample;
    in.mesh = mesh;
    assert_ok(pave_solid_create(context, &in, &p, &v));
    assert_int_equal(pave_volume_width(v), 20);
    assert_non_null(strstr(pave_volume_shape(v), shape));
    for (size_t i = 0; i < voxels(v); i++)
        inside += pave_volume_states(v)[i] == PAVE_VOXEL_FILLED;
    pave_volume_free(&v);
    pave_mesh_free(&mesh);
    pave_image_free(&sample);
    return inside;
}

static void meshes_are_filled(void **state)
{
    pave_context *context = *state;
    double vertices[48];
    int32_t triangles[72], turned[36];
    const double a[3] = { -1e6, 0, 0 }, b[3] = { 1e6, 1e6, 0.5e6 }, c[3] = { 0, 0.2e6, 0.1e6 }, d[3] = { 2e6, 0.6e6, 0.4e6 };
    add_box(vertices, triangles, 0, a, b);
    add_box(vertices, triangles, 1, c, d);
    assert_int_equal(fill(context, vertices, 8, triangles, 12, "parity: closed"), 20 * 10 * 5);
    for (int i = 0; i < 36; i++)
        turned[i] = triangles[i / 3 * 3 + 2 - i % 3];
    assert_int_equal(fill(context, vertices, 8, turned, 12, "parity: closed"), 20 * 10 * 5);
    memcpy(turned, triangles, 9 * sizeof *turned);
    assert_int_equal(fill(context, vertices, 8, turned, 12, "not all triangles turned"), 20 * 10 * 5);
    assert_int_equal(fill(context, vertices, 8, triangles, 11, "generalised winding number: 3 edges"), 20 * 10 * 5);
    /* two boxes that overlap: their union, without a hole where both are; the voxels are half as many now */
    int64_t both = fill(context, vertices, 16, triangles, 24, "overlap");
    assert_true(both > 13 * 7 * 3 && both < 20 * 7 * 4);
}

static void meshes_without_inside_are_refused(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    pave_mesh *mesh = NULL;
    pave_volume *v = NULL;
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    double flat[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, nan[9] = { 0, 0, 0, 1, 0, 0, 0, NAN, 0 };
    const int32_t one[3] = { 0, 1, 2 }, same[3] = { 0, 1, 1 }, wrong[3] = { 0, 1, 3 };
    assert_int_equal(pave_mesh_create(context, nan, 3, one, 1, &mesh), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(context), "vertex 2 "));
    assert_int_equal(pave_mesh_create(context, flat, 3, wrong, 1, &mesh), PAVE_ERR_ARGUMENT);
    assert_int_equal(pave_mesh_create(context, flat, 3, one, 0, &mesh), PAVE_ERR_ARGUMENT);
    assert_null(mesh);
    const int32_t *const lists[] = { one, same };
    for (int i = 0; i < 2; i++) {
        assert_ok(pave_mesh_create(context, flat, 3, lists[i], 1, &mesh));
        in.exemplar[0] = sample;
        in.mesh = mesh;
        assert_int_equal(pave_solid_create(context, &in, NULL, &v), PAVE_ERR_FORMAT);
        assert_null(v);
        pave_mesh_free(&mesh);
    }
    pave_image_free(&sample);
}

static void refuse(pave_context *context, const pave_solid_input *in, const pave_solid_params *p, pave_result code,
                   const char *words)
{
    pave_volume *v = NULL;
    assert_int_equal(pave_solid_create(context, in, p, &v), code);
    assert_non_null(strstr(pave_context_message(context), words));
    assert_null(v);
}

static void bad_input_is_refused(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    pave_solid_params p = small(PAVE_SOLID_BEST);
    double points[] = { 1, 1, 1, 1.2, 1, 0.9, 2, 2, 2 }, values[] = { 9, 9, 9 };
    refuse(context, &in, &p, PAVE_ERR_ARGUMENT, "one sample, or three");
    in.exemplar[0] = sample;
    in.points = points;
    in.point_values = values;
    in.point_count = 3;
    values[1] = 10;
    refuse(context, &in, &p, PAVE_ERR_ARGUMENT, "measurement 2 gives voxel 1,1,1 the value 10");
    values[1] = 9;
    points[7] = 16;
    refuse(context, &in, &p, PAVE_ERR_ARGUMENT, "measurement 3 at 2,16,2 lies outside");
    points[7] = NAN;
    refuse(context, &in, &p, PAVE_ERR_ARGUMENT, "measurement 3");
    points[7] = 2;
    values[0] = 300;
    refuse(context, &in, &p, PAVE_ERR_ARGUMENT, "cannot hold");
    in.point_count = 0;
    p.window = 4;
    refuse(context, &in, &p, PAVE_ERR_ARGUMENT, "must be odd");
    p.window = 5;
    p.width = p.height = p.depth = 16384;
    refuse(context, &in, &p, PAVE_ERR_LIMIT, "16384 x 16384 x 16384");
    pave_image_params tiny = PAVE_IMAGE_PARAMS_INIT;
    pave_image *speck = NULL;
    tiny.width = 5, tiny.height = 40;
    assert_ok(pave_image_create(context, &tiny, NULL, &speck));
    in.exemplar[0] = speck;
    p = small(PAVE_SOLID_BEST);
    refuse(context, &in, &p, PAVE_ERR_ARGUMENT, "too small for a window of 5");
    pave_image_free(&speck);
    pave_image_free(&sample);
}

static void many_seeds_and_plain_samples(void **state)
{
    pave_context *context = *state;
    pave_image *sample = make_sample(context, 1, PAVE_U8), *plain = NULL;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_solid_params p = small(PAVE_SOLID_FAST);
    p.seeds = 100000;
    pave_volume *v = make(context, sample, &p);
    pave_volume_free(&v);
    shape.width = shape.height = SAMPLE;
    assert_ok(pave_image_create(context, &shape, NULL, &plain));
    for (p.mode = PAVE_SOLID_PAPER; p.mode <= PAVE_SOLID_FAST; p.mode++) {
        p.seeds = 3;
        v = make(context, plain, &p);
        for (size_t i = 0; i < voxels(v); i++)
            assert_int_equal(((const uint8_t *)pave_volume_values(v))[i], 0);
        pave_volume_free(&v);
    }
    pave_image_free(&plain);
    pave_image_free(&sample);
}

static void files_read_back(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    static const char *const names[] = { "s.nrrd", "s.nrrd.gz", "s.vti", "s.raw", "s.tif" };
    char folder[] = "/tmp/pave-solid-XXXXXX", path[256];
    assert_non_null(mkdtemp(folder));
    for (int32_t type = PAVE_U8; type <= PAVE_U16; type++) {
        pave_image *sample = make_sample(context, type == PAVE_U8 ? 1 : 3, type);
        pave_solid_params p = small(PAVE_SOLID_PAPER);
        p.window = 3;
        p.depth = 4;
        pave_volume *v = make(context, sample, &p), *back = NULL;
        for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
            snprintf(path, sizeof path, "%s/%s", folder, names[i]);
            pave_result result = pave_volume_write(context, v, path, NULL);
            if (result == PAVE_ERR_UNSUPPORTED && i == 4)
                continue; /* built without the module */
            assert_ok(result);
            assert_ok(pave_volume_read(context, path, &back));
            assert_int_equal(pave_volume_width(back), 18);
            assert_int_equal(pave_volume_height(back), 16);
            assert_int_equal(pave_volume_depth(back), 4);
            assert_int_equal(pave_volume_channels(back), pave_volume_channels(v));
            assert_true(hash_volume(back) == hash_volume(v));
            pave_volume_free(&back);
        }
        pave_volume_free(&v);
        pave_image_free(&sample);
    }
    snprintf(path, sizeof path, "%s/cut.nrrd", folder);
    FILE *file = fopen(path, "wb");
    fputs("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 100 100 100\nencoding: raw\n\nshort", file);
    fclose(file);
    pave_volume *none = NULL;
    assert_int_equal(pave_volume_read(context, path, &none), PAVE_ERR_FORMAT);
    assert_null(none);
    snprintf(path, sizeof path, "rm -r %s", folder);
    assert_int_equal(system(path), 0);
}

static void values_at_a_point(void **state)
{
    pave_context *context = *state;
    not_for_threads();
    pave_volume_params p = PAVE_VOLUME_PARAMS_INIT;
    pave_volume *v = NULL;
    const uint8_t values[8] = { 0, 255, 0, 255, 0, 255, 0, 255 };
    uint8_t states[8] = { 2, 2, 2, 2, 2, 2, 2, 2 };
    float value;
    p.width = p.height = p.depth = 2;
    p.spacing = 0.5;
    p.origin[0] = 10;
    assert_ok(pave_volume_create(context, &p, values, states, &v));
    assert_int_equal(pave_volume_sample(v, 10.125, 0.2, 0.3, &value), 1);
    assert_true(fabsf(value - 0.25f) < 1e-6f);
    assert_int_equal(pave_volume_sample(v, 10.6, 0, 0, &value), 1);
    assert_true(value == 1);
    assert_int_equal(pave_volume_sample(v, 12, 0, 0, &value), 0);
    assert_int_equal(pave_volume_sample(v, NAN, 0, 0, &value), 0);
    pave_volume_free(&v);
}

static int32_t stop_soon(void *user, const char *stage, double done)
{
    (void)stage;
    (void)done;
    return ++*(int *)user > 3;
}

static void a_stone_can_be_cancelled(void **state)
{
    (void)state;
    int calls = 0;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *context = NULL;
    pave_volume *v = NULL;
    params.progress = stop_soon;
    params.progress_user = &calls;
    assert_ok(pave_context_create(&params, &context));
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    pave_solid_params p = PAVE_SOLID_PARAMS_INIT;
    in.exemplar[0] = sample;
    assert_int_equal(pave_solid_create(context, &in, &p, &v), PAVE_ERR_CANCELLED);
    assert_null(v);
    pave_image_free(&sample);
    pave_context_free(&context);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    not_for_threads();
    failing f = { 0 };
    pave_context_params params = failing_params(&f);
    pave_context *context = NULL;
    assert_ok(pave_context_create(&params, &context));
    pave_image *sample = make_sample(context, 1, PAVE_U8);
    pave_solid_params p = small(PAVE_SOLID_BEST);
    p.width = p.height = p.depth = 6;
    p.cells = 1;
    int64_t idle = f.blocks, before = f.calls;
    pave_volume *v = make(context, sample, &p);
    int64_t points = f.calls - before;
    pave_volume_free(&v);
    assert_int_equal(f.blocks, idle);
    assert_true(points > 40);
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    in.exemplar[0] = sample;
    for (int64_t k = 1; k <= points; k++) {
        f.fail_at = f.calls + k;
        assert_int_equal(pave_solid_create(context, &in, &p, &v), PAVE_ERR_MEMORY);
        assert_null(v);
        assert_int_equal(f.blocks, idle);
    }
    pave_image_free(&sample);
    pave_context_free(&context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(a_device_makes_the_same),
        cmocka_unit_test(windows_of_equal_distance_agree),
        cmocka_unit_test(a_flood_keeps_its_order),
        cmocka_unit_test(measurements_are_kept),
        cmocka_unit_test(slices_and_partial_volumes_are_kept),
        cmocka_unit_test(best_mode_beats_the_paper),
        cmocka_unit_test(the_surface_is_as_the_inside),
        cmocka_unit_test(periodic_sides_fit),
        cmocka_unit_test(layers_stay_layers),
        cmocka_unit_test(vectors_and_deep_values_come_from_the_sample),
        cmocka_unit_test(flat_pictures_by_the_same_code),
        cmocka_unit_test(meshes_are_filled),
        cmocka_unit_test(meshes_without_inside_are_refused),
        cmocka_unit_test(bad_input_is_refused),
        cmocka_unit_test(many_seeds_and_plain_samples),
        cmocka_unit_test(files_read_back),
        cmocka_unit_test(values_at_a_point),
        cmocka_unit_test(a_stone_can_be_cancelled),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
