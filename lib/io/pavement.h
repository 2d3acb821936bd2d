/* Writers of stones, one a format. */
#pragma once

#include "io/pile.h"
#include "io/stonefile.h"

pave_result pv_svg_write(pave_context *context, pv_pile *pile, const char *path);
pave_result pv_preview_write(pave_context *context, const pave_stones *stones, const char *path);
pave_result pv_report_write(pave_context *context, pv_pile *pile, const char *path);
