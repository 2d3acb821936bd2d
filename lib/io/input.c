/* Input files. */
#include "io/input.h"

#include "io/output.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST_AT_ONCE = 1 << 24 };

pave_result pv_unreadable(pave_context *context, const char *path, int error)
{
    return pv_fail(context, PAVE_ERR_IO, "%s: cannot be read: %s", path, pv_system_error(error));
}

int64_t pv_read_at(int file, int64_t offset, void *bytes, int64_t size)
{
    int64_t done = 0;
    while (done < size) {
        int64_t left = size - done;
        ssize_t n = pread(file, (char *)bytes + done, (size_t)(left < MOST_AT_ONCE ? left : MOST_AT_ONCE),
                          offset + done);
        if (n < 0 && errno != EINTR)
            return -1;
        if (n == 0)
            break;
        done += n > 0 ? n : 0;
    }
    return done;
}

static int64_t time_of_change(const struct stat *info)
{
    return (int64_t)info->st_mtim.tv_sec * 1000000000 + info->st_mtim.tv_nsec;
}

/* Not blocking, for a pipe would wait for a writer before it can be refused. */
pave_result pv_input_open(pave_context *context, const char *path, pv_input *out)
{
    struct stat info;
    *out = (pv_input){ .context = context, .path = path };
    out->file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (out->file < 0 || fstat(out->file, &info))
        return pv_unreadable(context, path, errno);
    if (S_ISDIR(info.st_mode))
        return pv_unreadable(context, path, EISDIR);
    if (!S_ISREG(info.st_mode))
        return pv_fail(context, PAVE_ERR_IO, "%s: cannot be read: it is a device or a pipe", path);
    if (!info.st_size)
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: is empty", path);
    out->size = info.st_size;
    out->changed = time_of_change(&info);
    return PAVE_OK;
}

void pv_input_close(pv_input *input)
{
    if (input->file >= 0)
        close(input->file);
    input->file = -1;
    pv_release(input->window);
    input->window = NULL;
}

static pave_result became_shorter(const pv_input *input)
{
    return pv_fail(input->context, PAVE_ERR_IO, "%s: cannot be read: it became shorter meanwhile", input->path);
}

pave_result pv_input_read(const pv_input *input, int64_t offset, void *bytes, int64_t size)
{
    int64_t got = pv_read_at(input->file, offset, bytes, size);
    if (got < 0)
        return pv_unreadable(input->context, input->path, errno);
    return got < size ? became_shorter(input) : PAVE_OK;
}

pave_result pv_input_look(pv_input *input, int64_t offset, int64_t size, const uint8_t **out)
{
    pave_result result = PAVE_OK;
    if (!input->window)
        input->window = pv_allocate(input->context, PV_INPUT_LOOK, 1, &result);
    if (result)
        return result;
    if (offset < input->from || offset + size > input->from + input->held) {
        int64_t left = input->size - offset;
        input->held = left < PV_INPUT_LOOK ? left : PV_INPUT_LOOK;
        input->from = offset;
        result = pv_input_read(input, offset, input->window, input->held);
    }
    if (result)
        input->held = 0;
    *out = input->window + (offset - input->from);
    return result;
}

pave_result pv_input_load(const pv_input *input, uint8_t **out)
{
    pave_result result = PAVE_OK;
    uint8_t *bytes = pv_allocate(input->context, (size_t)input->size, 1, &result);
    for (int64_t done = 0, end; done < input->size && !result; done = end) {
        end = input->size - done < MOST_AT_ONCE ? input->size : done + MOST_AT_ONCE;
        result = pv_input_read(input, done, bytes + done, end - done);
        if (!result)
            result = pv_progress(input->context, 0);
    }
    if (result)
        pv_release(bytes);
    *out = result ? NULL : bytes;
    return result;
}

pave_result pv_input_unchanged(const pv_input *input)
{
    struct stat info;
    if (fstat(input->file, &info))
        return pv_unreadable(input->context, input->path, errno);
    if (info.st_size < input->size)
        return became_shorter(input);
    if (info.st_size != input->size || time_of_change(&info) != input->changed)
        return pv_fail(input->context, PAVE_ERR_IO, "%s: was written to while it was read", input->path);
    return PAVE_OK;
}
