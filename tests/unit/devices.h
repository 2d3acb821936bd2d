/* The backends of this machine, and that they agree: what tests of diagrams share. */
#pragma once

#include "test.h"

enum { MOST_BACKENDS = 32 };

/* The usable backends of this machine, the CPU's first. Drivers leak, and lock as they like: under a sanitizer they are
 * not even asked. */
static inline int32_t usable_backends(pave_context *context, int32_t *backends)
{
    pave_device devices[MOST_BACKENDS];
    int32_t count = 0, usable = 0;
    for (int i = 0; i < MOST_BACKENDS; i++)
        devices[i].size = sizeof *devices;
    backends[usable++] = PAVE_BACKEND_CPU;
    backends[usable++] = PAVE_BACKEND_CPU_PORTABLE;
    if (SANITIZED)
        return usable;
    assert_ok(pave_devices(context, devices, MOST_BACKENDS - 2, &count));
    for (int32_t i = 0; i < count && i < MOST_BACKENDS - 2; i++)
        if (devices[i].usable && devices[i].backend > PAVE_BACKEND_CPU_REFERENCE)
            backends[usable++] = devices[i].backend;
    return usable;
}

static inline int is_usable(pave_context *context, int32_t backend)
{
    int32_t backends[MOST_BACKENDS], count = usable_backends(context, backends);
    for (int32_t i = 0; i < count; i++)
        if (backends[i] == backend)
            return 1;
    return 0;
}

static inline void assert_same_diagram(const pave_cvd *a, const pave_cvd *b)
{
    size_t pixels = (size_t)pave_cvd_width(a) * (size_t)pave_cvd_height(a);
    assert_int_equal(pave_cvd_site_count(a), pave_cvd_site_count(b));
    assert_memory_equal(pave_cvd_labels(a), pave_cvd_labels(b), pixels * sizeof(int32_t));
    assert_memory_equal(pave_cvd_sites(a), pave_cvd_sites(b), (size_t)pave_cvd_site_count(a) * sizeof(pave_site));
}

/* The backend's diagram of a field, which must be the one that is known. */
static inline void assert_agrees(const pave_field *field, const pave_cvd_params *params, int32_t threads,
                                 int32_t backend, const pave_cvd *expected)
{
    pave_context *context = make_context(threads, backend);
    pave_cvd *got = NULL;
    assert_ok(pave_cvd_create(context, field, params, &got));
    assert_int_equal(pave_cvd_backend(got), backend);
    assert_same_diagram(got, expected);
    print_message("  %s agrees\n", pave_cvd_backend_name(got));
    pave_cvd_free(&got);
    pave_context_free(&context);
}
