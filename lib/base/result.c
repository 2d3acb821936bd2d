/* Names of results, and the version. */
#include <pave/base.h>

const char *pave_result_name(pave_result result)
{
    static const char *const names[] = {
        "PAVE_OK",         "PAVE_ERR_ARGUMENT",    "PAVE_ERR_MEMORY", "PAVE_ERR_LIMIT",
        "PAVE_ERR_TOO_NEW", "PAVE_ERR_IO",         "PAVE_ERR_FORMAT", "PAVE_ERR_UNSUPPORTED",
        "PAVE_ERR_DEVICE", "PAVE_ERR_CANCELLED",   "PAVE_ERR_INTERNAL",
    };
    return result <= 0 && result >= PAVE_ERR_INTERNAL ? names[-result] : "unknown result";
}

const char *pave_version(void)
{
    return PAVE_VERSION_STRING;
}
