/* Colour models of factored BTFs: log Y, U/Y, V/Y takes the range out of highlights (den Brok 2014, 3.1). */
#include "btf/btf.h"

#include <math.h>
#include <string.h>

static const float least = 1e-5f;

static void encode_yuv(const float *rgb, int64_t count, float *out)
{
    for (int64_t i = 0; i < count; i++, rgb += 3, out += 3) {
        float r = fmaxf(rgb[0], 0), g = fmaxf(rgb[1], 0), b = fmaxf(rgb[2], 0);
        float y = 0.299f * r + 0.587f * g + 0.114f * b + least;
        out[0] = logf(y);
        out[1] = (-0.14713f * r - 0.28886f * g + 0.436f * b) / y;
        out[2] = (0.615f * r - 0.51499f * g - 0.10001f * b) / y;
    }
}

static void decode_yuv(const float *yuv, int64_t count, float *out)
{
    for (int64_t i = 0; i < count; i++, yuv += 3, out += 3) {
        float whole = expf(yuv[0]), y = whole - least, u = yuv[1] * whole, v = yuv[2] * whole;
        out[0] = y + 1.13983f * v;
        out[1] = y - 0.39465f * u - 0.5806f * v;
        out[2] = y + 2.03211f * u;
    }
}

void pv_colour_encode(int32_t colour, int32_t channels, const float *samples, int64_t count, float *out)
{
    if (colour == PV_COLOUR_LOG_YUV)
        encode_yuv(samples, count, out);
    else if (colour == PV_COLOUR_LOG)
        for (int64_t i = 0; i < count * channels; i++)
            out[i] = logf(fmaxf(samples[i], 0) + least);
    else
        memcpy(out, samples, (size_t)(count * channels) * sizeof *out);
}

void pv_colour_decode(int32_t colour, int32_t channels, const float *values, int64_t count, float *out)
{
    if (colour == PV_COLOUR_LOG_YUV)
        decode_yuv(values, count, out);
    else if (colour == PV_COLOUR_LOG)
        for (int64_t i = 0; i < count * channels; i++)
            out[i] = expf(values[i]) - least;
    else
        memmove(out, values, (size_t)(count * channels) * sizeof *out);
}
