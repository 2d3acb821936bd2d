/* Colour models of factored BTFs: log Y, U/Y, V/Y takes the range out of highlights (den Brok 2014, 3.1). */
#include "btf/btf.h"

#include <math.h>
#include <string.h>

static void encode_yuv(float least, const float *rgb, int64_t count, float *out)
{
    for (int64_t i = 0; i < count; i++, rgb += 3, out += 3) {
        float r = rgb[0] > 0 ? rgb[0] : 0, g = rgb[1] > 0 ? rgb[1] : 0, b = rgb[2] > 0 ? rgb[2] : 0;
        float y = 0.299f * r + 0.587f * g + 0.114f * b + least;
        out[0] = logf(y);
        out[1] = (-0.14713f * r - 0.28886f * g + 0.436f * b) / y;
        out[2] = (0.615f * r - 0.51499f * g - 0.10001f * b) / y;
    }
}

void pv_colour_encode(int32_t colour, float least, int32_t channels, const float *samples, int64_t count, float *out)
{
    if (colour == PV_COLOUR_LOG_YUV)
        encode_yuv(least, samples, count, out);
    else if (colour == PV_COLOUR_LOG)
        for (int64_t i = 0; i < count * channels; i++)
            out[i] = logf(fmaxf(samples[i], 0) + least);
    else
        memcpy(out, samples, (size_t)(count * channels) * sizeof *out);
}

int pv_colour_known(int32_t colour)
{
    return colour == PV_COLOUR_RGB || colour == PV_COLOUR_SPECTRAL || colour == PV_COLOUR_LOG ||
           pv_colour_is_triple(colour);
}

int pv_colour_is_triple(int32_t colour)
{
    return colour == PV_COLOUR_YUV || colour == PV_COLOUR_PCA || colour == PV_COLOUR_YCOCG ||
           (colour >= PV_COLOUR_LOG_Y_UV && colour <= PV_COLOUR_LOG_YUV);
}

static void from_yuv(float y, float u, float v, float *out)
{
    out[0] = y + 1.13983f * v;
    out[1] = y - 0.39465f * u - 0.5806f * v;
    out[2] = y + 2.03211f * u;
}

static void from_space(const float space[12], const float *in, float *out)
{
    for (int32_t c = 0; c < 3; c++)
        out[c] = space[c] + in[0] * space[3 + c] + in[1] * space[6 + c] + in[2] * space[9 + c];
}

static void decode_triple(int32_t colour, float least, const float space[12], const float in[3], float *out)
{
    float whole = colour >= PV_COLOUR_LOG_Y_UV ? expf(in[0]) : 0, y = whole - least;
    switch (colour) {
    case PV_COLOUR_YUV: from_yuv(in[0], in[1], in[2], out); break;
    case PV_COLOUR_PCA: from_space(space, in, out); break;
    case PV_COLOUR_YCOCG:
        out[0] = in[0] + in[1] - in[2];
        out[1] = in[0] + in[2];
        out[2] = in[0] - in[1] - in[2];
        break;
    case PV_COLOUR_LOG_Y_UV: from_yuv(y, in[1], in[2], out); break;
    case PV_COLOUR_LOGS_YUV: from_yuv(y, expf(in[1]) - least, expf(in[2]) - least, out); break;
    default: from_yuv(y, in[1] * whole, in[2] * whole, out);
    }
}

void pv_colour_decode(int32_t colour, float least, const float space[12], int32_t channels, const float *values,
                      int64_t count, float *out)
{
    if (pv_colour_is_triple(colour))
        for (int64_t i = 0; i < count; i++)
            decode_triple(colour, least, space, values + 3 * i, out + 3 * i);
    else if (colour == PV_COLOUR_LOG)
        for (int64_t i = 0; i < count * channels; i++)
            out[i] = expf(values[i]) - least;
    else
        memmove(out, values, (size_t)(count * channels) * sizeof *out);
}

pave_result pv_colour_choose(pave_context *context, int32_t asked, int32_t channels, int32_t joint, int32_t *colour)
{
    static const int32_t known[4] = { -1, PV_COLOUR_LOG_YUV, PV_COLOUR_LOG, PV_COLOUR_RGB };
    *colour = known[asked];
    if (!asked)
        *colour = channels == 3 && !joint ? PV_COLOUR_LOG_YUV : PV_COLOUR_LOG;
    if (*colour == PV_COLOUR_LOG_YUV && joint)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "joint factors are of plain samples or of their logarithms");
    if (*colour == PV_COLOUR_LOG_YUV && channels != 3)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "log-yuv is for three channels, and this BTF has %d", (int)channels);
    return PAVE_OK;
}
