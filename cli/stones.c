/* What the verbs that lay stones write. */
#include "cli.h"

int write_stones(const cli_command *command, pave_context *context, const pave_stones *stones)
{
    pave_result result = PAVE_OK;
    for (int i = 0; i < command->output_count && !result; i++) {
        phase(0.9 + 0.1 * i / command->output_count, 0.9 + 0.1 * (i + 1) / command->output_count);
        result = pave_stones_write(context, stones, command->output[i], NULL);
    }
    if (!result && command->wants_json)
        result = pave_stones_write(context, stones, "-", "json");
    return exit_code(result, WHILE_WRITING);
}
