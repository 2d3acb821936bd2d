/* The module for images other than OpenEXR, PNG and JPEG, loaded when one is met. */
#pragma once

#include "base/context.h"
#include "io/codec.h"

typedef struct pv_module {
    void *handle;
    const pv_codec *codec;
} pv_module;

/* `path` is the image at hand, for the sentence of a failure. */
pave_result pv_module_load(pave_context *context, const char *path, pv_module *out);
void pv_module_unload(pv_module *module);
