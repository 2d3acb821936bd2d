/* Laying window by window, from inside: what pave_lay_file and plans share. */
#pragma once

#include "io/drawing.h"
#include "io/manifest.h"

enum { PV_PATH = 4096, PV_PART = 32 /* of the name of a part, behind its folder */ };

typedef struct pv_stream {
    pave_context *context;
    pv_manifest plan; /* margin: px of drawing that are laid around a window */
    pv_bitmap drawing;
    char folder[PV_PATH]; /* of the parts */
} pv_stream;

pv_stream *pv_stream_begin(pave_context *context, pave_result *result);
void pv_stream_end(pv_stream *s);

/* Reads the drawing, by the plan's threshold, and names it; progress of 0..to of the stage. */
pave_result pv_stream_read(pv_stream *s, const char *drawing, pv_room room, double to, uint64_t *hash);

/* The same, and plans its windows within a memory (0: the default). */
pave_result pv_stream_plan(pv_stream *s, const char *drawing, const pave_lay_params *params, int64_t memory,
                           const char *beside, double to);

/* What windows of the plan may take; a plan does not say what memory it was made for. */
pv_room pv_stream_room(const pv_stream *s, const char *beside);

/* Where parts are: the folder, or if that is NULL the output's name and ".parts". */
pave_result pv_stream_set_folder(pv_stream *s, const char *folder, const char *output);
pave_result pv_stream_make_folder(const pv_stream *s);
void pv_stream_part(const pv_stream *s, int32_t k, char path[PV_PATH + PV_PART]);
int32_t pv_stream_windows(const pv_stream *s);

/* Lays a window into a file, unless it lies there. */
pave_result pv_stream_lay(pv_stream *s, int32_t k, const char *path);

/* Merges the parts into files. */
pave_result pv_stream_merge(pv_stream *s, const char *const *outputs, int32_t count);
