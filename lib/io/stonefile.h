/* Stones in a binary file: a head of PV_STONE_FILE_HEAD bytes, then for each stone, in the order of their numbers,
 * int32 number, uint8 colour, uint8 part (of a stone that was cut), uint16 corners, and the corners' int32 x and y in
 * 1/1000 px; little endian. */
#pragma once

#include "stones/stones.h"

enum { PV_STONE_FILE_HEAD = 8192, PV_STONE_RECORD = 8, PV_STONE_CORNERS = 256 };

typedef struct pv_stone_file_head {
    char magic[8]; /* PV_STONE_FILE_MAGIC */
    int32_t mark;  /* 0x01020304 */
    int32_t sizes[5]; /* of the structs below, and of this one: another version's do not fit */
    int32_t x, y, width, height; /* of the window */
    int32_t plane_width, plane_height;
    int32_t count;
    int64_t bytes; /* of the records */
    uint64_t drawing; /* its hash; 0 if only the whole was laid */
    int64_t counts[256]; /* stones of each colour */
    pave_report report;
    pave_cvd_params cvd;
    pave_stones_params stones;
    pave_field_params field;
    pave_threshold_params threshold;
    pave_palette_params palette;
    int32_t backend;
    char backend_name[128];
} pv_stone_file_head;

#define PV_STONE_FILE_MAGIC "PAVSTON1"

/* Writes a pile. */
struct pv_pile;
pave_result pv_stones_file_write(pave_context *context, struct pv_pile *pile, const char *path);

/* Everything that stones follow from, but for the window: where two agree, their stones are of one pavement. */
typedef struct pv_making {
    uint64_t drawing;
    const pave_threshold_params *threshold;
    const pave_palette_params *palette;
    const pave_field_params *field;
    const pave_cvd_params *cvd;
    const pave_stones_params *stones;
} pv_making;

int pv_stones_file_same(const pv_stone_file_head *head, const pv_making *making);

/* Reads and checks a head; the first without a word, but with the reason of a failure. */
pave_result pv_stones_file_look(const char *path, pv_stone_file_head *head, const char **reason);
pave_result pv_stones_file_head(pave_context *context, const char *path, pv_stone_file_head *head);
