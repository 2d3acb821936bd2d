/* Messages, the progress bar, and Ctrl-C. */
#include "cli.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static pave_context *volatile running;
static int bar_shown;
static double phase_from, phase_to = 1;

void phase(double from, double to)
{
    phase_from = from;
    phase_to = to;
}

static volatile sig_atomic_t nothing_to_lose;

/* A second Ctrl-C ends the program at once, and so does the first one while there is nothing to clean up. */
static void on_signal(int number)
{
    if (nothing_to_lose)
        _exit(EXIT_CANCELLED);
    signal(number, SIG_DFL);
    pave_context_cancel(running);
}

pave_result read_image(pave_context *context, const char *path, pave_image **out)
{
    nothing_to_lose = 1;
    pave_result result = pave_image_read(context, path, out);
    nothing_to_lose = 0;
    return result;
}

static void hide_bar(void)
{
    if (bar_shown)
        fputs("\r\033[K", stderr);
    bar_shown = 0;
}

static void on_message(void *user, int32_t level, const char *text)
{
    const cli_command *command = user;
    hide_bar();
    if (level == PAVE_MESSAGE_ERROR || !command->quiet)
        complain(command, "%s%s", level == PAVE_MESSAGE_WARNING ? "warning: " : "", text);
}

static int32_t on_progress(void *user, const char *stage, double done)
{
    static const char full[] = "##############################";
    enum { WIDTH = sizeof full - 1 };
    done = phase_from + (phase_to - phase_from) * done;
    int filled = (int)(done * WIDTH);
    (void)user;
    fprintf(stderr, "\r[%.*s%*s] %3d %% %-12s", filled, full, WIDTH - filled, "", (int)(done * 100), stage);
    fflush(stderr);
    bar_shown = 1;
    return 0;
}

pave_context *start(const cli_command *command, pave_context_params *params)
{
    pave_context *context = NULL;
    params->message = on_message;
    params->message_user = (void *)(uintptr_t)command;
    if (!command->quiet && isatty(STDERR_FILENO))
        params->progress = on_progress;
    if (pave_context_create(params, &context))
        return NULL;
    running = context;
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    return context;
}

void finish(pave_context **context)
{
    hide_bar();
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
    running = NULL;
    pave_context_free(context);
}
