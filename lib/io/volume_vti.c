/* VTK image data: one raw appended array. */
#include "io/volume.h"

#include <stdlib.h>
#include <string.h>

static void vti_head(const pave_volume *v, pv_volume_head *h)
{
    h->length = 0;
    pv_head_text(h, "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<ImageData WholeExtent=\"");
    for (int a = 0; a < 3; a++)
        pv_head_text(h, "0 "), pv_head_whole(h, v->size[a] - 1), pv_head_text(h, a < 2 ? " " : "\" Origin=\"");
    for (int a = 0; a < 3; a++)
        pv_head_number(h, v->origin[a]), pv_head_text(h, a < 2 ? " " : "\" Spacing=\"");
    for (int a = 0; a < 3; a++)
        pv_head_number(h, v->spacing), pv_head_text(h, a < 2 ? " " : "\">\n<Piece Extent=\"");
    for (int a = 0; a < 3; a++)
        pv_head_text(h, "0 "), pv_head_whole(h, v->size[a] - 1), pv_head_text(h, a < 2 ? " " : "\">\n");
    pv_head_text(h, "<PointData Scalars=\"stone\">\n<DataArray type=\"");
    pv_head_text(h, v->type == PAVE_U8 ? "UInt8" : v->type == PAVE_U16 ? "UInt16" : "Float32");
    pv_head_text(h, "\" Name=\"stone\" NumberOfComponents=\"");
    pv_head_whole(h, v->channels);
    pv_head_text(h, "\" format=\"appended\" offset=\"0\"/>\n</PointData>\n</Piece>\n</ImageData>\n"
           "<AppendedData encoding=\"raw\">\n_");
}

pave_result pv_vti_write(pave_context *context, const pave_volume *v, const char *path)
{
    pv_output *output;
    pv_volume_head h;
    uint64_t bytes = pv_volume_bytes(v);
    vti_head(v, &h);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    pv_output_text(output, h.text);
    pv_output_bytes(output, &bytes, sizeof bytes);
    result = pv_volume_put(context, output, v);
    pv_output_text(output, "\n</AppendedData>\n</VTKFile>\n");
    return pv_output_close(output, result);
}

pave_result pv_vti_read_head(pave_context *context, const char *path, char *text, int64_t length, pv_volume_layout *l)
{
    const char *extent = strstr(text, "WholeExtent=\""), *type = strstr(text, "<DataArray type=\"");
    const char *parts = strstr(text, "NumberOfComponents=\""), *data = memmem(text, (size_t)length, "\n_", 2);
    const char *origin = strstr(text, "Origin=\""), *spacing = strstr(text, "Spacing=\"");
    double e[6], s[3];
    if (!extent || !type || !data || !strstr(text, "encoding=\"raw\"") || !strstr(text, "UInt64") ||
        pv_volume_reals(extent, e, 6) != 6)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: of VTK image data, one raw appended array is read", path);
    l->place.width = (int32_t)(e[1] - e[0]) + 1;
    l->place.height = (int32_t)(e[3] - e[2]) + 1;
    l->place.depth = (int32_t)(e[5] - e[4]) + 1;
    type += strlen("<DataArray type=\"");
    l->place.type = !strncmp(type, "UInt8\"", 6) ? PAVE_U8 : !strncmp(type, "UInt16\"", 7) ? PAVE_U16
                    : !strncmp(type, "Float32\"", 8) ? PAVE_F32 : 0;
    l->place.channels = parts ? atoi(parts + strlen("NumberOfComponents=\"")) : 1;
    if (origin)
        pv_volume_reals(origin + 8, l->place.origin, 3);
    if (spacing && pv_volume_reals(spacing + 9, s, 3) == 3)
        l->place.spacing = s[0];
    l->data = data - text + 2 + (int64_t)sizeof(uint64_t);
    return PAVE_OK;
}
