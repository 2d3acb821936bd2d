/* Numbers to text and back, the same in every locale. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* The shortest decimal text that reads back as the same double ("4.5", "nan"). Cuts what does not fit. */
void pv_text_number(char *out, size_t capacity, double value);

/* value / 1000 with no more digits than needed ("12.3"). Writes at most 24 bytes, returns their number. */
size_t pv_text_thousandths(char *out, int64_t value);

/* The whole of `text` as a finite number, or as a whole number below 2^64. 0 if it is not one. */
int pv_parse_number(const char *text, double *out);
int pv_parse_whole(const char *text, uint64_t *out);

/* A number of bytes: "1500000", "64M", "1.5G" (powers of 1024). */
int pv_parse_bytes(const char *text, double *out);

/* A decimal number ("-12.5e-1") at the beginning of the text as a whole number of 1/1000000, rounded half away from 0.
 * Returns how long it is; 0 if there is none, or if it is beyond 2^40. */
size_t pv_parse_millionths(const char *text, size_t size, int64_t *out);

/* Of an ending in small letters. Case does not matter, and neither does what the locale says about it. */
int pv_text_ends_with(const char *text, const char *ending);
