/* Finding and loading the module pave-oiio.so: beside this library, below ../lib, in the folder it was built for. */
#include "io/module.h"

#include <dlfcn.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef PAVE_MODULE_DIR
#define PAVE_MODULE_DIR "/usr/local/lib/pave"
#endif

/* Folder of the file that this code is in; a bare program name would be looked up in the current folder, so it is not
 * used. 0 if it cannot be told. */
static int own_folder(char folder[PATH_MAX])
{
    Dl_info info;
    if (!dladdr((const void *)(uintptr_t)pave_version, &info) || !info.dli_fname)
        return 0;
    if (!realpath(strchr(info.dli_fname, '/') ? info.dli_fname : "/proc/self/exe", folder))
        return 0;
    *strrchr(folder, '/') = 0;
    return 1;
}

/* The module stays in memory once loaded: what it depends on does not take being unloaded. */
static void *open_if_there(const char *folder, const char *below)
{
    char path[PATH_MAX + 64];
    if ((size_t)snprintf(path, sizeof path, "%s%s/pave-oiio.so", folder, below) >= sizeof path || access(path, R_OK))
        return NULL;
    return dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
}

pave_result pv_module_load(pave_context *context, const char *path, pv_module *out)
{
    char folder[PATH_MAX];
    void *handle = NULL;
    dlerror();
    if (own_folder(folder)) {
        handle = open_if_there(folder, "/pave");
        if (!handle)
            handle = open_if_there(folder, "/../lib/pave");
    }
    if (!handle)
        handle = open_if_there(PAVE_MODULE_DIR, "");
    if (!handle) {
        const char *reason = dlerror();
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: images of this kind need the module pave-oiio.so: %s",
                       path, reason ? reason : "it is not installed beside libpave or in " PAVE_MODULE_DIR);
    }
    pv_codec_entry entry = (pv_codec_entry)(uintptr_t)dlsym(handle, "pave_oiio_codec");
    out->handle = handle;
    out->codec = entry ? entry(PV_CODEC_VERSION) : NULL;
    if (out->codec)
        return PAVE_OK;
    pv_module_unload(out);
    return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: the module pave-oiio.so belongs to another version of libpave",
                   path);
}

void pv_module_unload(pv_module *module)
{
    if (module->handle)
        dlclose(module->handle);
    module->handle = NULL;
}
