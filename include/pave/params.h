/* The parameter tables: every field of every params struct, described once. The command line, its help, the manual,
 * range checks, fuzzers and bindings all read these tables. */
#ifndef PAVE_PARAMS_H
#define PAVE_PARAMS_H

#include <pave/context.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The structs that have a table. */
enum {
    PAVE_PARAMS_CONTEXT = 1,   /* pave_context_params: threads, backend */
    PAVE_PARAMS_LIMITS = 2,    /* pave_limits */
    PAVE_PARAMS_THRESHOLD = 3, /* pave_threshold_params */
    PAVE_PARAMS_FIELD = 4,     /* pave_field_params */
    PAVE_PARAMS_CVD = 5,       /* pave_cvd_params */
    PAVE_PARAMS_STONES = 6,    /* pave_stones_params */
    PAVE_PARAMS_STREAM = 7,    /* pave_stream_params */
    PAVE_PARAMS_TILING = 12,   /* pave_tiling_params */
    PAVE_PARAMS_SOLID = 13,    /* pave_solid_params */
    PAVE_PARAMS_BTF_SYNTHESIS = 20, /* pave_btf_synthesis_params */
    PAVE_PARAMS_BTF_COMPRESS = 21,  /* pave_btf_compress_params */
    PAVE_PARAMS_BTF_VIEW = 22,      /* pave_btf_view_params */
    PAVE_PARAMS_BTF_FILE = 23,      /* pave_btf_file_params */
    PAVE_PARAMS_BTF_TEXELS = 24,    /* pave_btf_texels_params */
    PAVE_PARAMS_BTF_SHEET = 25,     /* pave_btf_sheet_params */
    PAVE_PARAMS_BTF_MODEL = 26,     /* pave_btf_model_params */
    PAVE_PARAMS_BTF_PLAN = 27,      /* pave_btf_plan_params */
    PAVE_PARAMS_BTF_RECONSTRUCT = 28, /* pave_btf_reconstruct_params */
    PAVE_PARAMS_BTF_MEASURE = 29,   /* pave_btf_measure_params */
    PAVE_PARAMS_BTF_ENLARGE = 33,   /* pave_btf_enlarge_params */
    PAVE_PARAMS_PALETTE = 30,  /* pave_palette_params */
    PAVE_PARAMS_MEASURE = 31,  /* pave_stones_measure_params */
    PAVE_PARAMS_MOSAIC = 40    /* pave_mosaic_params */
};

/* How a field is stored. */
enum {
    PAVE_PARAM_REAL = 1,    /* double */
    PAVE_PARAM_INTEGER = 2, /* int32_t */
    PAVE_PARAM_LONG = 3,    /* int64_t */
    PAVE_PARAM_SEED = 4,    /* uint64_t */
    PAVE_PARAM_FLAG = 5,    /* int32_t, 0 or 1 */
    PAVE_PARAM_CHOICE = 6,  /* int32_t, an index into `choices` */
    PAVE_PARAM_WINDOW = 7,  /* int32_t[4], as text "X,Y,WIDTH,HEIGHT" */
    PAVE_PARAM_PALETTE = 9, /* pave_palette, as text "#rrggbb,#rrggbb" with commas or white space between */
    PAVE_PARAM_EXTENT = 10  /* int32_t[2], as text "WIDTHxHEIGHT" */
};

/* Some colours. */
typedef struct pave_palette {
    int32_t count;    /* 0 .. 256; 0 stands for black and white */
    uint8_t rgb[768]; /* r, g, b of each, display values (sRGB) */
} pave_palette;

typedef struct pave_param {
    const char *name;    /* the field's name, "half_side" */
    int32_t type;        /* PAVE_PARAM_ */
    const char *unit;    /* "px", "degrees"; "" for a pure number */
    double least;        /* smallest and greatest legal value */
    double greatest;
    double initial;      /* the default */
    const char *choices; /* "chamfer|euclid", in the order of their values; NULL for other types */
    const char *help;    /* one sentence */
} pave_param;

/* Number of fields in a table, 0 for an unknown one. Any thread. */
PAVE_API int32_t pave_params_count(int32_t table);

/* Describes field `index` of a table. The strings live as long as the library. Any thread. */
PAVE_API pave_result pave_params_describe(int32_t table, int32_t index, pave_param *out);

/* Sets one field of an initialised params struct from text: params_set(context, PAVE_PARAMS_CVD, &p, "half_side",
 * "4.5"). Names may be written with '-' for '_'; the decimal separator is '.' in every locale. PAVE_ERR_ARGUMENT,
 * with a sentence that names the field and its range, if there is no such field or the text is not a legal value. */
PAVE_API pave_result pave_params_set(pave_context *context, int32_t table, void *params, const char *name,
                                     const char *value);

#ifdef __cplusplus
}
#endif

#endif
