/* What the formats of volumes share: heads of text, and the values behind them. */
#pragma once

#include "io/input.h"
#include "io/output.h"
#include "solid/solid.h"

enum { PV_VOLUME_HEAD = 4096, PV_VOLUME_CHUNK = 1 << 20, PV_VOLUME_NUMBER = 40, PV_VOLUME_PATH = 4096 };

/* A head as it grows. */
typedef struct pv_volume_head {
    char text[PV_VOLUME_HEAD];
    size_t length;
} pv_volume_head;

void pv_head_text(pv_volume_head *h, const char *text);
void pv_head_number(pv_volume_head *h, double value);
void pv_head_whole(pv_volume_head *h, int64_t value);

/* What a head says. */
typedef struct pv_volume_layout {
    pave_volume_params place;
    int64_t data; /* where values begin */
    int packed, big;
    char file[PV_VOLUME_PATH]; /* values lie in another file */
} pv_volume_layout;

/* All numbers of a line, whatever stands between them; returns how many. */
int pv_volume_reals(const char *text, double *out, int most);

size_t pv_volume_bytes(const pave_volume *v);
pave_result pv_volume_put(pave_context *context, pv_output *output, const pave_volume *v);
/* NaN is a voxel without a value. */
void pv_volume_set_states(pave_volume *v);

typedef pave_result pv_volume_writer(pave_context *context, const pave_volume *volume, const char *path);
pv_volume_writer pv_nrrd_write, pv_nrrd_write_gzip, pv_raw_write, pv_vti_write, pv_tiff_write;

/* `text` ends with a 0. */
pave_result pv_nrrd_read_head(pave_context *context, const char *path, char *text, pv_volume_layout *l);
pave_result pv_vti_read_head(pave_context *context, const char *path, char *text, int64_t length,
                             pv_volume_layout *l);
pave_result pv_nrrd_inflate(pave_context *context, const char *path, const uint8_t *bytes, int64_t size,
                            pave_volume *v);
pave_result pv_tiff_read(pave_context *context, const char *path, pave_volume **out);
