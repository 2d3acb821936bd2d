/* libpave: drawings into pavements. The headers in story order, and the whole job in one call. */
#ifndef PAVE_PAVE_H
#define PAVE_PAVE_H

#include <pave/base.h>
#include <pave/context.h>
#include <pave/params.h>
#include <pave/image.h>
#include <pave/field.h>
#include <pave/cvd.h>
#include <pave/stones.h>
#include <pave/mosaic.h>
#include <pave/tiling.h>
#include <pave/solid.h>
#include <pave/btf.h>
#include <pave/statistics.h>
#include <pave/maps.h>
#include <pave/io.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Parameters of the stages; NULL: defaults. */
typedef struct pave_lay_params {
    size_t size;
    const pave_threshold_params *threshold;
    const pave_field_params *field;
    const pave_cvd_params *cvd;
    const pave_stones_params *stones;
    const pave_palette_params *palette; /* if it has colours or asks for some, it is used instead of threshold */
} pave_lay_params;

#define PAVE_LAY_PARAMS_INIT { sizeof(pave_lay_params), NULL, NULL, NULL, NULL, NULL }

PAVE_API void pave_lay_params_init(pave_lay_params *params, size_t size);

/* From an image to its stones: threshold or palette, field, diagram, stones. */
PAVE_API pave_result pave_lay(pave_context *context, const pave_image *image, const pave_lay_params *params,
                              pave_stones **out);

/* How a pavement is laid that is too large for memory: window after window. */
typedef struct pave_stream_params {
    size_t size;
    int64_t memory;     /* bytes that the whole process may take, so far as it is up to this call; 0: 1 GiB */
    const char *folder; /* where finished windows are kept until all are there; NULL: the first output + ".parts" */
} pave_stream_params;

#define PAVE_STREAM_PARAMS_INIT { sizeof(pave_stream_params), 0, NULL }

PAVE_API void pave_stream_params_init(pave_stream_params *params, size_t size);

/* From file to files, any size: the drawing is kept with one bit a pixel, windows are laid one after the other and
 * merged at the end into the same bytes as from pave_lay at once. What was finished stays in the folder until then: a
 * job that was ended begins where it was. The outputs may be .svg, .json or .stones. Of the limits, max_pixels holds
 * for the drawing; raise it for large ones. */
PAVE_API pave_result pave_lay_file(pave_context *context, const char *drawing, const pave_lay_params *params,
                                   const pave_stream_params *stream, const char *const *outputs, int32_t count);

/* The same for many processes or machines. pave_plan writes a plan, a JSON file with the windows, all parameters and
 * the drawing's hash, and tells the number of windows. pave_lay_shard lays one of them, 0 .. windows-1, into `output`,
 * or if that is NULL into the plan's name + ".parts/NNNNNN.stones": it does nothing if that is already there, and
 * leaves nothing half done, so it may be run again, and twice at once. pave_plan_merge puts the parts together, each of
 * the outputs (.svg, .json or .stones) in turn, and fails if one is missing; it leaves them where they are. */
PAVE_API pave_result pave_plan(pave_context *context, const char *drawing, const pave_lay_params *params,
                               const pave_stream_params *stream, const char *manifest, int32_t *windows);
PAVE_API pave_result pave_lay_shard(pave_context *context, const char *manifest, int32_t shard, const char *output);
PAVE_API pave_result pave_plan_merge(pave_context *context, const char *manifest, const char *const *outputs,
                                     int32_t count);

/* A graphics device or processor that a backend can run on. */
typedef struct pave_device {
    size_t size;
    int32_t backend;   /* PAVE_BACKEND_ */
    int32_t usable;    /* 0: `name` says why not */
    char name[256];
} pave_device;

/* Lists what the backends find on this machine: asks drivers, so it takes their start-up time. Writes up to
 * `capacity` entries (each entry's size must be set) and the number there are. */
PAVE_API pave_result pave_devices(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count);

#ifdef __cplusplus
}
#endif

#endif
