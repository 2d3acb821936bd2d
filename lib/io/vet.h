/* Image files looked over before a decoder sees them: sizes read, damage found, metadata taken out. */
#pragma once

#include "io/input.h"

/* A part of what the decoder sees: bytes of the file, or others in their place. */
typedef struct pv_piece {
    int64_t from, size;
    const uint8_t *bytes; /* NULL: of the file */
} pv_piece;

enum { PV_MOST_PIECES = 8 };

/* A file to be decoded. Of it the decoder sees only what holds the picture: decoders have been hurt by colour profiles
 * and Exif, and some print to stderr about what they do not like. It sees `bytes` if they are there, else `pieces`. */
typedef struct pv_encoded {
    pv_input *input;
    const char *path;  /* for sentences */
    uint8_t *bytes;    /* the file, or in `pieces` what replaces a part of it; to be released */
    size_t size;       /* of what the decoder sees */
    size_t whole;      /* of the file */
    pv_piece pieces[PV_MOST_PIECES];
    int32_t piece_count; /* 0: all is in `bytes` */
    const char *format;  /* the decoder's name for it, "png" */
    int64_t width, height;
    int32_t channels, bits;  /* as stored */
    int32_t orientation;     /* EXIF, 1..8 */
    int32_t premultiplied;   /* colours are multiplied by alpha */
    int32_t expansion;       /* bytes of pixels that a byte of file can hold; 0: no telling */
    int64_t at_once;         /* bytes that a decoder must hold at once, about: the file, a strip of it, the picture */
} pv_encoded;

/* Recognises the format by the first bytes and vets the file; progress of 0..share of the stage. */
pave_result pv_vet(pave_context *context, pv_encoded *file, double share);

pave_result pv_vet_png(pave_context *context, pv_encoded *file, double share);
pave_result pv_vet_jpeg(pave_context *context, pv_encoded *file);
pave_result pv_vet_tiff(pave_context *context, pv_encoded *file);
pave_result pv_vet_pnm(pave_context *context, pv_encoded *file);
pave_result pv_vet_webp(pave_context *context, pv_encoded *file);

/* Adds to what the decoder sees; what follows on the piece before becomes one with it. */
void pv_keep(pv_encoded *file, int64_t from, int64_t size, const uint8_t *bytes);

/* Reads from what the decoder sees; 0 on failure, with errno set. Any thread may. */
int32_t pv_encoded_read(const pv_encoded *file, int64_t offset, void *bytes, int64_t size);

/* Bytes of the whole picture, as stored. */
double pv_picture_bytes(const pv_encoded *file);

/* The orientation that an EXIF block (a small TIFF) asks for; 1 if it does not. */
int32_t pv_exif_orientation(const uint8_t *bytes, size_t size);

/* Holds the size that the header gives against the limits and against what a file of this length can hold. Each
 * format asks as soon as it knows, before anything of the picture's size is made. */
pave_result pv_check_claims(pave_context *context, const pv_encoded *file);

/* PAVE_ERR_FORMAT: "PATH: is a damaged PNG file: REASON". */
pave_result pv_damaged(pave_context *context, const pv_encoded *file, const char *kind, const char *reason);

static inline uint32_t pv_be16(const uint8_t *p) { return (uint32_t)p[0] << 8 | p[1]; }
static inline uint32_t pv_be32(const uint8_t *p) { return pv_be16(p) << 16 | pv_be16(p + 2); }
static inline uint32_t pv_le16(const uint8_t *p) { return (uint32_t)p[1] << 8 | p[0]; }
static inline uint32_t pv_le32(const uint8_t *p) { return pv_le16(p + 2) << 16 | pv_le16(p); }
