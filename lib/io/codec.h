/* What decodes and encodes image files: PNG and JPEG here, through libpng and libjpeg; all others in the module
 * pave-oiio.so, through OpenImageIO, which takes a quarter of a second to load. Plain C. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include <pave/image.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { PV_CODEC_VERSION = 3, PV_CODEC_TEXT = 512, PV_CODEC_NAMES = 2048 };

typedef struct pv_codec_job pv_codec_job;

typedef struct pv_picture {
    int32_t width, height, channels;
    int32_t type;   /* PAVE_U8 ... */
    int32_t linear; /* encoded: numbers are linear light, or data */
    int32_t alpha;
    int32_t columns, rows; /* a part that is read begins at a multiple of these, and ends at one or at the border */
    char names[PV_CODEC_NAMES]; /* "R,G,B" */
} pv_picture;

/* An encoded file: `bytes` if they are there, else what `read` gives of a place in it (0: failure), on any thread. */
typedef struct pv_codec_file {
    const void *bytes;
    size_t size;
    int32_t (*read)(void *user, int64_t offset, void *bytes, size_t size);
    void *user;
} pv_codec_file;

/* Takes `size` bytes of the encoded file for a place in it; 0 if that failed. */
typedef int32_t (*pv_codec_sink)(void *user, int64_t offset, const void *bytes, size_t size);

/* All functions return a pave_result; on failure `text` holds the reason, in one line, or nothing if the context has
 * been told. Rows are interleaved and of the picture's type; parts are read from the top to the bottom. A job is closed
 * in any case. */
typedef struct pv_codec {
    pave_result (*decode)(pave_context *context, const char *format, const pv_codec_file *file, pv_picture *picture,
                          pv_codec_job **job, char *text);
    pave_result (*read)(pv_codec_job *job, int32_t x, int32_t y, int32_t width, int32_t height, void *pixels,
                        char *text);
    pave_result (*encode)(pave_context *context, const char *format, const pv_picture *picture, pv_codec_sink sink,
                          void *user, pv_codec_job **job, char *text);
    pave_result (*write)(pv_codec_job *job, int32_t from, int32_t to, const void *pixels, char *text);
    pave_result (*finish)(pv_codec_job *job, char *text);
    void (*close)(pv_codec_job *job);
} pv_codec;

extern const pv_codec pv_png, pv_jpeg;

/* What the module exports as "pave_oiio_codec": NULL if it does not speak this version. */
typedef const pv_codec *(*pv_codec_entry)(int32_t version);

#ifdef __cplusplus
}
#endif
