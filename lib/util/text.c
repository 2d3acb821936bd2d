/* Numbers to text and back. printf and strtod follow the locale's decimal separator; here it is put right. */
#include "util/text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void pv_text_number(char *out, size_t capacity, double value)
{
    char text[40];
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    size_t plain = strspn(text, "+-0123456789einfa"), mark = strcspn(text + plain, "0123456789e");
    snprintf(out, capacity, "%.*s%s%s", (int)plain, text, mark ? "." : "", text + plain + mark);
}

size_t pv_text_thousandths(char *out, int64_t value)
{
    char *p = out;
    if (value < 0)
        *p++ = '-', value = -value;
    p += sprintf(p, "%lld", (long long)(value / 1000));
    int32_t part = (int32_t)(value % 1000);
    if (part) {
        *p++ = '.';
        for (int32_t place = 100; part; part %= place, place /= 10)
            *p++ = (char)('0' + part / place);
    }
    *p = 0;
    return (size_t)(p - out);
}

int pv_parse_whole(const char *text, uint64_t *out)
{
    uint64_t value = 0;
    if (!*text)
        return 0;
    for (; *text; text++)
        if (*text < '0' || *text > '9' || __builtin_mul_overflow(value, 10u, &value) ||
            __builtin_add_overflow(value, (uint64_t)(*text - '0'), &value))
            return 0;
    *out = value;
    return 1;
}

int pv_parse_bytes(const char *text, double *out)
{
    static const char units[] = "KMGT";
    char number[40];
    size_t length = strlen(text);
    const char *unit = length ? strchr(units, text[length - 1]) : NULL;
    if (!length || length >= sizeof number)
        return 0;
    memcpy(number, text, length + 1);
    if (unit)
        number[length - 1] = 0;
    if (!pv_parse_number(number, out))
        return 0;
    *out = floor(*out * (unit ? (double)((int64_t)1 << 10 * (unit - units + 1)) : 1));
    return *out < 9e18;
}

/* strtod with the separator that this locale wants, found by printing one. */
int pv_parse_number(const char *text, double *out)
{
    char copy[80], half[16], *end;
    size_t length = strlen(text), whole = strcspn(text, ".");
    if (!length || length > 60 || strspn(text, "0123456789+-.eE") != length)
        return 0;
    size_t mark = (size_t)snprintf(half, sizeof half, "%.1f", 0.5) - 2;
    snprintf(copy, sizeof copy, "%.*s%.*s%s", (int)whole, text, text[whole] ? (int)mark : 0, half + 1,
             text + whole + (text[whole] != 0));
    *out = strtod(copy, &end);
    return !*end && isfinite(*out);
}

static size_t digits(const char *text, size_t size, size_t at)
{
    size_t begin = at;
    while (at < size && text[at] >= '0' && text[at] <= '9')
        at++;
    return at - begin;
}

/* "e-12" at a place in the text; without digits it is not part of the number. */
static size_t exponent(const char *text, size_t size, size_t at, int *out)
{
    size_t sign = at + 1 < size && (text[at + 1] == '-' || text[at + 1] == '+'), n;
    if (at >= size || (text[at] != 'e' && text[at] != 'E') || !(n = digits(text, size, at + 1 + sign)))
        return 0;
    for (size_t i = 0; i < n; i++)
        *out = *out < 1000 ? *out * 10 + (text[at + 1 + sign + i] - '0') : *out;
    *out = text[at + 1] == '-' ? -*out : *out;
    return 1 + sign + n;
}

/* A whole number times a power of ten, rounded half away from 0; -1 if it is beyond 2^40 millionths' worth. */
static int64_t scaled(uint64_t value, int power)
{
    const uint64_t most = (uint64_t)1 << 60;
    for (; power > 0 && value && value < most; power--)
        value *= 10;
    for (; power < -1 && value; power++)
        value /= 10;
    if (power < 0)
        value = (value + 5) / 10;
    return value < most ? (int64_t)value : -1;
}

size_t pv_parse_millionths(const char *text, size_t size, int64_t *out)
{
    size_t at = size && (*text == '-' || *text == '+'), whole = digits(text, size, at);
    size_t point = at + whole < size && text[at + whole] == '.', part = point ? digits(text, size, at + whole + 1) : 0;
    int power = 6, shift = 0;
    uint64_t value = 0;
    if (!whole && !part)
        return 0;
    for (size_t i = 0; i < whole + point + part; i++) {
        char c = text[at + i];
        int behind = i > whole;
        if (c == '.')
            continue;
        if (value < (uint64_t)1 << 59)
            value = value * 10 + (uint64_t)(c - '0'), power -= behind;
        else
            power += !behind && power < 1000;
    }
    at += whole + point + part;
    at += exponent(text, size, at, &shift);
    int64_t v = scaled(value, power + shift);
    if (v < 0)
        return 0;
    *out = *text == '-' ? -v : v;
    return at;
}

int pv_text_ends_with(const char *text, const char *ending)
{
    size_t length = strlen(text), n = strlen(ending);
    if (length < n)
        return 0;
    for (text += length - n; *text; text++, ending++)
        if ((*text >= 'A' && *text <= 'Z' ? *text + 32 : *text) != *ending)
            return 0;
    return 1;
}
