/* pave info: what there is to work with. */
#include "cli.h"

#include <stdio.h>
#include <string.h>

enum { MOST_DEVICES = 32 };

/* The name of a backend, from the table that also reads it. */
static void backend_name(int32_t backend, char *out, size_t capacity)
{
    for (int32_t i = 0; i < pave_params_count(PAVE_PARAMS_CONTEXT); i++) {
        pave_param param;
        pave_params_describe(PAVE_PARAMS_CONTEXT, i, &param);
        if (strcmp(param.name, "backend"))
            continue;
        const char *choice = param.choices;
        for (int32_t k = 0; k < backend; k++)
            choice = strchr(choice, '|') + 1;
        snprintf(out, capacity, "%.*s", (int)strcspn(choice, "|"), choice);
    }
}

static void print_json_text(const char *text)
{
    putchar('"');
    for (; *text; text++)
        if ((unsigned char)*text < 32)
            printf("\\u%04x", (unsigned)*text);
        else
            printf(*text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    putchar('"');
}

static void print_device(const pave_device *device, int json, int last)
{
    char name[64] = "";
    backend_name(device->backend, name, sizeof name);
    if (!json) {
        printf("%-15s %s%s\n", name, device->usable ? "" : "not usable: ", device->name);
        return;
    }
    printf("    {\"backend\": \"%s\", \"usable\": %s, \"name\": ", name, device->usable ? "true" : "false");
    print_json_text(device->name);
    printf("}%s\n", last ? "" : ",");
}

static void print_devices(const pave_device *devices, int32_t count, int json)
{
    if (json)
        printf("{\n  \"pave\": \"%s\",\n  \"devices\": [\n", pave_version());
    else
        printf("pave %s\n", pave_version());
    for (int32_t i = 0; i < count; i++)
        print_device(&devices[i], json, i + 1 == count);
    if (json)
        printf("  ]\n}\n");
}

int info_main(int argc, char **argv)
{
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    const cli_group groups[] = { { "Machine", PAVE_PARAMS_CONTEXT, &params } };
    cli_command command = {
        .verb = "info",
        .usage = "[options]",
        .summary = "Lists the backends and the devices that they find on this machine.",
        .json = "as JSON",
        .groups = groups,
        .group_count = 1,
    };
    int status = read_command(&command, argc, argv);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_context *context = start(&command, &params);
    if (!context)
        return EXIT_USAGE;
    pave_device devices[MOST_DEVICES];
    int32_t count = 0;
    for (int i = 0; i < MOST_DEVICES; i++)
        devices[i].size = sizeof *devices;
    status = exit_code(pave_devices(context, devices, MOST_DEVICES, &count), WHILE_WORKING);
    if (!status)
        print_devices(devices, count < MOST_DEVICES ? count : MOST_DEVICES, command.wants_json);
    finish(&context);
    return status;
}
