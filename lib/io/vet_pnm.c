/* PNM files: the header, and enough bytes to follow it. */
#include "io/vet.h"

/* A number of the header after white space and comments; -1 if there is none. */
static int64_t header_number(const pv_encoded *file, size_t *at)
{
    const uint8_t *p = file->bytes + *at, *end = file->bytes + file->size;
    while (p < end && (*p == ' ' || (*p >= '\t' && *p <= '\r') || *p == '#')) {
        if (*p == '#')
            while (p < end && *p != '\n')
                p++;
        else
            p++;
    }
    int64_t value = p < end && *p >= '0' && *p <= '9' ? 0 : -1;
    for (; p < end && *p >= '0' && *p <= '9'; p++)
        value = value > INT32_MAX ? value : value * 10 + (*p - '0');
    *at = (size_t)(p - file->bytes);
    return value;
}

pave_result pv_vet_pnm(pave_context *context, pv_encoded *file)
{
    int kind = file->bytes[1] - '0', bitmap = kind == 1 || kind == 4;
    size_t at = 2;
    file->format = "pnm";
    file->expansion = 8;
    file->channels = kind % 3 == 0 ? 3 : 1;
    file->width = header_number(file, &at);
    file->height = header_number(file, &at);
    int64_t most = bitmap ? 1 : header_number(file, &at);
    if (file->width < 1 || file->height < 1 || most < 1 || most > 65535 || at >= file->size)
        return pv_damaged(context, file, "PNM", "its header is incomplete");
    file->bits = bitmap ? 1 : most < 256 ? 8 : 16;
    pave_result result = pv_check_claims(context, file);
    double samples = (double)file->width * (double)file->height * file->channels; /* P1 .. P3: a byte each at least */
    double raw = kind == 4 ? (double)((file->width + 7) / 8 * file->height) : samples * file->bits / 8;
    if (!result && (kind > 3 ? raw : samples) > (double)(file->size - at))
        result = pv_damaged(context, file, "PNM", "it is cut short");
    return result;
}
