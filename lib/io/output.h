/* Output files: written beside their target and put in its place when complete. */
#pragma once

#include "base/context.h"

/* Errors stick: after the first one the writing functions do nothing, and pv_output_close reports it. */
typedef struct pv_output pv_output;

/* Begins a file. With `seeks`, pv_output_at may be used. Devices and pipes are written to directly, and with `seeks`
 * only at the end; "-" is standard output. */
pave_result pv_output_open(pave_context *context, const char *path, int seeks, pv_output **out);

void pv_output_bytes(pv_output *output, const void *bytes, size_t size);

/* Takes what pv_json writes; `output` is a pv_output. */
void pv_output_put(void *output, const char *text, size_t length);

void pv_output_text(pv_output *output, const char *text);
void pv_output_whole(pv_output *output, int64_t value);
void pv_output_thousandths(pv_output *output, int64_t value);

/* Writes at a place of one's own; the other functions go on where they were. 0 if it, or anything before, failed. */
int pv_output_at(pv_output *output, int64_t offset, const void *bytes, size_t size);

/* Has anything failed yet? */
int pv_output_failed(const pv_output *output);

/* After PAVE_OK puts the complete file in its place, otherwise drops it, and frees the output in any case. Returns
 * `result`, or else the first error of writing. */
pave_result pv_output_close(pv_output *output, pave_result result);

/* The same, after the first bytes of the file have been written over. */
pave_result pv_output_close_head(pv_output *output, pave_result result, const void *head, size_t size);

/* An empty file without a name in the folder of another; -1 and errno on failure. */
int pv_output_scratch(const char *beside);

/* What an errno means, in English in every locale. */
const char *pv_system_error(int error);
