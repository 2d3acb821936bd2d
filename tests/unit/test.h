/* What every unit test includes: cmocka, and contexts that tell what went wrong. */
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <pave/pave.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define assert_ok(call) assert_int_equal((call), PAVE_OK)

/* Sanitizers look at paths, not at sizes and figures: under one, a case may be as small as still takes them all, with
 * several tasks for each thread. The thread sanitizer slows down most. */
#if defined(PAVE_SANITIZED_THREAD)
enum { SANITIZED = 1, THREAD_SANITIZED = 1 };
#elif defined(PAVE_SANITIZED)
enum { SANITIZED = 1, THREAD_SANITIZED = 0 };
#else
enum { SANITIZED = 0, THREAD_SANITIZED = 0 };
#endif

/* Skips, under the thread sanitizer, a case whose point is a figure that needs its size, or that has one thread. */
static inline void not_for_threads(void)
{
    if (THREAD_SANITIZED)
        skip();
}

static inline pave_context *make_context(int32_t threads, int32_t backend)
{
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *context = NULL;
    params.threads = threads;
    params.backend = backend;
    assert_ok(pave_context_create(&params, &context));
    return context;
}

/* Group set-up and tear-down of tests that share one context: their state. */
static inline int open_context(void **state)
{
    *state = make_context(2, PAVE_BACKEND_CPU);
    return 0;
}

static inline int close_context(void **state)
{
    pave_context *context = *state;
    pave_context_free(&context);
    return 0;
}

/* An image of one 8-bit channel; its pixels are freed. */
static inline pave_image *take_pixels(pave_context *context, int32_t width, int32_t height, uint8_t *pixels)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = width;
    params.height = height;
    assert_ok(pave_image_create(context, &params, pixels, &image));
    free(pixels);
    return image;
}

/* A drawing from text: '#' is black, anything else white; all rows as long as the first. */
static inline pave_image *draw_text(pave_context *context, const char *const *rows, int32_t height)
{
    int32_t width = (int32_t)strlen(rows[0]);
    uint8_t *pixels = malloc((size_t)width * (size_t)height);
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++)
            pixels[y * width + x] = rows[y][x] == '#' ? 0 : 255;
    return take_pixels(context, width, height, pixels);
}

/* A ring, a bar and a slanted line: straight and curved edges, thin and thick. */
static inline pave_image *draw_shapes(pave_context *context, int32_t width, int32_t height)
{
    uint8_t *pixels = malloc((size_t)width * (size_t)height);
    int64_t side = width < height ? width : height;
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            int64_t dx = x - width / 3, dy = y - height / 2, r = dx * dx + dy * dy;
            int ring = r * 9 < side * side && r * 25 > side * side;
            int bar = x > width * 3 / 4 && x < width * 7 / 8, line = labs((long)(3 * y - 2 * x)) < 12;
            pixels[(int64_t)y * width + x] = ring || bar || line ? 0 : 255;
        }
    return take_pixels(context, width, height, pixels);
}

/* Copies of an image of one 8-bit channel, side by side. */
static inline pave_image *repeat_image(pave_context *context, const pave_image *image, int32_t columns, int32_t rows)
{
    int32_t width = pave_image_width(image), height = pave_image_height(image), across = columns * width;
    const uint8_t *from = pave_image_pixels(image);
    uint8_t *pixels = malloc((size_t)across * (size_t)(rows * height));
    for (int32_t y = 0; y < rows * height; y++)
        for (int32_t x = 0; x < across; x++)
            pixels[(int64_t)y * across + x] = from[(int64_t)(y % height) * width + x % width];
    return take_pixels(context, across, rows * height, pixels);
}

static inline uint64_t hash_bytes(const void *data, size_t size)
{
    const unsigned char *bytes = data;
    uint64_t hash = 14695981039346656037u;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}
