/* Recognising image files, and what a file of its length can hold. */
#include "io/vet.h"

#include "image/image.h"

#include <string.h>

pave_result pv_damaged(pave_context *context, const pv_encoded *file, const char *kind, const char *reason)
{
    return pv_fail(context, PAVE_ERR_FORMAT, "%s: is a damaged %s file: %s", file->path, kind, reason);
}

static int begins(const pv_encoded *file, size_t at, const char *magic, size_t length)
{
    return file->size >= at + length && !memcmp(file->bytes + at, magic, length);
}

pave_result pv_vet(pave_context *context, pv_encoded *file, double share)
{
    file->whole = file->size;
    file->orientation = 1;
    if (begins(file, 0, "\x89PNG\r\n\x1A\n", 8))
        return pv_vet_png(context, file, share);
    if (begins(file, 0, "\xFF\xD8\xFF", 3))
        return pv_vet_jpeg(context, file);
    if (begins(file, 0, "II*\0", 4) || begins(file, 0, "MM\0*", 4) || begins(file, 0, "II+\0", 4) ||
        begins(file, 0, "MM\0+", 4))
        return pv_vet_tiff(context, file);
    if (file->size > 2 && file->bytes[0] == 'P' && file->bytes[1] >= '1' && file->bytes[1] <= '6' &&
        strchr(" \t\r\n#", file->bytes[2]) && file->bytes[2])
        return pv_vet_pnm(context, file);
    if (begins(file, 0, "RIFF", 4) && begins(file, 8, "WEBP", 4))
        return pv_vet_webp(context, file);
    return pv_fail(context, PAVE_ERR_FORMAT,
                   "%s: is not an image that pave reads (PNG, JPEG, TIFF, PNM, WebP, OpenEXR)", file->path);
}

pave_result pv_check_claims(pave_context *context, const pv_encoded *file)
{
    pave_result result = pv_check_size(context, file->path, file->width, file->height);
    if (result)
        return result;
    if (file->channels < 1 || file->channels > PV_MOST_CHANNELS)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: has %d channels, and 1 to %d can be read", file->path,
                       file->channels, PV_MOST_CHANNELS);
    double claimed = (double)file->width * (double)file->height * file->channels * file->bits / 8;
    if (file->expansion && claimed > (double)file->whole * file->expansion + 65536)
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
