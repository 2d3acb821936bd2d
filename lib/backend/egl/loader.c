/* libEGL and libGLESv2, opened when they are first needed, and the functions in them. */
#include "backend/egl/egl.h"

#include <dlfcn.h>

/* Once opened they stay: the display is the process's (display.c), and its driver keeps threads. */
static void *open_library(const char *name)
{
    return dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
}

const char *pv_gl_load(pv_gl *gl)
{
    gl->egl_library = open_library("libEGL.so.1");
    if (!gl->egl_library)
        return "there is no EGL on this machine (libEGL.so.1)";
    gl->gl_library = open_library("libGLESv2.so.2");
    if (!gl->gl_library)
        return "there is no OpenGL ES on this machine (libGLESv2.so.2)";
    int complete = 1;
#define EGL(name) complete &= (*(void **)&gl->egl_##name = dlsym(gl->egl_library, "egl" #name)) != NULL;
    PV_EGL_FUNCTIONS(EGL)
    if (!complete)
        return "libEGL is older than EGL 1.5";
#define GL(name) complete &= (*(void **)&gl->name = dlsym(gl->gl_library, "gl" #name)) != NULL;
    PV_GL_FUNCTIONS(GL)
    return complete ? NULL : "libGLESv2 is older than OpenGL ES 3";
}

void pv_gl_unload(pv_gl *gl)
{
    if (gl->gl_library)
        dlclose(gl->gl_library);
    if (gl->egl_library)
        dlclose(gl->egl_library);
    gl->gl_library = gl->egl_library = NULL;
}
