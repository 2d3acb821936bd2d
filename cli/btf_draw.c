/* The verbs of pave btf that draw one: view, plot, sheet. */
#include "btf.h"

static pave_result draw(const btf_job *job, const pave_btf_view_params *params, const pave_image *environment,
                        const pave_btf *btf, const char *against, double scale)
{
    pave_image *picture = NULL;
    pave_btf *other = NULL;
    pave_result result = against ? pave_btf_read(job->context, against, &job->files, &other) : PAVE_OK;
    if (!result)
        result = other ? pave_btf_view_difference(job->context, btf, other, environment, params, scale, &picture)
                       : pave_btf_view(job->context, btf, environment, params, &picture);
    pave_btf_free(&other);
    if (!result)
        result = pave_image_write(job->context, picture, job->command.output[0]);
    pave_image_free(&picture);
    return result;
}

enum { LIGHT, VIEW, AGAINST, SCALE, NAMED };

static int read_view(const btf_job *job, const cli_named *named, pave_btf_view_params *params, double *scale)
{
    static const char *const light[2] = { "light-theta", "light-phi" }, *const view[2] = { "view-theta", "view-phi" };
    const cli_group group = { "Picture", PAVE_PARAMS_BTF_VIEW, params };
    int status = btf_set_list(job, &named[LIGHT], &group, light, 2, 2);
    if (!status)
        status = btf_set_list(job, &named[VIEW], &group, view, 2, 2);
    return status ? status : btf_read_number(job, &named[SCALE], 0, 1e6, scale);
}

int btf_view(int argc, char **argv)
{
    pave_btf_view_params params = PAVE_BTF_VIEW_PARAMS_INIT;
    pave_btf *btf = NULL;
    pave_image *environment = NULL;
    double scale = 20;
    cli_named named[NAMED] = {
        [LIGHT] = { .usage = "light THETA,PHI", .help = "where the lamp is, degrees", .most = 1 },
        [VIEW] = { .usage = "view THETA,PHI", .help = "where the camera is, degrees", .most = 1 },
        [AGAINST] = { .usage = "against BTF", .help = "draw the difference to this one", .most = 1 },
        [SCALE] = { .usage = "scale N", .help = "times the difference [20]", .most = 1 },
    };
    btf_job job = { .command = {
        .verb = "btf view",
        .usage = "BTF [ENVIRONMENT] -o FILE [options]",
        .summary = "Draws a material on a plane, a cylinder or a sphere, under a lamp or an environment picture.",
        .outputs = "write picture.png or picture.exr",
        .inputs = -1,
        .named = named,
        .named_count = NAMED,
    } };
    int status = btf_begin(&job, (cli_group){ "Picture", PAVE_PARAMS_BTF_VIEW, &params }, argc, argv);
    if (!status)
        status = read_view(&job, named, &params, &scale);
    if (!status)
        status = btf_read(&job, 0, 0, 0.1, &btf);
    if (!status && job.command.input_count > 1)
        status = exit_code(read_image(job.context, job.command.input[1], &environment), WHILE_READING);
    phase(0.1, 1);
    if (!status)
        status = exit_code(draw(&job, &params, environment, btf, named[AGAINST].value[0], scale), WHILE_WRITING);
    pave_image_free(&environment);
    pave_btf_free(&btf);
    return btf_end(&job, status);
}

typedef pave_result sheet_maker(pave_context *context, const pave_btf *btf, const pave_btf_sheet_params *params,
                                pave_image **out);

static int draw_sheet(int argc, char **argv, const char *verb, const char *summary, sheet_maker *make)
{
    pave_btf_sheet_params params = PAVE_BTF_SHEET_PARAMS_INIT;
    pave_btf *btf = NULL;
    pave_image *picture = NULL;
    btf_job job = { .command = { .verb = verb, .usage = "BTF -o FILE [options]", .summary = summary,
                                 .outputs = "write sheet.png or sheet.exr", .inputs = 1 } };
    int status = btf_begin(&job, (cli_group){ "Sheet", PAVE_PARAMS_BTF_SHEET, &params }, argc, argv);
    if (!status)
        status = btf_read(&job, 0, 0, 0.1, &btf);
    phase(0.1, 1);
    if (!status)
        status = exit_code(make(job.context, btf, &params, &picture), WHILE_WORKING);
    if (!status)
        status = exit_code(pave_image_write(job.context, picture, job.command.output[0]), WHILE_WRITING);
    pave_image_free(&picture);
    pave_btf_free(&btf);
    return btf_end(&job, status);
}

int btf_sheet(int argc, char **argv)
{
    return draw_sheet(argc, argv, "btf sheet", "Draws textures side by side: a row for each view, a column a light.",
                      pave_btf_contact_sheet);
}

int btf_plot(int argc, char **argv)
{
    return draw_sheet(argc, argv, "btf plot", "Draws an ABRDF: for each view a disc of all lights.", pave_btf_plot);
}
