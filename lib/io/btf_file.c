/* BTF files: which format, and who does it. */
#include "io/bonn.h"

#include <pave/io.h>

#include "io/big.h"
#include "io/exr_btf.h"
#include "io/folder.h"
#include "io/input.h"
#include "io/output.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static const pave_btf_file_params default_params = PAVE_BTF_FILE_PARAMS_INIT;

static const pv_param file_rows[] = {
    PV_CHOICE(pave_btf_file_params, gamma, "srgb|2.2", "what is undone of pictures of 8 and 16 bits"),
    PV_CHOICE(pave_btf_file_params, pictures, "exr|png", "what a folder is written as"),
};

extern const pv_table pv_btf_file_table;
const pv_table pv_btf_file_table = PV_TABLE("BTF files", default_params, file_rows);

void pave_btf_file_params_init(pave_btf_file_params *params, size_t size)
{
    pv_params_init(&pv_btf_file_table, params, size);
}

static pave_result read_mapped(const pv_input *input, const pave_btf_file_params *params, pave_btf **out)
{
    int keeps = 0;
    size_t size = (size_t)input->size;
    uint8_t *bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, input->file, 0);
    if (bytes == MAP_FAILED)
        return pv_unreadable(input->context, input->path, errno);
    pave_result result =
        pv_is_bonn(bytes, size)  ? pv_bonn_read(input->context, input->path, bytes, size, &keeps, out)
        : pv_is_big(bytes, size) ? pv_big_read(input->context, input->path, bytes, size, params, &keeps, out)
                                 : pv_fail(input->context, PAVE_ERR_FORMAT,
                                           "%s: is not a BTF file: its first bytes are those of no known format",
                                           input->path);
    if (!result && keeps) {
        (*out)->samples.map = bytes;
        (*out)->samples.map_bytes = size;
    } else
        munmap(bytes, size);
    return result;
}

static pave_result read_file(pave_context *context, const char *path, const pave_btf_file_params *params,
                             pave_btf **out)
{
    pv_input input;
    uint8_t head[4] = { 0 };
    pave_result result = pv_input_open(context, path, &input);
    if (!result)
        result = pv_input_read(&input, 0, head, input.size < 4 ? input.size : 4);
    if (!result)
        result = !memcmp(head, "\x76\x2F\x31\x01", 4) ? pv_exr_btf_read(context, &input, out)
                 : !memcmp(head, "PK\3\4", 4) || !memcmp(head, "PK\5\6", 4) ? pv_zip_read(context, path, params, out)
                                                                          : read_mapped(&input, params, out);
    pv_input_close(&input);
    return result;
}

pave_result pave_btf_read(pave_context *context, const char *path, const pave_btf_file_params *given, pave_btf **out)
{
    pave_btf_file_params params;
    struct stat info;
    if (out)
        *out = NULL;
    if (!context || !path || !out)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pave_result result = pv_params_read(context, &pv_btf_file_table, given, &params);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "read", 0, 1);
    result = !stat(path, &info) && S_ISDIR(info.st_mode) ? pv_folder_read(context, path, &params, out)
                                                         : read_file(context, path, &params, out);
    pv_call_end(context, call);
    errno = before;
    return result;
}

static int ends_with(const char *path, const char *ending)
{
    size_t length = strlen(path), tail = strlen(ending);
    return length > tail && !strcmp(path + length - tail, ending);
}

static int is_folder(const char *path)
{
    struct stat info;
    return ends_with(path, "/") || (!stat(path, &info) && S_ISDIR(info.st_mode));
}

static pave_result write_as_it_ends(pave_context *context, const pave_btf *btf, const pave_btf_file_params *params,
                                    const char *path)
{
    if (is_folder(path))
        return pv_folder_write(context, btf, params, path);
    return ends_with(path, ".bdi")   ? pv_bdi_write(context, btf, path)
           : ends_with(path, ".btf") ? pv_fmf_write(context, btf, path)
           : ends_with(path, ".exr") ? pv_exr_btf_write(context, btf, path)
                                     : pv_fail(context, PAVE_ERR_ARGUMENT,
                                               "%s: a BTF is written as .bdi, .btf, .exr or a folder/", path);
}

pave_result pave_btf_write(pave_context *context, const pave_btf *btf, const pave_btf_file_params *given,
                           const char *path)
{
    pave_btf_file_params params;
    if (!context || !btf || !path)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pave_result result = pv_params_read(context, &pv_btf_file_table, given, &params);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "write", 0, 1);
    result = write_as_it_ends(context, btf, &params, path);
    pv_call_end(context, call);
    errno = before;
    return result;
}
