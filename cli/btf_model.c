/* pave btf model: models of classes of materials, given or found. */
#include "btf.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { MOST_MATERIALS = 4096, PATH = 4096 };

/* Materials by path. */
typedef struct material_list {
    char **path;
    pave_btf **btf;
    int count, room;
} material_list;

static int add_path(material_list *list, const char *folder, const char *name)
{
    if (list->count == list->room) {
        int room = list->room ? 2 * list->room : 16;
        char **more = realloc(list->path, (size_t)room * sizeof *more);
        if (!more)
            return EXIT_RESOURCES;
        list->path = more;
        list->room = room;
    }
    size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    if (!path)
        return EXIT_RESOURCES;
    snprintf(path, size, "%s%s%s", folder, *folder ? "/" : "", name);
    list->path[list->count++] = path;
    return EXIT_FINE;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static int is_folder(const char *path)
{
    struct stat info;
    return !stat(path, &info) && S_ISDIR(info.st_mode);
}

static int is_material(const char *folder, const char *name)
{
    static const char *const endings[] = { ".bdi", ".btf", ".exr", ".big", ".zip" };
    char path[PATH];
    const char *point = strrchr(name, '.');
    snprintf(path, sizeof path, "%s/%s", folder, name);
    for (size_t i = 0; i < sizeof endings / sizeof *endings && point; i++)
        if (!strcmp(point, endings[i]))
            return 1;
    return name[0] != '.' && is_folder(path);
}

/* A folder's BTFs in the order of their names; it may hold folders of pictures, too. */
static int list_folder(const btf_job *job, const char *folder, material_list *list)
{
    DIR *open = opendir(folder);
    int status = EXIT_FINE;
    if (!open) {
        complain(&job->command, "%s: cannot be read", folder);
        return EXIT_INPUT;
    }
    for (struct dirent *entry = readdir(open); entry && !status && list->count < MOST_MATERIALS; entry = readdir(open))
        if (is_material(folder, entry->d_name))
            status = add_path(list, folder, entry->d_name);
    closedir(open);
    if (!status && !list->count) {
        complain(&job->command, "%s: holds no BTF", folder);
        status = EXIT_INPUT;
    }
    qsort(list->path, (size_t)list->count, sizeof *list->path, by_name);
    return status;
}

static int list_materials(const btf_job *job, material_list *list)
{
    int status = EXIT_FINE;
    if (job->command.input_count == 1 && is_folder(job->command.input[0]))
        return list_folder(job, job->command.input[0], list);
    for (int i = 0; i < job->command.input_count && !status; i++)
        status = add_path(list, "", job->command.input[i]);
    return status;
}

static int read_materials(const btf_job *job, material_list *list)
{
    int status = list_materials(job, list);
    list->btf = status ? NULL : calloc((size_t)list->count, sizeof(pave_btf *));
    for (int i = 0; i < list->count && !status; i++) {
        phase(0.1 * i / list->count, 0.1 * (i + 1) / list->count);
        status = list->btf ? exit_code(pave_btf_read(job->context, list->path[i], &job->files, &list->btf[i]),
                                       WHILE_READING)
                           : EXIT_RESOURCES;
    }
    return status;
}

static void free_materials(material_list *list)
{
    for (int i = 0; i < list->count; i++) {
        if (list->btf)
            pave_btf_free(&list->btf[i]);
        free(list->path[i]);
    }
    free(list->btf);
    free(list->path);
}

/* One model of the materials that are in a class; class -1: of all. */
static int make_model(const btf_job *job, const material_list *list, const int32_t *label, int32_t class_of,
                      const pave_btf_model_params *params, const char *path, double from, double to)
{
    const pave_btf **own = calloc((size_t)list->count, sizeof(pave_btf *));
    pave_btf_model *model = NULL;
    int32_t count = 0;
    for (int i = 0; i < list->count && own; i++)
        if (class_of < 0 || label[i] == class_of)
            own[count++] = list->btf[i];
    phase(from, from + 0.95 * (to - from));
    int status = own ? exit_code(pave_btf_model_create(job->context, own, count, params, &model), WHILE_WORKING)
                     : EXIT_RESOURCES;
    phase(from + 0.95 * (to - from), to);
    if (!status)
        status = exit_code(pave_btf_model_write(job->context, model, path), WHILE_WRITING);
    if (!status && class_of < 0 && job->command.wants_json)
        status = exit_code(pave_btf_model_info_write(job->context, model, "-", "json"), WHILE_WRITING);
    pave_btf_model_free(&model);
    free(own);
    return status;
}

static void put_string(const char *text)
{
    putchar('"');
    for (; *text; text++)
        if ((unsigned char)*text < ' ')
            printf("\\u%04x", (unsigned)(unsigned char)*text);
        else
            printf(*text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    putchar('"');
}

static void tell_classes(const material_list *list, const int32_t *label, int32_t classes, double within)
{
    printf("{\n  \"classes\": %d,\n  \"within\": %.6g,\n  \"materials\": [", (int)classes, within);
    for (int i = 0; i < list->count; i++) {
        printf("%s\n    { \"path\": ", i ? "," : "");
        put_string(list->path[i]);
        printf(", \"class\": %d }", (int)label[i] + 1);
    }
    printf("\n  ]\n}\n");
}

/* A model for each class that was found: FOLDER/1.model ... */
static int make_classes(const btf_job *job, const material_list *list, int32_t classes,
                        const pave_btf_model_params *params)
{
    int32_t *label = calloc((size_t)list->count, sizeof *label);
    double within = 0;
    phase(0.1, 0.3);
    const pave_btf *const *btfs = (const pave_btf *const *)list->btf;
    int status = label ? exit_code(pave_btf_cluster(job->context, btfs, list->count, classes, params, label, &within),
                                   WHILE_WORKING)
                       : EXIT_RESOURCES;
    if (!status && mkdir(job->command.output[0], 0777) && !is_folder(job->command.output[0])) {
        complain(&job->command, "%s: cannot be made", job->command.output[0]);
        status = EXIT_RESOURCES;
    }
    for (int32_t c = 0; c < classes && !status; c++) {
        char path[PATH];
        snprintf(path, sizeof path, "%s/%d.model", job->command.output[0], (int)c + 1);
        status = make_model(job, list, label, c, params, path, 0.3 + 0.7 * c / classes, 0.3 + 0.7 * (c + 1) / classes);
    }
    if (!status && job->command.wants_json)
        tell_classes(list, label, classes, within);
    for (int i = 0; i < list->count && !status && !job->command.wants_json && !job->command.quiet; i++)
        fprintf(stderr, "%s: class %d\n", list->path[i], (int)label[i] + 1);
    free(label);
    return status;
}

int btf_model(int argc, char **argv)
{
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    material_list list = { 0 };
    double classes = 1;
    cli_named clusters = { .usage = "clusters N", .help = "find N classes first; -o is a folder then", .most = 1 };
    btf_job job = { .command = {
        .verb = "btf model",
        .usage = "FOLDER | A.bdi B.bdi ... -o FILE.model [options]",
        .summary = "Fits a model to a class of materials: eigen-ABRDFs and eigen-ABTFs, for plan and reconstruct.",
        .outputs = "write class.model",
        .json = "tell what came out as JSON",
        .inputs = -1,
        .named = &clusters,
        .named_count = 1,
    } };
    int status = btf_begin(&job, (cli_group){ "Model", PAVE_PARAMS_BTF_MODEL, &params }, argc, argv);
    if (!status)
        status = btf_read_number(&job, &clusters, 1, MOST_MATERIALS, &classes);
    if (!status)
        status = read_materials(&job, &list);
    if (!status)
        status = clusters.count ? make_classes(&job, &list, (int32_t)classes, &params)
                                : make_model(&job, &list, NULL, -1, &params, job.command.output[0], 0.1, 1);
    free_materials(&list);
    return btf_end(&job, status);
}
