/* WebP files: the size of the canvas. Source: RFC 9649. */
#include "io/vet.h"

#include <string.h>

enum { EXPANSION = 1 << 17 }; /* lossless WebP codes long runs in next to nothing */

static void canvas_size(pv_encoded *file, const uint8_t *chunk)
{
    const uint8_t *data = chunk + 8;
    file->channels = 4;
    if (!memcmp(chunk, "VP8X", 4)) {
        file->width = (pv_le32(data + 4) & 0xFFFFFF) + 1;
        file->height = (pv_le32(data + 6) >> 8) + 1;
    } else if (!memcmp(chunk, "VP8L", 4)) {
        uint32_t sizes = pv_le32(data + 1);
        file->width = (sizes & 0x3FFF) + 1;
        file->height = (sizes >> 14 & 0x3FFF) + 1;
    } else {
        file->channels = 3;
        file->width = pv_le16(data + 6) & 0x3FFF;
        file->height = pv_le16(data + 8) & 0x3FFF;
    }
}

pave_result pv_vet_webp(pave_context *context, pv_encoded *file)
{
    file->format = "webp";
    file->expansion = EXPANSION;
    file->bits = 8;
    file->premultiplied = 1; /* that is how OpenImageIO delivers it, whatever is asked for */
    if (file->size < 30 || pv_le32(file->bytes + 4) > file->size - 8)
        return pv_damaged(context, file, "WebP", "it is cut short");
    const uint8_t *chunk = file->bytes + 12;
    if (memcmp(chunk, "VP8", 3) || !strchr("XL ", chunk[3]) || !chunk[3])
        return pv_damaged(context, file, "WebP", "it does not begin with a picture");
    canvas_size(file, chunk);
    size_t at = 12;
    while (at + 8 <= file->size) {
        uint32_t length = pv_le32(file->bytes + at + 4);
        if (length > file->size - at - 8)
            return pv_damaged(context, file, "WebP", "it is cut short");
        const uint8_t *data = file->bytes + at + 8;
        int prefix = length >= 6 && !memcmp(data, "Exif\0", 6) ? 6 : 0;
        if (!memcmp(file->bytes + at, "EXIF", 4))
            file->orientation = pv_exif_orientation(data + prefix, length - (size_t)prefix);
        at += 8 + (size_t)length + (length & 1);
    }
    pave_result result = pv_check_claims(context, file);
    if (!result)
        file->at_once += (int64_t)pv_picture_bytes(file);
    return result;
}
