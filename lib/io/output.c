/* Output files: an unnamed file (or one of a name of its own) beside the target, fsync, rename, fsync of the folder. */
#include "io/output.h"

#include "util/text.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BUFFER = 1 << 16, LINKS = 40, TRIES = 100 };

struct pv_output {
    pave_context *context;
    const char *path;      /* the caller's, for sentences */
    char target[PATH_MAX]; /* where the caller's path leads to */
    char folder[PATH_MAX];
    char temporary[PATH_MAX + 64]; /* "" while the file has no name */
    int file;
    int direct; /* a device or a pipe */
    int error;  /* the first errno */
    pave_result failed;
    int64_t written; /* bytes that have left the buffer */
    char *spool;     /* direct and seeking: the whole file */
    size_t spooled, spool_size;
    size_t filled;
    char buffer[BUFFER];
};

const char *pv_system_error(int error)
{
    const char *text = strerrordesc_np(error);
    return text ? text : "unknown error";
}

static void set_folder(pv_output *output)
{
    const char *slash = strrchr(output->target, '/');
    size_t length = slash ? (size_t)(slash - output->target) + 1 : 0;
    memcpy(output->folder, output->target, length);
    strcpy(output->folder + length, length ? "" : "./");
}

/* Follows symbolic links, so that the rename replaces the file they point at; it need not exist. */
static int resolve(pv_output *output)
{
    char link[PATH_MAX];
    if (strlen(output->path) >= sizeof output->target)
        return ENAMETOOLONG;
    strcpy(output->target, output->path);
    for (int i = 0; i < LINKS; i++) {
        set_folder(output);
        ssize_t length = readlink(output->target, link, sizeof link - 1);
        if (length < 0)
            return 0;
        link[length] = 0;
        size_t before = link[0] == '/' ? 0 : strlen(output->folder);
        if (before + (size_t)length >= sizeof output->target)
            return ENAMETOOLONG;
        memcpy(output->target, output->folder, before);
        memcpy(output->target + before, link, (size_t)length + 1);
    }
    return ELOOP;
}

/* A name beside the target that nothing else has; `make` is called until it does not find it taken. */
static int take_name(pv_output *output, int (*make)(pv_output *output))
{
    static atomic_uint count;
    for (int i = 0; i < TRIES; i++) {
        snprintf(output->temporary, sizeof output->temporary, "%s.pave-%ld-%u.tmp", output->folder, (long)getpid(),
                 atomic_fetch_add(&count, 1));
        if (!make(output))
            return 0;
        if (errno != EEXIST)
            break;
    }
    output->temporary[0] = 0;
    return errno;
}

static int make_named(pv_output *output)
{
    output->file = open(output->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    return output->file < 0 ? -1 : 0;
}

static int link_unnamed(pv_output *output)
{
    char self[64];
    snprintf(self, sizeof self, "/proc/self/fd/%d", output->file);
    return linkat(AT_FDCWD, self, AT_FDCWD, output->temporary, AT_SYMLINK_FOLLOW);
}

/* A file without a name leaves nothing behind even if the process is killed. Not every file system has them. */
static int open_beside(pv_output *output, const struct stat *old)
{
    output->file = access("/proc/self/fd", X_OK) ? -1 : open(output->folder, O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);
    int error = output->file < 0 ? take_name(output, make_named) : 0;
    if (!error && old)
        (void)!fchmod(output->file, old->st_mode & 07777);
    return error;
}

static int open_target(pv_output *output)
{
    struct stat old;
    if (!strcmp(output->path, "-")) {
        output->path = "standard output";
        output->direct = 1;
        output->file = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
        return output->file < 0 ? errno : 0;
    }
    output->direct = !stat(output->path, &old) && !S_ISREG(old.st_mode) && !S_ISDIR(old.st_mode);
    if (output->direct) {
        output->file = open(output->path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
        return output->file < 0 ? errno : 0;
    }
    int error = resolve(output);
    if (error)
        return error;
    int exists = !stat(output->target, &old);
    if (!exists && errno != ENOENT)
        return errno;
    if (exists && S_ISDIR(old.st_mode))
        return EISDIR;
    if (exists && access(output->target, W_OK))
        return errno;
    return open_beside(output, exists ? &old : NULL);
}

pave_result pv_output_open(pave_context *context, const char *path, int seeks, pv_output **out)
{
    pave_result result = PAVE_OK;
    pv_output *output = *out = pv_allocate(context, 1, sizeof *output, &result);
    if (!output)
        return result;
    memset(output, 0, offsetof(pv_output, buffer));
    output->context = context;
    output->path = path;
    output->file = -1;
    output->error = *path ? open_target(output) : ENOENT;
    if (!output->error && output->direct && seeks)
        output->spool = pv_allocate(context, output->spool_size = BUFFER, 1, &output->failed);
    if (!pv_output_failed(output))
        return PAVE_OK;
    *out = NULL;
    return pv_output_close(output, PAVE_OK);
}

int pv_output_failed(const pv_output *output)
{
    return output->error || output->failed;
}

int pv_output_scratch(const char *beside)
{
    char name[PATH_MAX + 32];
    const char *slash = strrchr(beside, '/');
    int length = slash ? (int)(slash - beside) + 1 : 0;
    if (length >= PATH_MAX)
        return errno = ENAMETOOLONG, -1;
    length = snprintf(name, sizeof name, "%.*s", length ? length : 2, length ? beside : "./");
    int file = open(name, O_RDWR | O_TMPFILE | O_EXCL | O_CLOEXEC, 0600);
    if (file >= 0)
        return file;
    strcpy(name + length, ".pave-XXXXXX");
    file = mkostemp(name, O_CLOEXEC);
    if (file >= 0)
        unlink(name);
    return file;
}

static int write_all(pv_output *output, const char *bytes, size_t size, int64_t offset)
{
    while (size && !output->error) {
        ssize_t n = output->direct ? write(output->file, bytes, size) : pwrite(output->file, bytes, size, offset);
        if (n < 0 && errno != EINTR)
            output->error = errno;
        if (n > 0)
            bytes += n, size -= (size_t)n, offset += n;
    }
    return !output->error;
}

static int spool_at(pv_output *output, int64_t offset, const void *bytes, size_t size)
{
    size_t end = (size_t)offset + size, grown = output->spool_size;
    while (grown < end)
        grown *= 2;
    if (grown > output->spool_size) {
        char *spool = pv_resize(output->context, output->spool, output->spooled, grown, 1, &output->failed);
        if (!spool)
            return 0;
        output->spool = spool;
        output->spool_size = grown;
    }
    if ((size_t)offset > output->spooled)
        memset(output->spool + output->spooled, 0, (size_t)offset - output->spooled);
    memcpy(output->spool + offset, bytes, size);
    output->spooled = end > output->spooled ? end : output->spooled;
    return 1;
}

int pv_output_at(pv_output *output, int64_t offset, const void *bytes, size_t size)
{
    if (pv_output_failed(output))
        return 0;
    return output->spool ? spool_at(output, offset, bytes, size) : write_all(output, bytes, size, offset);
}

static void flush(pv_output *output)
{
    if (pv_output_at(output, output->written, output->buffer, output->filled))
        output->written += (int64_t)output->filled;
    output->filled = 0;
}

void pv_output_bytes(pv_output *output, const void *bytes, size_t size)
{
    for (const char *from = bytes; size && !pv_output_failed(output);) {
        size_t room = BUFFER - output->filled, n = size < room ? size : room;
        memcpy(output->buffer + output->filled, from, n);
        output->filled += n;
        from += n;
        size -= n;
        if (output->filled == BUFFER)
            flush(output);
    }
}

void pv_output_put(void *output, const char *text, size_t length)
{
    pv_output_bytes(output, text, length);
}

void pv_output_text(pv_output *output, const char *text)
{
    pv_output_bytes(output, text, strlen(text));
}

void pv_output_whole(pv_output *output, int64_t value)
{
    char text[24];
    pv_output_bytes(output, text, (size_t)snprintf(text, sizeof text, "%lld", (long long)value));
}

void pv_output_thousandths(pv_output *output, int64_t value)
{
    char text[24];
    pv_output_bytes(output, text, pv_text_thousandths(text, value));
}

/* The rename must not overtake the contents, nor be forgotten: both are made durable, in this order. */
static void replace_target(pv_output *output)
{
    int alone = !output->context->drafts;
    if (alone && fsync(output->file))
        output->error = errno;
    else if (!output->temporary[0])
        output->error = take_name(output, link_unnamed);
    if (!output->error && rename(output->temporary, output->target))
        output->error = errno;
    if (output->error)
        return;
    output->temporary[0] = 0;
    int folder = alone ? open(output->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (folder >= 0) {
        fsync(folder);
        close(folder);
    }
}

static void finish(pv_output *output)
{
    if (output->filled)
        flush(output);
    if (output->spool && !output->failed)
        write_all(output, output->spool, output->spooled, 0);
    if (!output->direct && !pv_output_failed(output))
        replace_target(output);
}

pave_result pv_output_close_head(pv_output *output, pave_result result, const void *head, size_t size)
{
    if (output->filled)
        flush(output);
    pv_output_at(output, 0, head, size);
    return pv_output_close(output, result);
}

pave_result pv_output_close(pv_output *output, pave_result result)
{
    if (!result && output->file >= 0)
        finish(output);
    if (output->file >= 0 && close(output->file) && !output->error)
        output->error = errno == EINTR ? 0 : errno;
    if (output->temporary[0])
        unlink(output->temporary);
    if (!result)
        result = output->failed;
    if (!result && output->error)
        result = pv_fail(output->context, PAVE_ERR_IO, "%s: cannot be written: %s", output->path,
                         pv_system_error(output->error));
    pv_release(output->spool);
    pv_release(output);
    return result;
}
