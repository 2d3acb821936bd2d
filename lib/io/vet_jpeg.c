/* JPEG files: the segments up to the end of the image. Profiles, Exif and comments are left out.
 * Source: ITU-T T.81, annex B. */
#include "io/vet.h"

#include <string.h>

enum { EXPANSION = 1100, SCANS = 1000 };
enum { SOF0 = 0xC0, DHT = 0xC4, JPG = 0xC8, DAC = 0xCC, RST0 = 0xD0, EOI = 0xD9, SOS = 0xDA, APP0 = 0xE0, APP1 = 0xE1,
       APP14 = 0xEE, JPG0 = 0xF0, COM = 0xFE };

typedef struct jpeg_file {
    pave_context *context;
    pv_encoded *file;
    size_t read, written;
    int frame, scans;
} jpeg_file;

static pave_result damaged(const jpeg_file *jpeg, const char *reason)
{
    return pv_damaged(jpeg->context, jpeg->file, "JPEG", reason);
}

static pave_result read_frame(jpeg_file *jpeg, int marker, const uint8_t *data, size_t length)
{
    pv_encoded *file = jpeg->file;
    if (jpeg->frame++)
        return damaged(jpeg, "it has two frame headers");
    if (length < 6 || length != 6 + 3 * (size_t)data[5])
        return damaged(jpeg, "its frame header has a wrong length");
    file->bits = data[0];
    file->height = pv_be16(data + 1);
    file->width = pv_be16(data + 3);
    file->channels = data[5];
    if (file->bits != 8 || (marker & 3) == 3 || (marker & 7) > 4)
        return pv_fail(jpeg->context, PAVE_ERR_UNSUPPORTED,
                       "%s: is a JPEG file of a kind that is not read (lossless, hierarchical or 12 bits)", file->path);
    if (file->channels != 1 && file->channels != 3 && file->channels != 4)
        return damaged(jpeg, "it has neither 1, 3 nor 4 channels");
    pave_result result = pv_check_claims(jpeg->context, file);
    if (!result && (marker & 3) == 2) /* progressive: all coefficients */
        file->at_once += 2 * (int64_t)pv_picture_bytes(file);
    return result;
}

/* Entropy-coded data run up to the next marker that is neither a stuffed byte nor a restart. */
static size_t scan_end(const pv_encoded *file, size_t at)
{
    while (at + 1 < file->size) {
        const uint8_t *p = memchr(file->bytes + at, 0xFF, file->size - 1 - at);
        if (!p)
            break;
        at = (size_t)(p - file->bytes);
        if (p[1] && p[1] != 0xFF && (p[1] & 0xF8) != RST0)
            return at;
        at += p[1] == 0xFF ? 1 : 2;
    }
    return file->size;
}

static void keep(jpeg_file *jpeg, size_t from, size_t to)
{
    memmove(jpeg->file->bytes + jpeg->written, jpeg->file->bytes + from, to - from);
    jpeg->written += to - from;
}

static int wanted(int marker, const uint8_t *data, size_t length)
{
    if (marker == APP0)
        return length >= 5 && !memcmp(data, "JFIF", 5);
    if (marker == APP14)
        return length >= 12 && !memcmp(data, "Adobe", 5);
    return marker < APP0;
}

static pave_result take_segment(jpeg_file *jpeg, int marker, size_t from, size_t length)
{
    pv_encoded *file = jpeg->file;
    const uint8_t *data = file->bytes + from + 4;
    pave_result result = PAVE_OK;
    if (marker >= SOF0 && marker <= 0xCF && marker != DHT && marker != JPG && marker != DAC)
        result = read_frame(jpeg, marker, data, length);
    if (marker == APP1 && length >= 6 && !memcmp(data, "Exif\0", 6))
        file->orientation = pv_exif_orientation(data + 6, length - 6);
    if (marker == SOS && !jpeg->frame)
        return damaged(jpeg, "its picture comes before its frame header");
    if (marker == SOS && jpeg->scans++ == SCANS)
        return pv_fail(jpeg->context, PAVE_ERR_LIMIT, "%s: has more than %d scans", file->path, SCANS);
    jpeg->read = from + 4 + length;
    if (marker == SOS)
        jpeg->read = scan_end(file, jpeg->read);
    if (!result && wanted(marker, data, length))
        keep(jpeg, from, jpeg->read);
    return result;
}

static pave_result walk_segments(jpeg_file *jpeg)
{
    const pv_encoded *file = jpeg->file;
    for (pave_result result = PAVE_OK; !result;) {
        size_t from = jpeg->read;
        while (from + 1 < file->size && file->bytes[from] == 0xFF && file->bytes[from + 1] == 0xFF)
            from++;
        if (from + 1 >= file->size)
            return damaged(jpeg, "it is cut short");
        int marker = file->bytes[from + 1];
        if (file->bytes[from] != 0xFF || marker < SOF0)
            return damaged(jpeg, "a segment does not begin with a marker");
        if (marker == EOI) {
            keep(jpeg, from, from + 2);
            return jpeg->scans ? PAVE_OK : damaged(jpeg, "it holds no picture");
        }
        size_t length = from + 4 <= file->size ? pv_be16(file->bytes + from + 2) : 0;
        if (length < 2 || from + 2 + length > file->size)
            return damaged(jpeg, from + 4 <= file->size && length < 2 ? "a segment has a wrong length"
                                                                      : "it is cut short");
        result = take_segment(jpeg, marker, from, length - 2);
        if (result)
            return result;
    }
    return PAVE_OK;
}

pave_result pv_vet_jpeg(pave_context *context, pv_encoded *file)
{
    jpeg_file jpeg = { context, file, 2, 2, 0, 0 };
    file->format = "jpeg";
    file->expansion = EXPANSION;
    pave_result result = walk_segments(&jpeg);
    file->size = jpeg.written;
    return result;
}
