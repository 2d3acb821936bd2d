/* Recognising image files, and what a file of its length can hold. */
#include "io/vet.h"

#include "image/image.h"

#include <string.h>

pave_result pv_damaged(pave_context *context, const pv_encoded *file, const char *kind, const char *reason)
{
    return pv_fail(context, PAVE_ERR_FORMAT, "%s: is a damaged %s file: %s", file->path, kind, reason);
}

void pv_keep(pv_encoded *file, int64_t from, int64_t size, const uint8_t *bytes)
{
    pv_piece *last = file->piece_count ? &file->pieces[file->piece_count - 1] : NULL;
    if (last && !last->bytes && !bytes && last->from + last->size == from)
        last->size += size;
    else
        file->pieces[file->piece_count++] = (pv_piece){ from, size, bytes };
    file->size += (size_t)size;
}

int32_t pv_encoded_read(const pv_encoded *file, int64_t offset, void *bytes, int64_t size)
{
    char *to = bytes;
    for (int32_t i = 0; i < file->piece_count && size; offset -= file->pieces[i++].size) {
        const pv_piece *piece = &file->pieces[i];
        if (offset >= piece->size)
            continue;
        int64_t n = size < piece->size - offset ? size : piece->size - offset;
        if (piece->bytes)
            memcpy(to, piece->bytes + offset, (size_t)n);
        else if (pv_read_at(file->input->file, piece->from + offset, to, n) < n)
            return 0;
        to += n, offset += n, size -= n;
    }
    return !size;
}

double pv_picture_bytes(const pv_encoded *file)
{
    return (double)file->width * (double)file->height * file->channels * file->bits / 8;
}

/* Formats whose pictures cannot be had in parts. */
static pave_result load(pave_context *context, pv_encoded *file, pave_result (*vet)(pave_context *, pv_encoded *))
{
    pave_result result = pv_input_load(file->input, &file->bytes);
    return result ? result : vet(context, file);
}

static int begins(const uint8_t *head, const char *magic, size_t length)
{
    return !memcmp(head, magic, length);
}

pave_result pv_vet(pave_context *context, pv_encoded *file, double share)
{
    uint8_t head[16] = { 0 };
    file->at_once = file->input->size;
    file->size = file->whole = (size_t)file->at_once;
    file->orientation = 1;
    pave_result result = pv_input_read(file->input, 0, head, file->at_once < 16 ? file->at_once : 16);
    if (result)
        return result;
    if (begins(head, "\x89PNG\r\n\x1A\n", 8))
        return pv_vet_png(context, file, share);
    if (begins(head, "\xFF\xD8\xFF", 3))
        return load(context, file, pv_vet_jpeg);
    if (begins(head, "II*\0", 4) || begins(head, "MM\0*", 4) || begins(head, "II+\0", 4) || begins(head, "MM\0+", 4))
        return pv_vet_tiff(context, file);
    if (head[0] == 'P' && head[1] >= '1' && head[1] <= '6' && strchr(" \t\r\n#", head[2]) && head[2])
        return load(context, file, pv_vet_pnm);
    if (begins(head, "RIFF", 4) && begins(head + 8, "WEBP", 4))
        return load(context, file, pv_vet_webp);
    return pv_fail(context, PAVE_ERR_FORMAT,
                   "%s: is not an image that pave reads (PNG, JPEG, TIFF, PNM, WebP, OpenEXR, Radiance)", file->path);
}

pave_result pv_check_claims(pave_context *context, const pv_encoded *file)
{
    pave_result result = pv_check_size(context, file->path, file->width, file->height);
    if (result)
        return result;
    if (file->channels < 1 || file->channels > PV_MOST_CHANNELS)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: has %d channels, and 1 to %d can be read", file->path,
                       file->channels, PV_MOST_CHANNELS);
    if (file->expansion && pv_picture_bytes(file) > (double)file->whole * file->expansion + 65536)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: claims %lld x %lld px, more than a file of %zu bytes can hold",
                       file->path, (long long)file->width, (long long)file->height, file->whole);
    return PAVE_OK;
}

enum { EXIF_ORIENTATION = 274 };

int32_t pv_exif_orientation(const uint8_t *bytes, size_t size)
{
    if (size < 8 || (memcmp(bytes, "II*\0", 4) && memcmp(bytes, "MM\0*", 4)))
        return 1;
    int big = bytes[0] == 'M';
    uint32_t (*word)(const uint8_t *) = big ? pv_be16 : pv_le16;
    size_t at = big ? pv_be32(bytes + 4) : pv_le32(bytes + 4);
    if (at > size - 2)
        return 1;
    uint32_t entries = word(bytes + at);
    for (at += 2; entries-- && at + 12 <= size; at += 12)
        if (word(bytes + at) == EXIF_ORIENTATION && word(bytes + at + 2) == 3) {
            uint32_t value = word(bytes + at + 8);
            return value >= 1 && value <= 8 ? (int32_t)value : 1;
        }
    return 1;
}
