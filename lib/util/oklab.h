/* OKLab (Ottosson 2020), a space in which distances are about as large as they look, in whole numbers and without
 * libm: the same on every machine. */
#pragma once

#include <stdint.h>

enum { PV_LAB_ONE = 16384, PV_LIGHT_ONE = 65536 };

typedef struct pv_rgb {
    uint8_t r, g, b; /* display values (sRGB) */
} pv_rgb;

typedef struct pv_lab {
    int32_t l, a, b; /* 1/16384 */
} pv_lab;

typedef struct pv_oklab {
    int32_t light[256];                /* linear light of display values, 1/65536 */
    uint16_t root[PV_LIGHT_ONE + 1];   /* cube roots, 1/16384 */
} pv_oklab;

/* Fills the tables: a millisecond. */
void pv_oklab_begin(pv_oklab *tables);

pv_lab pv_oklab_of(const pv_oklab *tables, pv_rgb colour);

/* The display value that is nearest to a linear light. */
uint8_t pv_display_of(const pv_oklab *tables, int64_t light);

static inline int64_t pv_lab_distance(pv_lab p, pv_lab q)
{
    int64_t l = p.l - q.l, a = p.a - q.a, b = p.b - q.b;
    return l * l + a * a + b * b;
}
