/* Which device OpenGL ES would run on. */
#include "backend/egl/egl.h"

#include <stdio.h>

/* "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL ES 3.2 Mesa 22.3.6", and the reason if it cannot be used. */
static const char *describe(pv_gl *gl, char *text, size_t size)
{
    pv_gl_host host;
    if (!pv_gl_enter(gl, &host)) {
        snprintf(text, size, "its context cannot be made current");
        return text;
    }
    const char *renderer = (const char *)gl->GetString(GL_RENDERER), *version = (const char *)gl->GetString(GL_VERSION);
    const char *reason = pv_gl_targets(gl, 8, 8);
    snprintf(text, size, "%s, %s%s%s", renderer ? renderer : "unnamed", version ? version : "OpenGL ES",
             reason ? ": " : "", reason ? reason : "");
    pv_gl_leave(gl, &host);
    return reason;
}

void pv_gles_list(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count)
{
    (void)context;
    pv_gl gl = { 0 };
    char text[512];
    const char *reason = pv_gl_open(&gl);
    if (reason)
        snprintf(text, sizeof text, "%s", reason);
    else
        reason = describe(&gl, text, sizeof text);
    pv_device_add(devices, capacity, count, PAVE_BACKEND_GLES, !reason, text);
    pv_gl_close(&gl);
}
