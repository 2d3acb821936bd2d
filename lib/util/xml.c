/* XML taken apart. */
#include "util/xml.h"

#include <string.h>

static int is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* Bytes of other scripts are letters, too. */
static int is_name(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.' || c == ':' || (c & 0x80);
}

int pv_span_is(pv_span span, const char *text)
{
    return span.size == strlen(text) && !memcmp(span.at, text, span.size);
}

void pv_xml_begin(pv_xml *xml, const char *bytes, size_t size)
{
    memset(xml, 0, sizeof *xml);
    xml->begin = xml->at = bytes;
    xml->end = bytes + size;
    if (size >= 3 && !memcmp(bytes, "\xEF\xBB\xBF", 3))
        xml->at += 3;
}

int pv_xml_line(const pv_xml *xml)
{
    int line = 1;
    for (const char *p = xml->begin; p < xml->at; p++)
        line += *p == '\n';
    return line;
}

static int broken(pv_xml *xml, const char *reason)
{
    xml->reason = reason;
    return PV_XML_BROKEN;
}

static int starts(const pv_xml *xml, const char *text)
{
    size_t n = strlen(text);
    return (size_t)(xml->end - xml->at) >= n && !memcmp(xml->at, text, n);
}

/* Moves behind the next `text`; 0 if there is none. */
static int pass(pv_xml *xml, const char *text)
{
    const char *found = memmem(xml->at, (size_t)(xml->end - xml->at), text, strlen(text));
    if (found)
        xml->at = found + strlen(text);
    return found != NULL;
}

static void pass_space(pv_xml *xml)
{
    while (xml->at < xml->end && is_space(*xml->at))
        xml->at++;
}

static pv_span take_name(pv_xml *xml)
{
    pv_span name = { xml->at, 0 };
    while (xml->at < xml->end && is_name(*xml->at))
        xml->at++;
    name.size = (size_t)(xml->at - name.at);
    return name;
}

static pv_span local(pv_span name)
{
    const char *colon = memchr(name.at, ':', name.size);
    return colon ? (pv_span){ colon + 1, name.size - (size_t)(colon + 1 - name.at) } : name;
}

/* One name="value"; 0 if it is not well formed. */
static int take_attribute(pv_xml *xml, pv_span *name, pv_span *value)
{
    *name = take_name(xml);
    pass_space(xml);
    if (!name->size || xml->at == xml->end || *xml->at++ != '=')
        return 0;
    pass_space(xml);
    if (xml->at == xml->end || (*xml->at != '"' && *xml->at != '\''))
        return 0;
    char quote = *xml->at++;
    const char *close = memchr(xml->at, quote, (size_t)(xml->end - xml->at));
    if (!close || memchr(xml->at, '<', (size_t)(close - xml->at)))
        return 0;
    *value = (pv_span){ xml->at, (size_t)(close - xml->at) };
    xml->at = close + 1;
    return 1;
}

int pv_xml_attribute(const pv_xml *xml, const char *wanted, pv_span *value)
{
    pv_xml inside = { .at = xml->attributes.at, .end = xml->attributes.at + xml->attributes.size };
    pv_span name;
    for (pass_space(&inside); inside.at < inside.end; pass_space(&inside)) {
        if (!take_attribute(&inside, &name, value))
            return 0;
        if (pv_span_is(name, wanted))
            return 1;
    }
    return 0;
}

static int open_tag(pv_xml *xml)
{
    xml->at++;
    xml->name = local(take_name(xml));
    if (!xml->name.size)
        return broken(xml, "a tag has no name");
    xml->attributes.at = xml->at;
    for (;;) {
        const char *before = xml->at;
        pv_span name, value;
        pass_space(xml);
        xml->attributes.size = (size_t)(xml->at - xml->attributes.at);
        xml->empty = starts(xml, "/>");
        if (xml->empty || starts(xml, ">"))
            break;
        if (before == xml->at || !take_attribute(xml, &name, &value))
            return broken(xml, "a tag is not well formed");
    }
    xml->at += xml->empty ? 2 : 1;
    return PV_XML_OPEN;
}

static int close_tag(pv_xml *xml)
{
    xml->at += 2;
    xml->name = local(take_name(xml));
    pass_space(xml);
    if (!xml->name.size || !starts(xml, ">"))
        return broken(xml, "a closing tag is not well formed");
    xml->at++;
    return PV_XML_CLOSE;
}

/* <!DOCTYPE name PUBLIC "..." "..."> without declarations of its own. */
static int doctype(pv_xml *xml)
{
    while (xml->at < xml->end && *xml->at != '>' && *xml->at != '[') {
        const char *quote = *xml->at == '"' || *xml->at == '\'' ? xml->at : NULL;
        xml->at++;
        if (quote && !(quote = memchr(xml->at, *quote, (size_t)(xml->end - xml->at))))
            break;
        xml->at = quote ? quote + 1 : xml->at;
    }
    return starts(xml, ">") && xml->at++;
}

static int text(pv_xml *xml)
{
    const char *next = memchr(xml->at, '<', (size_t)(xml->end - xml->at));
    xml->at = next ? next : xml->end;
    return PV_XML_TEXT;
}

int pv_xml_next(pv_xml *xml)
{
    for (;;) {
        pass_space(xml);
        if (xml->at == xml->end)
            return PV_XML_END;
        if (*xml->at != '<')
            return text(xml);
        if (starts(xml, "<?") && pass(xml, "?>"))
            continue;
        if (starts(xml, "<!--") && pass(xml, "-->"))
            continue;
        if (starts(xml, "<![CDATA[") && pass(xml, "]]>"))
            return PV_XML_TEXT;
        if (starts(xml, "<!DOCTYPE")) {
            if (!doctype(xml))
                return broken(xml, "its DOCTYPE is not well formed, or declares entities");
            continue;
        }
        if (starts(xml, "<?") || starts(xml, "<!"))
            return broken(xml, "something is opened that is not closed");
        return starts(xml, "</") ? close_tag(xml) : open_tag(xml);
    }
}
