/* What is drawn into, and what draws. */
#include "backend/egl/egl.h"

#include "shaders/frustum.es.h"

static void attach(pv_gl *gl, GLenum attachment, GLenum format, int32_t width, int32_t height)
{
    GLuint buffer;
    gl->GenRenderbuffers(1, &buffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl->RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
}

const char *pv_gl_targets(pv_gl *gl, int32_t width, int32_t height)
{
    GLuint frame;
    GLint format = 0, type = 0;
    gl->GenFramebuffers(1, &frame);
    gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    attach(gl, GL_COLOR_ATTACHMENT0, GL_R32UI, width, height);
    attach(gl, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, width, height);
    const char *fault = pv_gl_fault(gl);
    if (*fault)
        return fault;
    if (gl->CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        return "it cannot draw integers with a depth of 32 bits";
    gl->GetIntegerv(GL_IMPLEMENTATION_COLOR_READ_FORMAT, &format);
    gl->GetIntegerv(GL_IMPLEMENTATION_COLOR_READ_TYPE, &type);
    gl->components = format == GL_RED_INTEGER && type == GL_UNSIGNED_INT ? 1 : 4;
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->Enable(GL_SCISSOR_TEST);
    gl->Viewport(-PV_GL_FRAME, -PV_GL_FRAME, width + 2 * PV_GL_FRAME, height + 2 * PV_GL_FRAME);
    return NULL;
}

static void add_shader(pv_gl *gl, GLuint program, GLenum stage, const char *text)
{
    GLuint shader = gl->CreateShader(stage);
    gl->ShaderSource(shader, 1, &text, NULL);
    gl->CompileShader(shader);
    gl->AttachShader(program, shader);
    gl->DeleteShader(shader); /* it lives as long as the program */
}

const char *pv_gl_program(pv_gl *gl)
{
    GLint linked = 0;
    GLuint program = gl->CreateProgram();
    add_shader(gl, program, GL_VERTEX_SHADER, pv_essl_vert);
    add_shader(gl, program, GL_FRAGMENT_SHADER, pv_essl_frag);
    gl->LinkProgram(program);
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked)
        return "the graphics driver cannot compile the shaders";
    gl->UseProgram(program);
    gl->margin = gl->GetUniformLocation(program, "margin");
    gl->frame = gl->GetUniformLocation(program, "frame");
    gl->metric = gl->GetUniformLocation(program, "metric");
    return NULL;
}
