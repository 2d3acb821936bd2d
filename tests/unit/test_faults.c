/* Devices that fail: every call to a driver that can fail is made to, one after the other, and each time there is one
 * sentence in the device's own words if the backend was named, the CPU's bytes if it was not, and nothing left over.
 *
 * The engines look their drivers' functions up with dlsym, which this program wraps (-Wl,--wrap=dlsym): what it gives
 * them counts calls and fails when it is told to. Functions are wrapped without regard to their types, as taking up to
 * six words: that holds in the calling conventions of 64-bit machines. */
#include "devices.h"
#include "failing.h"

#ifdef PAVE_HAVE_VULKAN
#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>
#endif
#ifdef PAVE_HAVE_EGL
#include "backend/egl/egl.h"
#endif

#include <dlfcn.h>

typedef uintptr_t word;
typedef word any_function(word, word, word, word, word, word);

typedef struct wrapped {
    const char *name;
    any_function *instead, *real;
} wrapped;

static struct {
    int64_t calls, fail_at; /* 0: never */
    const char *failed;     /* the name of the call that did */
    int lost, reset;        /* as a lost device fails, and all that follows; GLES: is told of a reset */
    int pose_as_gpu, small; /* what it says of itself */
    int64_t live;           /* objects made and not yet destroyed */
} faults;

static wrapped *find(wrapped *table, size_t count, const char *name)
{
    for (size_t i = 0; i < count; i++)
        if (!strcmp(table[i].name, name))
            return &table[i];
    return NULL;
}

static int fails(const char *name)
{
    if (++faults.calls != faults.fail_at)
        return faults.lost && faults.failed;
    faults.failed = name;
    return 1;
}

#ifdef PAVE_HAVE_VULKAN
enum { MADE = 1, MADE_AT_ONCE };

/* What a call returns that is to fail; waiting is done first, for a lost device has nothing under way. */
static word vk_fails(wrapped *w, int can_be_lost, word a, word b, word c, word d, word e)
{
    if (!strcmp(w->name, "vkWaitForFences") && faults.fail_at == faults.calls)
        w->real(a, b, c, d, e, 0);
    return (word)(faults.lost && can_be_lost ? VK_ERROR_DEVICE_LOST : VK_ERROR_OUT_OF_DEVICE_MEMORY);
}

static word vk_call(wrapped *w, int makes, int can_be_lost, word a, word b, word c, word d, word e, word f)
{
    int told = !faults.lost || can_be_lost;
    if (told && fails(w->name))
        return vk_fails(w, can_be_lost, a, b, c, d, e);
    word result = w->real(a, b, c, d, e, f);
    faults.live += makes && !(int32_t)result;
    return result;
}

#define VK_CAN_FAIL(X) \
    X(CreateDevice, MADE, 1) X(QueueSubmit, 0, 1) X(WaitForFences, 0, 1) X(ResetFences, 0, 0) X(CreateFence, MADE, 0) \
    X(CreateCommandPool, MADE, 0) X(AllocateCommandBuffers, 0, 0) X(BeginCommandBuffer, 0, 0) \
    X(EndCommandBuffer, 0, 0) X(CreateBuffer, MADE, 0) X(CreateBufferView, MADE, 0) X(AllocateMemory, MADE, 0) \
    X(BindBufferMemory, 0, 0) X(MapMemory, 0, 0) X(CreateShaderModule, MADE, 0) X(CreateDescriptorSetLayout, MADE, 0) \
    X(CreateDescriptorPool, MADE, 0) X(AllocateDescriptorSets, 0, 0) X(CreatePipelineLayout, MADE, 0) \
    X(CreateComputePipelines, MADE, 0) X(CreateImage, MADE, 0) X(BindImageMemory, 0, 0) X(CreateImageView, MADE, 0) \
    X(CreateRenderPass, MADE, 0) X(CreateFramebuffer, MADE, 0) X(CreateGraphicsPipelines, MADE, 0)
#define VK_DESTROYS(X) \
    X(DestroyFence) X(DestroyCommandPool) X(DestroyBuffer) X(DestroyBufferView) X(FreeMemory) X(DestroyShaderModule) \
    X(DestroyDescriptorSetLayout) X(DestroyDescriptorPool) X(DestroyPipelineLayout) X(DestroyPipeline) \
    X(DestroyImage) X(DestroyImageView) X(DestroyRenderPass) X(DestroyFramebuffer)

#define NUMBER(name, ...) VK_##name,
enum { VK_CAN_FAIL(NUMBER) VK_DESTROYS(NUMBER) VK_DestroyDevice, VK_GetPhysicalDeviceProperties, VK_FUNCTIONS };
static wrapped vk_table[VK_FUNCTIONS];

#define CALL(name, makes, can_be_lost) \
    static word vk_##name(word a, word b, word c, word d, word e, word f) \
    { \
        return vk_call(&vk_table[VK_##name], makes, can_be_lost, a, b, c, d, e, f); \
    }
VK_CAN_FAIL(CALL)

#define DESTROY(name) \
    static word vk_##name(word a, word b, word c, word d, word e, word f) \
    { \
        faults.live -= b != 0; \
        return vk_table[VK_##name].real(a, b, c, d, e, f); \
    }
VK_DESTROYS(DESTROY)

static word vk_DestroyDevice(word a, word b, word c, word d, word e, word f)
{
    faults.live -= a != 0;
    return vk_table[VK_DestroyDevice].real(a, b, c, d, e, f);
}

static word vk_GetPhysicalDeviceProperties(word a, word b, word c, word d, word e, word f)
{
    vk_table[VK_GetPhysicalDeviceProperties].real(a, b, c, d, e, f);
    VkPhysicalDeviceProperties *properties = (VkPhysicalDeviceProperties *)b;
    if (faults.pose_as_gpu)
        properties->deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
    if (faults.small)
        properties->limits.maxStorageBufferRange = 65536;
    return 0;
}

#define ROW(name, ...) { "vk" #name, vk_##name, NULL },
static wrapped vk_table[VK_FUNCTIONS] = {
    VK_CAN_FAIL(ROW) VK_DESTROYS(ROW) ROW(DestroyDevice) ROW(GetPhysicalDeviceProperties)
};

static void *(*vk_instance_lookup)(void *, const char *);
static void *(*vk_device_lookup)(void *, const char *);

static void *vk_wrapped(void *real, const char *name)
{
    wrapped *w = real ? find(vk_table, VK_FUNCTIONS, name) : NULL;
    if (!w)
        return real;
    *(void **)&w->real = real;
    return *(void **)&w->instead;
}

static void *vk_get_device(void *device, const char *name)
{
    return vk_wrapped(vk_device_lookup(device, name), name);
}

static void *vk_get_instance(void *instance, const char *name)
{
    void *real = vk_instance_lookup(instance, name);
    if (strcmp(name, "vkGetDeviceProcAddr"))
        return vk_wrapped(real, name);
    *(void **)&vk_device_lookup = real;
    void *(*instead)(void *, const char *) = vk_get_device;
    return *(void **)&instead;
}
#endif

#ifdef PAVE_HAVE_EGL
/* An EGL call fails with a zero. An error of GL is told by the next glGetError, and by the status of a lost context. */
#define EGL_CAN_FAIL(X) X(eglInitialize) X(eglCreateContext) X(eglMakeCurrent) X(glCheckFramebufferStatus)
#define EGL_NUMBER(name) NUMBER_##name,
enum { EGL_CAN_FAIL(EGL_NUMBER) NUMBER_glGetProgramiv, NUMBER_glGetError, NUMBER_eglGetProcAddress, EGL_FUNCTIONS };
static wrapped egl_table[EGL_FUNCTIONS];

#define EGL_CALL(name) \
    static word wrap_##name(word a, word b, word c, word d, word e, word f) \
    { \
        int current = NUMBER_##name != NUMBER_eglMakeCurrent || d; /* making none current must not fail */ \
        return current && fails(#name) ? 0 : egl_table[NUMBER_##name].real(a, b, c, d, e, f); \
    }
EGL_CAN_FAIL(EGL_CALL)

static word wrap_glGetProgramiv(word a, word b, word c, word d, word e, word f)
{
    egl_table[NUMBER_glGetProgramiv].real(a, b, c, d, e, f);
    if (fails("glGetProgramiv"))
        *(GLint *)c = 0;
    return 0;
}

static word wrap_glGetError(word a, word b, word c, word d, word e, word f)
{
    word error = egl_table[NUMBER_glGetError].real(a, b, c, d, e, f);
    return fails("glGetError") ? faults.lost ? 0x0507 /* GL_CONTEXT_LOST */ : GL_OUT_OF_MEMORY : error;
}

static GLenum reset_status(void)
{
    return faults.reset && fails("glGetGraphicsResetStatus") ? 0x8254 /* GL_INNOCENT_CONTEXT_RESET */ : GL_NO_ERROR;
}

static word wrap_eglGetProcAddress(word a, word b, word c, word d, word e, word f)
{
    if (!strcmp((const char *)a, "glGetGraphicsResetStatusEXT"))
        return (word)reset_status;
    return egl_table[NUMBER_eglGetProcAddress].real(a, b, c, d, e, f);
}

#define EGL_ROW(name) { #name, wrap_##name, NULL },
static wrapped egl_table[EGL_FUNCTIONS] = {
    EGL_CAN_FAIL(EGL_ROW) EGL_ROW(glGetProgramiv) EGL_ROW(glGetError) EGL_ROW(eglGetProcAddress)
};
#endif

void *__real_dlsym(void *library, const char *name);
void *__wrap_dlsym(void *library, const char *name);

void *__wrap_dlsym(void *library, const char *name)
{
    void *real = __real_dlsym(library, name);
#ifdef PAVE_HAVE_VULKAN
    if (real && !strcmp(name, "vkGetInstanceProcAddr")) {
        void *(*instead)(void *, const char *) = vk_get_instance;
        *(void **)&vk_instance_lookup = real;
        return *(void **)&instead;
    }
#endif
#ifdef PAVE_HAVE_EGL
    wrapped *w = real ? find(egl_table, EGL_FUNCTIONS, name) : NULL;
    if (w) {
        *(void **)&w->real = real;
        return *(void **)&w->instead;
    }
#endif
    return real;
}

static failing memory; /* it never does: what contexts and their handles hold is counted */
static int32_t errors, warnings;
static char said[1024];

static void on_message(void *user, int32_t level, const char *text)
{
    (void)user;
    errors += level == PAVE_MESSAGE_ERROR;
    warnings += level == PAVE_MESSAGE_WARNING;
    snprintf(said, sizeof said, "%s", text);
}

static pave_result diagram(int32_t backend, int32_t side, double half_side, int32_t iterations, pave_cvd **out)
{
    pave_context_params params = failing_params(&memory);
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    pave_context *context = NULL;
    pave_field *field = NULL;
    params.backend = backend;
    params.threads = 2;
    params.message = on_message;
    cvd.half_side = half_side;
    cvd.iterations = iterations;
    errors = warnings = 0;
    assert_ok(pave_context_create(&params, &context));
    pave_image *drawing = draw_shapes(context, side, side);
    assert_ok(pave_field_create(context, drawing, NULL, &field));
    pave_image_free(&drawing);
    pave_result result = pave_cvd_create(context, field, &cvd, out);
    pave_field_free(&field);
    pave_context_free(&context);
    return result;
}

static void arm(int64_t at, int lost)
{
    faults.calls = 0;
    faults.fail_at = at;
    faults.lost = lost;
    faults.failed = NULL;
}

/* Does the sentence say what the driver said? */
static int in_its_words(void)
{
    static const char *const words[] = { "memory", "lost", "reset", "context", "driver", "draw", "cannot", "screen" };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strstr(said, words[i]))
            return 1;
    return 0;
}

/* Fails every `step`-th call of a small job, until the job gets through without having met its fault. */
static void sweep(int32_t backend, int lost, int64_t step)
{
    enum { SIDE = 40, STEPS = 2 };
    pave_cvd *right = NULL, *cvd = NULL;
    int64_t at = 1, failures = 0;
    assert_ok(diagram(PAVE_BACKEND_CPU, SIDE, 4, STEPS, &right));
    for (;; at += step) {
        arm(at, lost);
        pave_result result = diagram(backend, SIDE, 4, STEPS, &cvd);
        if (!faults.failed) {
            assert_ok(result);
            break;
        }
        if (!result) { /* it has another way: a second display, a plain context */
            assert_same_diagram(cvd, right);
            pave_cvd_free(&cvd);
            continue;
        }
        failures++;
        if (result != PAVE_ERR_DEVICE || errors != 1 || !in_its_words())
            fail_msg("%s: %d, %d errors, the last: %s", faults.failed, (int)result, (int)errors, said);
        assert_null(cvd);
        if (!lost && !strcmp(faults.failed, "vkWaitForFences"))
            faults.live = 0; /* the work may be under way for all that the engine knows: it lets everything be */
        assert_int_equal(faults.live, 0);
    }
    assert_true(failures > 4);
    assert_same_diagram(cvd, right);
    pave_cvd_free(&cvd);
    pave_cvd_free(&right);
    assert_int_equal(memory.blocks, 0);
    assert_int_equal(faults.live, 0);
    print_message("  %lld calls, %lld failures told, e.g. %s\n", (long long)at, (long long)failures, said);
}

/* Skips, and says why, where there is no device for a backend. */
static void need_device(int32_t backend)
{
    pave_context *context = make_context(1, PAVE_BACKEND_AUTO);
    arm(0, 0);
    int usable = is_usable(context, backend);
    pave_context_free(&context);
    if (usable)
        return;
    print_message("skipped: no device\n");
    skip();
}

static void vulkan_compute_fails(void **state)
{
    (void)state;
    need_device(PAVE_BACKEND_VULKAN_COMPUTE);
    sweep(PAVE_BACKEND_VULKAN_COMPUTE, 0, 1);
    sweep(PAVE_BACKEND_VULKAN_COMPUTE, 1, 1);
}

static void vulkan_raster_fails(void **state)
{
    (void)state;
    need_device(PAVE_BACKEND_VULKAN_RASTER);
    sweep(PAVE_BACKEND_VULKAN_RASTER, 0, 1);
    sweep(PAVE_BACKEND_VULKAN_RASTER, 1, 1);
}

static void gles_fails(void **state)
{
    (void)state;
    need_device(PAVE_BACKEND_GLES);
    sweep(PAVE_BACKEND_GLES, 0, 1);
    sweep(PAVE_BACKEND_GLES, 1, 1);
    faults.reset = 1;
    sweep(PAVE_BACKEND_GLES, 1, 1);
    faults.reset = 0;
}

/* A job that is worth a GPU, on a device that says it is one and is too small for it, or is lost in the middle of the
 * work: all is done by the CPU, with a warning. */
static void auto_goes_on_with_the_cpu(void **state)
{
    enum { SIDE = 320, STEPS = 9999 };
    static const char *const reason[] = { "lay it in windows", "the device was lost" };
    pave_cvd *right = NULL;
    (void)state;
    need_device(PAVE_BACKEND_VULKAN_COMPUTE);
    assert_ok(diagram(PAVE_BACKEND_CPU, SIDE, 32, STEPS, &right));
    faults.pose_as_gpu = 1;
    for (int i = 0; i < 2; i++) {
        pave_cvd *cvd = NULL;
        arm(i ? 400 : 0, 1);
        faults.small = !i;
        assert_ok(diagram(PAVE_BACKEND_AUTO, SIDE, 32, STEPS, &cvd));
        print_message("  %s\n", said);
        assert_int_equal(warnings, 1);
        assert_non_null(strstr(said, "going on with the CPU"));
        assert_non_null(strstr(said, reason[i]));
        assert_int_equal(pave_cvd_backend(cvd), PAVE_BACKEND_CPU);
        assert_same_diagram(cvd, right);
        pave_cvd_free(&cvd);
    }
    faults.pose_as_gpu = 0;
    pave_cvd_free(&right);
    assert_int_equal(memory.blocks, 0);
    assert_int_equal(faults.live, 0);
}

/* With an argument, only tests of such a name: "vulkan*". */
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vulkan_compute_fails),
        cmocka_unit_test(vulkan_raster_fails),
        cmocka_unit_test(gles_fails),
        cmocka_unit_test(auto_goes_on_with_the_cpu),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("faults", tests, NULL, NULL);
}
