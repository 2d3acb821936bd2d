/* BTF files: which format, and who does it. */
#include "io/bonn.h"

#include <pave/io.h>

#include "io/output.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static pave_result unreadable(pave_context *context, const char *path, int error)
{
    return pv_fail(context, PAVE_ERR_IO, "%s: cannot be read: %s", path, pv_system_error(error));
}

static pave_result read_mapped(pave_context *context, const char *path, uint8_t *bytes, size_t size, pave_btf **out)
{
    int keeps = 0;
    pave_result result;
    if (!pv_is_bonn(bytes, size))
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: %s", path,
                       size > 4 && !memcmp(bytes, "PK\3\4", 4)
                           ? "is a zip archive, and not one of Bonn's BTF files"
                           : "is not a BTF file: its first bytes are those of no known format");
    result = pv_bonn_read(context, path, bytes, size, &keeps, out);
    if (!result && keeps) {
        (*out)->samples.map = bytes;
        (*out)->samples.map_bytes = size;
    } else
        munmap(bytes, size);
    return result;
}

static pave_result read_file(pave_context *context, const char *path, int file, pave_btf **out)
{
    struct stat info;
    if (fstat(file, &info))
        return unreadable(context, path, errno);
    if (!S_ISREG(info.st_mode))
        return unreadable(context, path, S_ISDIR(info.st_mode) ? EISDIR : ESPIPE);
    if (!info.st_size)
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: is empty", path);
    void *bytes = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, file, 0);
    if (bytes == MAP_FAILED)
        return unreadable(context, path, errno);
    return read_mapped(context, path, bytes, (size_t)info.st_size, out);
}

pave_result pave_btf_read(pave_context *context, const char *path, pave_btf **out)
{
    if (out)
        *out = NULL;
    if (!context || !path || !out)
        return PAVE_ERR_ARGUMENT;
    int before = errno, file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    pv_call call = pv_call_begin(context, "read", 0, 1);
    pave_result result = file < 0 ? unreadable(context, path, errno) : read_file(context, path, file, out);
    pv_call_end(context, call);
    if (file >= 0)
        close(file);
    errno = before;
    return result;
}

static int ends_with(const char *path, const char *ending)
{
    size_t length = strlen(path), tail = strlen(ending);
    return length > tail && !strcmp(path + length - tail, ending);
}

pave_result pave_btf_write(pave_context *context, const pave_btf *btf, const char *path)
{
    if (!context || !btf || !path)
        return PAVE_ERR_ARGUMENT;
    pv_call call = pv_call_begin(context, "write", 0, 1);
    pave_result result = ends_with(path, ".bdi")   ? pv_bdi_write(context, btf, path)
                         : ends_with(path, ".btf") ? pv_fmf_write(context, btf, path)
                                                   : pv_fail(context, PAVE_ERR_ARGUMENT,
                                                             "%s: a BTF is written as .bdi or .btf", path);
    pv_call_end(context, call);
    return result;
}
