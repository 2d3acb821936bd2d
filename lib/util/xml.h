/* XML taken apart, strictly and as it lies in memory: tags, their attributes, and text between them. UTF-8; entities
 * are left as they stand, and a DOCTYPE that declares some is refused. */
#pragma once

#include <stddef.h>

/* A piece of the file. */
typedef struct pv_span {
    const char *at;
    size_t size;
} pv_span;

enum { PV_XML_END, PV_XML_OPEN, PV_XML_CLOSE, PV_XML_TEXT, PV_XML_BROKEN };

typedef struct pv_xml {
    const char *begin, *at, *end;
    pv_span name;       /* of the tag, without what stands before a colon */
    pv_span attributes; /* of PV_XML_OPEN */
    int empty;          /* <name/>: no PV_XML_CLOSE will follow */
    const char *reason; /* of PV_XML_BROKEN */
} pv_xml;

void pv_xml_begin(pv_xml *xml, const char *bytes, size_t size);

/* What comes next: PV_XML_. Text of white space alone is passed over, and so are comments and instructions. That tags
 * are closed in order is the caller's to see. */
int pv_xml_next(pv_xml *xml);

/* The value of an attribute of the tag at hand; 0 if it has none of that name. */
int pv_xml_attribute(const pv_xml *xml, const char *name, pv_span *value);

/* Lines begun up to what is being read, for messages. */
int pv_xml_line(const pv_xml *xml);

int pv_span_is(pv_span span, const char *text);
