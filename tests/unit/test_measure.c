/* measure: stones made by hand, whose measures are known; SVG of anyone's, good, bad and hostile. */
#include "test.h"

#include "util/clip.h"
#include "util/random.h"

#include <math.h>
#include <unistd.h>

#define assert_near(a, b) assert_true(fabs((a) - (b)) < 1e-9)

static char path[64];

static int open_all(void **state)
{
    snprintf(path, sizeof path, "/tmp/pave-measure-%ld.svg", (long)getpid());
    return open_context(state);
}

static int close_all(void **state)
{
    unlink(path);
    return close_context(state);
}

static pave_result read_bytes(pave_context *context, const char *text, size_t size, pave_stones **out)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, size, file), size);
    fclose(file);
    return pave_stones_read(context, path, out);
}

/* Stones on a plane of 40 x 20 px: the inside of an <svg>. */
static pave_stones *stones_of(pave_context *context, const char *inside)
{
    char text[4096];
    pave_stones *stones = NULL;
    int n = snprintf(text, sizeof text, "<svg viewBox=\"0 0 40 20\">%s</svg>", inside);
    assert_ok(read_bytes(context, text, (size_t)n, &stones));
    return stones;
}

/* 40 x 20 px, black up to `edge`, white from there. */
static pave_image *halves(pave_context *context, int32_t edge)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    uint8_t pixels[800];
    for (int32_t i = 0; i < 800; i++)
        pixels[i] = i % 40 < edge ? 0 : 255;
    shape.width = 40;
    shape.height = 20;
    assert_ok(pave_image_create(context, &shape, pixels, &image));
    return image;
}

static pave_stones_measures measure(pave_context *context, int32_t edge, const char *inside,
                                    const pave_stones_measure_params *params)
{
    pave_image *drawing = halves(context, edge);
    pave_stones *stones = stones_of(context, inside);
    pave_stones_measures m = { .size = sizeof m };
    assert_ok(pave_stones_measure(context, drawing, stones, params, &m));
    pave_stones_free(&stones);
    pave_image_free(&drawing);
    return m;
}

static void overlap_is_exact(void **state)
{
    pave_context *context = *state;
    static const struct { const char *stones; double area; int32_t count; } known[] = {
        { "<polygon points='0,0 10,0 10,10 0,10'/><polygon points='10,0 20,0 20,10 10,10'/>", 0, 0 },
        { "<polygon points='0,0 10,0 10,10 0,10'/><polygon points='9.999,0 20,0 20,10 9.999,10'/>", 0.01, 2 },
        { "<polygon points='0,0 10,0 10,10 0,10'/><polygon points='5,5 15,5 15,15 5,15'/>", 25, 2 },
        { "<polygon points='0,0 10,0 10,10 0,10'/><polygon points='2,2 2,4 4,4 4,2'/>", 4, 2 },
        { "<polygon points='0,0 10,0 10,10 0,10'/><polygon points='0,0 10,0 10,10 0,10'/>", 100, 2 },
        { "<polygon points='0,0 10,10 0,10'/><polygon points='0,0 10,0 10,10'/>", 0, 0 },
        { "<polygon points='0,0 10,0 10,10 0,10'/><polygon points='5,0 15,5 5,10 -5,5'/>", 75, 2 },
        /* an L round a square, and one that is run through */
        { "<polygon points='0,0 20,0 20,5 5,5 5,15 0,15'/><polygon points='5,5 15,5 15,15 5,15'/>", 0, 0 },
        { "<polygon points='0,0 20,0 20,5 5,5 5,15 0,15'/><polygon points='4,4 15,4 15,15 4,15'/>", 21, 2 },
        { "<polygon points='0,0 20,0 20,20 15,20 15,5 5,5 5,20 0,20'/><polygon points='0,10 20,10 20,12 0,12'/>", 20,
          2 },
        /* three in one place are three pairs */
        { "<polygon points='0,0 9,0 9,9 0,9'/><polygon points='0,0 9,0 9,9 0,9'/><polygon points='6,6 6,9 9,9 9,6'/>",
          99, 3 },
        /* invalid ones do not count */
        { "<polygon points='0,0 10,0 10,10 0,10'/><polygon points='0,0 10,10 10,0 0,10'/>", 0, 0 },
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        pave_stones_measures m = measure(context, 20, known[i].stones, NULL);
        assert_near(m.overlap * 800, known[i].area);
        assert_int_equal(m.overlapping, known[i].count);
        assert_true(known[i].area > 0 || m.overlap == 0);
    }
}

static void shapes_are_told_apart(void **state)
{
    pave_context *context = *state;
    pave_stones_measure_params params = PAVE_STONES_MEASURE_PARAMS_INIT;
    params.half_side = 2;
    pave_stones_measures m = measure(context, 20,
        "<polygon points='0,0 4,0 4,4 0,4'/>"           /* a square */
        "<polygon points='5,0 5,4 9,4 9,0'/>"           /* the other way round */
        "<polygon points='10,0 14,0 12,4'/>"            /* a triangle */
        "<polygon points='15,0 19,4 19,0 15,4'/>"       /* crosses itself */
        "<polygon points='20,0 24,0'/>"                 /* two corners */
        "<polygon points='25,0 29,0 29,4 27,1 25,4'/>"  /* turns both ways */
        "<polygon points='30,0 34,0 34,0 34,4 30,4 30,0'/>" /* corners that come twice */
        "<polygon points='0,8 39,8 39,9 0,9'/>"         /* thin */
        "<polygon points='0,12 1,12 1,13 0,13'/>"       /* small, and tiny */
        "<polygon points='5,12 9,12 9,12 5,12'/>", &params); /* a flat triangle, closed */
    assert_int_equal(m.stones, 10);
    assert_int_equal(m.invalid, 3);
    assert_int_equal(m.clockwise, 1);
    assert_near(m.quads, 0.5);
    assert_near(m.triangles, 0.2);
    assert_int_equal(m.vertices[5], 2);
    assert_near(m.nonconvex, 0.1);
    assert_near(m.sliver, 0.4);
    assert_near(m.tiny, 0.4);
    assert_near(m.small, 0.4);
    assert_near(m.thin, 0.5);
    assert_near(m.area_median, 9);
    assert_near(m.coverage * 800, 16 + 16 + 8 + 10 + 16 + 39 + 1);
    assert_near(m.area_mean, 10.6);
}

static void ground_is_looked_at_pixel_by_pixel(void **state)
{
    pave_context *context = *state;
    /* black to 20 px in the drawing, to 22 in stone; then a hole of 2 px; two stones on the last 5 */
    pave_stones_measures m = measure(context, 20,
        "<polygon points='0,0 22,0 22,20 0,20' fill='#000'/><polygon points='24,0 40,0 40,20 24,20' fill='#fff'/>"
        "<polygon points='35,0 40,0 40,20 35,20' fill='#fff'/>", NULL);
    assert_near(m.mismatch * 800, 40);
    assert_near(m.uncovered * 800, 40);
    assert_near(m.multiple * 800, 100);
    assert_near(m.straddlers, 1.0 / 3); /* 20 of 22 columns */
    assert_near(m.edge_mean, 3); /* the hole is divided */
    assert_near(m.edge_max, 3);
    assert_near(m.missed_mean, 3);
    m = measure(context, 20, "<polygon points='0,0 20,0 20,20 0,20'/><polygon fill='#fff' points='20,0 40,0 40,20 20,20'/>",
                NULL);
    assert_near(m.mismatch + m.uncovered + m.multiple + m.straddlers + m.edge_mean + m.missed_max, 0);
    m = measure(context, 20, "<polygon points='0,0 40,0 40,20 0,20'/>", NULL);
    assert_near(m.mismatch, 0.5);
    assert_true(isinf(m.missed_mean) && isinf(m.missed_max) && m.edge_max == 0);
}

/* Squares of side `side` every 5 px, turned by the same angle whose tangent is t. */
static void squares(char *text, size_t room, double side, double t)
{
    size_t n = 0;
    double c = side / 2 / sqrt(1 + t * t), s = c * t;
    for (int i = 0; i < 32; i++) {
        double x = 2.5 + 5 * (i % 8), y = 2.5 + 5 * (i / 8);
        n += (size_t)snprintf(text + n, room - n, "<polygon points='%.6f,%.6f %.6f,%.6f %.6f,%.6f %.6f,%.6f'/>",
                              x - c + s, y - s - c, x + c + s, y + s - c, x + c - s, y + s + c, x - c - s, y - s + c);
    }
}

static void directions_and_joints_are_measured(void **state)
{
    pave_context *context = *state;
    char text[8192];
    squares(text, sizeof text, 4.25, 0);
    pave_stones_measures m = measure(context, 40, text, NULL); /* no edge: all are far */
    assert_near(m.axis_bias, 1);
    assert_int_equal(m.far_stones, 32);
    assert_int_equal(m.near_stones, 0);
    assert_near(m.joint_mean, 0.75);
    assert_true(m.joint_deviation < 1e-6);
    assert_true(fabs(m.joint_p5 - 0.75) < 0.01 && fabs(m.joint_p95 - 0.75) < 0.01);
    assert_near(m.jointed, 1 - 24.0 / 128); /* all but the border */
    assert_near(m.half_side, 2.5);
    pave_stones_measure_params params = PAVE_STONES_MEASURE_PARAMS_INIT;
    params.joint_limit = 0.2; /* half a px: no joint any more */
    assert_near(measure(context, 40, text, &params).jointed, 0);
    squares(text, sizeof text, 3, tan(10 * acos(-1) / 180));
    m = measure(context, 20, text, NULL);
    assert_int_equal(m.near_stones, 8);
    assert_true(fabs(m.near_mean - 10) < 0.01 && fabs(m.near_p90 - 10) < 0.02);
    squares(text, sizeof text, 5.25, 0); /* all overlap */
    m = measure(context, 40, text, NULL);
    assert_near(m.joint_mean, 0);
    assert_int_equal(m.overlapping, 32);
}

static void every_way_to_write_a_stone_is_read(void **state)
{
    pave_context *context = *state;
    static const char *const ways[] = {
        "<polygon points='1,2 11,2 11,7 1,7' fill='#ffffff'/>",
        "<polygon fill=\"white\" points=\" 1 2,11 2 , 11 7\n1,7 1,2 \"></polygon>",
        "<g fill='#FFF'><g><polygon points='1,2,11,2,11,7,1,7'/></g></g>",
        "<path fill='rgb(255, 255,255)' d='M1 2H11V7H1Z'/>",
        "<path fill='#fff' d='m1,2 10,0 0,5 -10,0z'/>",
        "<path fill='#fff' d='M1 2h10v5h-10z'/>",
        "<path fill='#fff' d='M1 2 11 2 11 7 L 1 7 L 1 2'/>",
        "<path fill='#000' style='stroke:none; fill : #fefefe' d='M1e0,.2e1L1.1E+1,2l0,5.000-10,0'/>",
        "<s:polygon fill='#fff' points='1.0004,1.9996 11,2 11,7 1,7'/>",
        "<!-- a <polygon> --><defs><polygon points='0,0 1,1 1,0'/></defs><polygon fill='none' points='0,0 1,1 1,0'/>"
        "<text>no</text><rect width='9' height='9'/><style> </style><polygon fill='#fff' points='1 2 11 2 11 7 1 7'/>",
    };
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        static const double corners[] = { 1, 2, 11, 2, 11, 7, 1, 7 };
        pave_stones *stones = stones_of(context, ways[i]);
        assert_int_equal(pave_stones_count(stones), 1);
        assert_int_equal(pave_stones_starts(stones)[1], 4);
        assert_memory_equal(pave_stones_vertices(stones), corners, sizeof corners);
        assert_int_equal(pave_stones_colours(stones)[0], 255);
        assert_int_equal(pave_stones_width(stones), 40);
        pave_stones_free(&stones);
    }
}

static void what_is_no_pavement_is_refused_with_a_sentence(void **state)
{
    pave_context *context = *state;
    static const struct { const char *text; pave_result result; const char *words; } bad[] = {
        { "", PAVE_ERR_FORMAT, "is empty" },
        { "\x89PNG\r\n", PAVE_ERR_FORMAT, "not SVG" },
        { "hello", PAVE_ERR_FORMAT, "text outside of all tags" },
        { "<html/>", PAVE_ERR_FORMAT, "not <svg>" },
        { "<svg/>", PAVE_ERR_FORMAT, "no viewBox" },
        { "<svg viewBox='0 0 10'/>", PAVE_ERR_FORMAT, "whole px" },
        { "<svg viewBox='0 0 10.5 10'/>", PAVE_ERR_FORMAT, "whole px" },
        { "<svg viewBox='0 0 0 10'/>", PAVE_ERR_FORMAT, "no pixels" },
        { "<svg viewBox='0 0 1048576 1048576'/>", PAVE_ERR_LIMIT, "limit" },
        { "<svg viewBox='0 0 9 9'>", PAVE_ERR_FORMAT, "ends before </svg>" },
        { "<svg viewBox='0 0 9 9'></g></svg>", PAVE_ERR_FORMAT, "closed" },
        { "<svg viewBox='0 0 9 9'/><svg viewBox='0 0 9 9'/>", PAVE_ERR_FORMAT, "after </svg>" },
        { "<svg viewBox='0 0 9 9'><polygon points='1,2 3'/></svg>", PAVE_ERR_FORMAT, "pairs of numbers" },
        { "<svg viewBox='0 0 9 9'>\n\n<polygon points='1,2 a,3'/></svg>", PAVE_ERR_FORMAT, "line 3" },
        { "<svg viewBox='0 0 9 9'><polygon points='1,2 nan,3'/></svg>", PAVE_ERR_FORMAT, "pairs" },
        { "<svg viewBox='0 0 9 9'><polygon points='1e99,2 3,4'/></svg>", PAVE_ERR_FORMAT, "pairs" },
        { "<svg viewBox='0 0 9 9'><path d='m2e6,0 1e6,0 1e6 0'/></svg>", PAVE_ERR_FORMAT, "beyond" },
        { "<svg viewBox='0 0 9 9'><polygon points='1,2 3,4", PAVE_ERR_FORMAT, "not well formed" },
        { "<svg viewBox='0 0 9 9'><polygon points=1/></svg>", PAVE_ERR_FORMAT, "not well formed" },
        { "<svg viewBox='0 0 9 9'><path d='M0 0C1 1 2 2 3 3'/></svg>", PAVE_ERR_UNSUPPORTED, "no straight line: 'C'" },
        { "<svg viewBox='0 0 9 9'><path d='M0 0H1V1ZM4 4H5V5Z'/></svg>", PAVE_ERR_FORMAT, "more than one ring" },
        { "<svg viewBox='0 0 9 9'><path d='1 1'/></svg>", PAVE_ERR_FORMAT, "path" },
        { "<svg viewBox='0 0 9 9'><path d='L1 1'/></svg>", PAVE_ERR_FORMAT, "path" },
        { "<svg viewBox='0 0 9 9'><g transform='scale(2)'/></svg>", PAVE_ERR_UNSUPPORTED, "transforms" },
        { "<svg viewBox='0 0 9 9'><style>.a{}</style></svg>", PAVE_ERR_UNSUPPORTED, "style sheets" },
        { "<svg viewBox='0 0 9 9'><style><![CDATA[.a{}]]></style></svg>", PAVE_ERR_UNSUPPORTED, "style sheets" },
        { "<svg viewBox='0 0 9 9'><g fill='url(#a)'/></svg>", PAVE_ERR_UNSUPPORTED, "plain colour" },
        { "<svg viewBox='0 0 9 9'><g fill='#12345'/></svg>", PAVE_ERR_UNSUPPORTED, "plain colour" },
        { "<svg viewBox='0 0 9 9'><g fill='rgb(256,0,0)'/></svg>", PAVE_ERR_UNSUPPORTED, "plain colour" },
        { "<!DOCTYPE svg [<!ENTITY a 'aaa'>]><svg viewBox='0 0 9 9'/>", PAVE_ERR_FORMAT, "entities" },
        { "<!-- <svg viewBox='0 0 9 9'/>", PAVE_ERR_FORMAT, "not closed" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        pave_stones *stones = (pave_stones *)1;
        pave_result result = read_bytes(context, bad[i].text, strlen(bad[i].text), &stones);
        if (result != bad[i].result || !strstr(pave_context_message(context), bad[i].words))
            fail_msg("%s: %s: %s", bad[i].text, pave_result_name(result), pave_context_message(context));
        assert_null(stones);
    }
    char deep[4096] = "<svg viewBox='0 0 9 9'>";
    for (int i = 0; i < 300; i++)
        strcat(deep, "<g>");
    pave_stones *stones = NULL;
    assert_int_equal(read_bytes(context, deep, strlen(deep), &stones), PAVE_ERR_FORMAT);
    assert_non_null(strstr(pave_context_message(context), "too deep"));
}

static void damaged_files_do_no_damage(void **state)
{
    pave_context *context = *state;
    static const char good[] =
        "<?xml version='1.0'?><!DOCTYPE svg PUBLIC \"-//W3C\" 'x'><svg viewBox='0 0 40 20'><title>a</title><!-- b -->"
        "<g fill='#1f1d1b'><polygon id='s1' points='0,0 10.5,0 10,10 0,1e1'/></g>"
        "<path style='fill:rgb(1,2,3)' d='M1 1h3V-4.25z'/></svg>";
    static const char alphabet[] = "<>/='\"-! 0123456789.,eMhVz#&\n";
    pave_image *drawing = halves(context, 20);
    int32_t read = 0;
    for (uint32_t n = 0; n < 2000; n++) {
        char text[sizeof good];
        memcpy(text, good, sizeof good);
        pv_random r = pv_draw(7, 1, n, 0, 0);
        for (uint32_t k = 0; k <= n % 3; k++)
            text[pv_below(r.word[k], sizeof good - 1)] = alphabet[pv_below(r.word[3] >> 8 * k, sizeof alphabet - 1)];
        size_t size = n % 5 ? sizeof good - 1 : pv_below(r.word[2], sizeof good);
        pave_stones *stones = NULL;
        pave_stones_measures m = { .size = sizeof m };
        if (read_bytes(context, text, size, &stones)) {
            assert_null(stones);
            continue;
        }
        read += !pave_stones_measure(context, drawing, stones, NULL, &m);
        pave_stones_free(&stones);
    }
    assert_true(read > 250 && read < 1750);
    pave_image_free(&drawing);
}

/* What a pavement measures does not depend on how it is handed over. */
static void files_keep_what_is_measured(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 200, 160);
    pave_stones *stones = NULL;
    pave_stones_measures here = { .size = sizeof here }, there = here;
    char other[80];
    assert_ok(pave_lay(context, drawing, NULL, &stones));
    assert_ok(pave_stones_measure(context, drawing, stones, NULL, &here));
    assert_int_equal(here.stones, pave_stones_count(stones));
    assert_int_equal(here.invalid, 0);
    assert_true(here.quads > 0.9 && here.mismatch < 0.01 && here.near_mean < 20 && here.joint_mean > 0.5);
    for (int i = 0; i < 2; i++) {
        pave_stones *back = NULL;
        snprintf(other, sizeof other, "%s%s", path, i ? ".stones" : "");
        assert_ok(pave_stones_write(context, stones, other, i ? "stones" : "svg"));
        assert_ok(pave_stones_read(context, other, &back));
        pave_stones_measure_params params = PAVE_STONES_MEASURE_PARAMS_INIT;
        params.half_side = 4;
        assert_ok(pave_stones_measure(context, drawing, back, &params, &there));
        assert_int_equal(here.stones, there.stones);
        assert_memory_equal(here.vertices, there.vertices, sizeof here.vertices);
        assert_near(here.overlap, there.overlap);
        assert_near(here.area_cv, there.area_cv);
        assert_near(here.axis_bias, there.axis_bias);
        assert_near(here.joint_mean, there.joint_mean);
        assert_true(here.mismatch == there.mismatch && here.edge_mean == there.edge_mean);
        pave_stones_free(&back);
        unlink(other);
    }
    pave_stones_free(&stones);
    pave_image_free(&drawing);
}

static void windows_are_measured_in_their_place(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = halves(context, 20);
    static const char inside[] = "<svg viewBox='10 0 20 20'><polygon points='10,0 20,0 20,20 10,20'/>"
                                 "<polygon fill='#fff' points='20,0 30,0 30,20 20,20'/></svg>";
    static const char beyond[] = "<svg viewBox='30 0 20 20'><polygon points='30,0 40,0 40,20'/></svg>";
    pave_stones *stones = NULL;
    pave_stones_measures m = { .size = sizeof m };
    assert_ok(read_bytes(context, inside, sizeof inside - 1, &stones));
    assert_ok(pave_stones_measure(context, drawing, stones, NULL, &m));
    assert_int_equal(m.width, 20);
    assert_near(m.coverage, 1);
    assert_near(m.mismatch + m.uncovered + m.edge_max + m.missed_max, 0);
    pave_stones_free(&stones);
    assert_ok(read_bytes(context, beyond, sizeof beyond - 1, &stones));
    assert_int_equal(pave_stones_measure(context, drawing, stones, NULL, &m), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(context), "not within the drawing's 40 x 20 px"));
    pave_stones_free(&stones);
    m.size = 0;
    stones = stones_of(context, "");
    assert_int_equal(pave_stones_measure(context, drawing, stones, NULL, &m), PAVE_ERR_ARGUMENT);
    m.size = sizeof m;
    assert_ok(pave_stones_measure(context, drawing, stones, NULL, &m)); /* no stones at all */
    assert_near(m.uncovered, 1);
    pave_stones_free(&stones);
    pave_image_free(&drawing);
}

/* A random star round (500, 500) with `count` corners. */
static int32_t star(uint32_t n, int32_t count, pv_cell *ring)
{
    for (int32_t i = 0; i < count; i++) {
        pv_random r = pv_draw(3, 2, n, (uint32_t)i, 0);
        double angle = -2 * acos(-1) * i / count, reach = 50 + pv_below(r.word[0], 400);
        ring[i] = (pv_cell){ (int32_t)lround(500 + reach * cos(angle)), (int32_t)lround(500 + reach * sin(angle)) };
    }
    return count;
}

static void triangles_make_up_their_ring(void **state)
{
    (void)state;
    for (uint32_t n = 0; n < 2000; n++) {
        pv_cell ring[24], copy[24], triangles[3 * 24];
        double work[48], common = 0;
        int32_t count = star(n, 5 + (int32_t)(n % 20), ring);
        int64_t area = pv_ring_area(ring, count), sum = 0;
        if (!pv_ring_valid(ring, count))
            continue;
        memcpy(copy, ring, sizeof copy);
        int32_t found = pv_ring_triangles(copy, count, triangles);
        for (int32_t t = 0; t < found; t++) {
            sum += pv_ring_area(triangles + 3 * t, 3);
            assert_true(pv_ring_area(triangles + 3 * t, 3) > 0);
            for (int32_t u = 0; u < t; u++) {
                assert_false(pv_convex_meet(triangles + 3 * t, 3, triangles + 3 * u, 3));
                common += pv_convex_common(triangles + 3 * t, 3, triangles + 3 * u, 3, work);
            }
        }
        assert_true(sum == area);
        assert_true(common < 1e-6);
    }
}

/* Meeting and common area against the plainest way: counting squares of the grid whose centres lie in both. */
static void common_areas_are_right(void **state)
{
    (void)state;
    for (uint32_t n = 0; n < 300; n++) {
        pv_cell box[4], triangle[3];
        double work[28];
        pv_random r = pv_draw(5, 2, n, 0, 0);
        int32_t x = (int32_t)pv_below(r.word[0], 60), y = (int32_t)pv_below(r.word[1], 60);
        int32_t w = 1 + (int32_t)pv_below(r.word[2], 40), h = 1 + (int32_t)pv_below(r.word[3], 40);
        memcpy(box, (pv_cell[]){ { x, y }, { x, y + h }, { x + w, y + h }, { x + w, y } }, sizeof box);
        memcpy(triangle, (pv_cell[]){ { 20, 20 }, { 20, 60 }, { 60, 60 } }, sizeof triangle); /* below y = x */
        int64_t half = 0; /* half squares */
        for (int32_t sy = y > 20 ? y : 20; sy < y + h && sy < 60; sy++)
            for (int32_t sx = x > 20 ? x : 20; sx < x + w && sx < 60; sx++)
                half += sx < sy ? 2 : sx == sy;
        assert_near(pv_convex_common(box, 4, triangle, 3, work), half / 2.0);
        assert_near(pv_convex_common(triangle, 3, box, 4, work), half / 2.0);
        assert_int_equal(pv_convex_meet(box, 4, triangle, 3), half > 0);
        assert_int_equal(pv_convex_meet(triangle, 3, box, 4), half > 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(overlap_is_exact),
        cmocka_unit_test(shapes_are_told_apart),
        cmocka_unit_test(ground_is_looked_at_pixel_by_pixel),
        cmocka_unit_test(directions_and_joints_are_measured),
        cmocka_unit_test(every_way_to_write_a_stone_is_read),
        cmocka_unit_test(what_is_no_pavement_is_refused_with_a_sentence),
        cmocka_unit_test(damaged_files_do_no_damage),
        cmocka_unit_test(files_keep_what_is_measured),
        cmocka_unit_test(windows_are_measured_in_their_place),
        cmocka_unit_test(triangles_make_up_their_ring),
        cmocka_unit_test(common_areas_are_right),
    };
    return cmocka_run_group_tests(tests, open_all, close_all);
}
