/* OpenGL ES from inside: a context of our own, without a surface, and the functions that it is used with. */
#pragma once

#include "backend/backend.h"

#define EGL_NO_X11
#define MESA_EGL_NO_X11_HEADERS
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>

/* Of libEGL.so.1 and of libGLESv2.so.2. */
#define PV_EGL_FUNCTIONS(X) \
    X(GetError) X(QueryString) X(GetProcAddress) X(GetPlatformDisplay) X(GetDisplay) X(Initialize) X(ChooseConfig) \
    X(BindAPI) X(QueryAPI) X(GetCurrentDisplay) X(GetCurrentContext) X(GetCurrentSurface) X(CreateContext) \
    X(DestroyContext) X(MakeCurrent)
#define PV_GL_FUNCTIONS(X) \
    X(GetString) X(GetIntegerv) X(GetError) X(GenRenderbuffers) X(BindRenderbuffer) X(RenderbufferStorage) \
    X(GenFramebuffers) X(BindFramebuffer) X(FramebufferRenderbuffer) X(CheckFramebufferStatus) X(Enable) X(DepthFunc) \
    X(Viewport) X(Scissor) X(ClearBufferuiv) X(ClearBufferfv) X(CreateShader) X(ShaderSource) X(CompileShader) \
    X(DeleteShader) X(CreateProgram) X(AttachShader) X(LinkProgram) X(GetProgramiv) X(UseProgram) \
    X(GetUniformLocation) X(Uniform1f) X(Uniform1i) X(Uniform4f) X(GenBuffers) X(BindBuffer) X(BufferData) \
    X(EnableVertexAttribArray) X(VertexAttribIPointer) X(VertexAttribDivisor) X(DrawArraysInstanced) X(Finish) \
    X(ReadPixels)

typedef GLenum(GL_APIENTRY *pv_gl_status)(void);

typedef struct pv_gl {
    void *egl_library, *gl_library;
#define PV_EGL_FIELD(name) __typeof__(&egl##name) egl_##name;
#define PV_GL_FIELD(name) __typeof__(&gl##name) name;
    PV_EGL_FUNCTIONS(PV_EGL_FIELD)
    PV_GL_FUNCTIONS(PV_GL_FIELD)
#undef PV_EGL_FIELD
#undef PV_GL_FIELD
    pv_gl_status GetGraphicsResetStatus; /* NULL: the context does not tell when it is lost */
    EGLDisplay display;
    EGLContext context;
    GLint most_side;    /* of a target, px */
    int32_t components; /* that a pixel has when it is read: 1, or 4 of which the first counts */
    GLint margin, frame, metric; /* the program's uniforms */
} pv_gl;

/* What the calling thread had current before. */
typedef struct pv_gl_host {
    EGLenum api;
    EGLDisplay display;
    EGLContext context;
    EGLSurface draw, read;
} pv_gl_host;

/* loader.c: the libraries and their functions. NULL, or the reason why there are none. */
const char *pv_gl_load(pv_gl *gl);
void pv_gl_unload(pv_gl *gl);

/* display.c: opens a context of OpenGL ES 3 on the best device. NULL or a reason; close it with pv_gl_close even so.
 * The context is current between enter and leave only, and there no callback may be made: the host may use OpenGL. */
const char *pv_gl_open(pv_gl *gl);
void pv_gl_close(pv_gl *gl);
int pv_gl_enter(const pv_gl *gl, pv_gl_host *host);
void pv_gl_leave(const pv_gl *gl, const pv_gl_host *host);
/* What is wrong with the context, "" if nothing is. */
const char *pv_gl_fault(const pv_gl *gl);

/* program.c: the targets (labels and depth) and the program, made once, bound for good. NULL or a reason. */
enum { PV_GL_FRAME = 384 }; /* px around a target that quads may reach without being clipped */
const char *pv_gl_targets(pv_gl *gl, int32_t width, int32_t height);
const char *pv_gl_program(pv_gl *gl);

/* list.c */
void pv_gles_list(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count);

/* raster.c: the share of the plane that the CPU had to label so far, 0..1, for tests: it would hide a device that draws
 * nothing. */
double pv_gles_mended(const void *engine);
