/* The display without a display, and a context of OpenGL ES 3 on it.
 *
 * A display belongs to the process: the host, or another engine, may be using it too, so it is never terminated. */
#include "backend/egl/egl.h"

#include <pthread.h>
#include <signal.h>
#include <string.h>

enum { MOST_DEVICES = 16, LOST = 0x0507 /* GL_CONTEXT_LOST */ };

static int has(const char *extensions, const char *name)
{
    return extensions && strstr(extensions, name);
}

static EGLContext create_context(const pv_gl *gl, EGLDisplay display, const EGLint *attributes)
{
    static const EGLint wanted[] = { EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_NONE };
    EGLConfig config = EGL_NO_CONFIG_KHR;
    EGLint count = 0;
    if (!gl->egl_ChooseConfig(display, wanted, &config, 1, &count) || !count)
        config = EGL_NO_CONFIG_KHR;
    return gl->egl_CreateContext(display, config, EGL_NO_CONTEXT, attributes);
}

static const char *check_context(pv_gl *gl)
{
    GLint major = 0, viewport[2] = { 0, 0 };
    gl->GetIntegerv(GL_MAJOR_VERSION, &major);
    if (gl->GetError() || major < 3)
        return "it is older than OpenGL ES 3";
    gl->GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &gl->most_side);
    gl->GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    for (int i = 0; i < 2; i++)
        if (viewport[i] - 2 * PV_GL_FRAME < gl->most_side)
            gl->most_side = viewport[i] - 2 * PV_GL_FRAME;
    return gl->most_side < 512 ? "its viewports are too small" : NULL;
}

/* Makes a context that tells when it is lost, if there is such, and leaves it current. */
static const char *open_on(pv_gl *gl, EGLDisplay display)
{
    static const EGLint robust[] = { EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_EXT,
                                     EGL_LOSE_CONTEXT_ON_RESET_EXT, EGL_NONE };
    static const EGLint plain[] = { EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE };
    if (display == EGL_NO_DISPLAY || !gl->egl_Initialize(display, NULL, NULL))
        return "no graphics driver of this machine works without a screen";
    gl->egl_BindAPI(EGL_OPENGL_ES_API);
    gl->display = display;
    if (has(gl->egl_QueryString(display, EGL_EXTENSIONS), "EGL_EXT_create_context_robustness"))
        gl->context = create_context(gl, display, robust);
    int tells = gl->context != EGL_NO_CONTEXT;
    if (!tells)
        gl->context = create_context(gl, display, plain);
    if (gl->context == EGL_NO_CONTEXT)
        return "the graphics driver has no OpenGL ES 3";
    if (!gl->egl_MakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, gl->context))
        return "the graphics driver has no OpenGL ES without a surface";
    if (tells && has((const char *)gl->GetString(GL_EXTENSIONS), "GL_EXT_robustness"))
        gl->GetGraphicsResetStatus = (pv_gl_status)gl->egl_GetProcAddress("glGetGraphicsResetStatusEXT");
    return check_context(gl);
}

static void destroy_context(pv_gl *gl)
{
    if (gl->context == EGL_NO_CONTEXT)
        return;
    gl->egl_MakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    gl->egl_DestroyContext(gl->display, gl->context);
    gl->context = EGL_NO_CONTEXT;
    gl->GetGraphicsResetStatus = NULL;
}

/* Devices with a graphics processor; those without one are reached more simply. */
static EGLint hardware(const pv_gl *gl, EGLDeviceEXT devices[MOST_DEVICES])
{
    EGLint found = 0, count = 0;
    if (!has(gl->egl_QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_EXT_platform_device"))
        return 0;
    PFNEGLQUERYDEVICESEXTPROC query = (PFNEGLQUERYDEVICESEXTPROC)gl->egl_GetProcAddress("eglQueryDevicesEXT");
    PFNEGLQUERYDEVICESTRINGEXTPROC describe =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)gl->egl_GetProcAddress("eglQueryDeviceStringEXT");
    if (!query || !describe || !query(MOST_DEVICES, devices, &found))
        return 0;
    for (EGLint i = 0; i < found; i++)
        if (!has(describe(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software"))
            devices[count++] = devices[i];
    return count;
}

static const char *open_best(pv_gl *gl)
{
    EGLDisplay displays[MOST_DEVICES + 2];
    EGLDeviceEXT devices[MOST_DEVICES];
    EGLint count = hardware(gl, devices);
    for (EGLint i = 0; i < count; i++)
        displays[i] = gl->egl_GetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL);
    displays[count++] = gl->egl_GetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, (void *)EGL_DEFAULT_DISPLAY, NULL);
    displays[count++] = gl->egl_GetDisplay(EGL_DEFAULT_DISPLAY);
    const char *first = NULL;
    for (EGLint i = 0; i < count; i++) {
        const char *reason = open_on(gl, displays[i]);
        if (!reason)
            return NULL;
        destroy_context(gl);
        first = first ? first : reason;
    }
    return first;
}

static pv_gl_host remember(const pv_gl *gl)
{
    pv_gl_host host = { .api = gl->egl_QueryAPI(), .context = gl->egl_GetCurrentContext() };
    if (host.context != EGL_NO_CONTEXT) {
        host.display = gl->egl_GetCurrentDisplay();
        host.draw = gl->egl_GetCurrentSurface(EGL_DRAW);
        host.read = gl->egl_GetCurrentSurface(EGL_READ);
    }
    return host;
}

/* Drivers start threads of their own here; signals stay with the host's. */
const char *pv_gl_open(pv_gl *gl)
{
    const char *reason = pv_gl_load(gl);
    if (reason)
        return reason;
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    pv_gl_host host = remember(gl);
    reason = open_best(gl);
    pv_gl_leave(gl, &host);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return reason;
}

/* A context takes all that was made in it along. */
void pv_gl_close(pv_gl *gl)
{
    if (gl->context != EGL_NO_CONTEXT) {
        pv_gl_host host = remember(gl);
        gl->egl_BindAPI(EGL_OPENGL_ES_API);
        destroy_context(gl);
        pv_gl_leave(gl, &host);
    }
    pv_gl_unload(gl);
}

int pv_gl_enter(const pv_gl *gl, pv_gl_host *host)
{
    *host = remember(gl);
    gl->egl_BindAPI(EGL_OPENGL_ES_API);
    if (gl->egl_MakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, gl->context))
        return 1;
    pv_gl_leave(gl, host);
    return 0;
}

void pv_gl_leave(const pv_gl *gl, const pv_gl_host *host)
{
    if (gl->display != EGL_NO_DISPLAY)
        gl->egl_MakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    gl->egl_BindAPI(host->api);
    if (host->context != EGL_NO_CONTEXT)
        gl->egl_MakeCurrent(host->display, host->draw, host->read, host->context);
}

const char *pv_gl_fault(const pv_gl *gl)
{
    if (gl->GetGraphicsResetStatus && gl->GetGraphicsResetStatus())
        return "the graphics device was reset";
    switch (gl->GetError()) {
    case GL_NO_ERROR: return "";
    case GL_OUT_OF_MEMORY: return "the graphics device has no memory left";
    case LOST: return "the graphics device was lost";
    default: return "the graphics driver refused a command";
    }
}
