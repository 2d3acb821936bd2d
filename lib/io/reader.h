/* Little-endian numbers from bytes in memory. Whoever asks for more than there are gets zeros, and is told by `cut`. */
#pragma once

#include "base/context.h"

#include <string.h>

typedef struct pv_reader {
    pave_context *context;
    const char *path; /* for sentences */
    const uint8_t *begin, *at, *end;
    int cut;
} pv_reader;

static inline pv_reader pv_reader_of(pave_context *context, const char *path, const uint8_t *bytes, size_t size)
{
    return (pv_reader){ context, path, bytes, bytes, bytes + size, 0 };
}

static inline uint64_t pv_left(const pv_reader *r)
{
    return (uint64_t)(r->end - r->at);
}

static inline const uint8_t *pv_take(pv_reader *r, uint64_t count)
{
    const uint8_t *at = r->at;
    if (r->cut || count > pv_left(r)) {
        r->cut = 1;
        return NULL;
    }
    r->at += count;
    return at;
}

static inline uint8_t pv_byte(pv_reader *r)
{
    const uint8_t *p = pv_take(r, 1);
    return p ? *p : 0;
}

static inline uint32_t pv_word(pv_reader *r)
{
    const uint8_t *p = pv_take(r, 4);
    return p ? (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24 : 0;
}

static inline float pv_real(pv_reader *r)
{
    uint32_t bits = pv_word(r);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline double pv_number(pv_reader *r)
{
    uint64_t low = pv_word(r), bits = low | (uint64_t)pv_word(r) << 32;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
