/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/xml.h"

#include <expat.h>
#include <string.h>

struct parser {
    XML_Parser expat;
    const char *path;
    struct arena *arena;
    struct xml_budget *budget;
    struct error *err;
    lmn_status status; /* of a handler that stopped the parser */
    struct xml_node *root;
    struct xml_node *open[XML_MAX_DEPTH]; /* the path from the root to here */
    struct xml_node *last[XML_MAX_DEPTH]; /* the last child of each so far */
    uint32_t depth;
};

static struct place here(const struct parser *p)
{
    return (struct place){p->path, (uint32_t)XML_GetCurrentLineNumber(p->expat),
                          (uint32_t)XML_GetCurrentColumnNumber(p->expat) + 1};
}

static void stop(struct parser *p, lmn_status status)
{
    p->status = status;
    XML_StopParser(p->expat, XML_FALSE);
}

/* One block for the node, its attributes and all their text. */
static struct xml_node *new_node(struct parser *p, const char *name, const char **attributes)
{
    size_t n = 0, size = strlen(name) + 1;
    for (; attributes[2 * n]; n++)
        size += strlen(attributes[2 * n]) + strlen(attributes[2 * n + 1]) + 2;
    size_t header = sizeof(struct xml_node) + n * sizeof(struct xml_attribute);
    char *block = arena_new(p->arena, header + size, 1);
    if (!block) return NULL;
    struct xml_node *node = (struct xml_node *)(void *)block;
    char *text = block + header;
    node->attributes = (struct xml_attribute *)(void *)(block + sizeof *node);
    node->n_attributes = (uint32_t)n;
    node->name = strcpy(text, name);
    text += strlen(name) + 1;
    for (size_t i = 0; i < n; i++) {
        node->attributes[i].name = strcpy(text, attributes[2 * i]);
        text += strlen(text) + 1;
        node->attributes[i].value = strcpy(text, attributes[2 * i + 1]);
        text += strlen(text) + 1;
    }
    node->place = here(p);
    return node;
}

static void on_start(void *user, const XML_Char *name, const XML_Char **attributes)
{
    struct parser *p = user;
    if (p->status != LMN_OK) return;
    if (p->depth == XML_MAX_DEPTH) {
        stop(p, fail_at(p->err, here(p), "elements are nested deeper than %d", XML_MAX_DEPTH));
        return;
    }
    if (p->budget->n_nodes == 0) {
        stop(p, fail_at(p->err, here(p), "more than %d elements", XML_MAX_NODES));
        return;
    }
    struct xml_node *node = new_node(p, name, attributes);
    if (!node) {
        stop(p, fail_memory(p->err, p->path));
        return;
    }
    p->budget->n_nodes--;
    if (p->depth == 0) {
        p->root = node;
    } else {
        struct xml_node *parent = p->open[p->depth - 1], **last = &p->last[p->depth - 1];
        if (*last) {
            (*last)->next = node;
        } else {
            parent->first_child = node;
        }
        *last = node;
    }
    p->open[p->depth] = node;
    p->last[p->depth] = NULL;
    p->depth++;
}

static void on_end(void *user, const XML_Char *name)
{
    struct parser *p = user;
    (void)name;
    if (p->status == LMN_OK) p->depth--;
}

static void on_text(void *user, const XML_Char *text, int n)
{
    struct parser *p = user;
    if (p->status != LMN_OK) return;
    for (int i = 0; i < n; i++) {
        if (strchr(" \t\r\n", text[i]) && text[i]) continue;
        stop(p, fail_at(p->err, here(p), "unexpected text in <%s>",
                        p->depth ? p->open[p->depth - 1]->name : ""));
        return;
    }
}

/* No scene needs entities of its own, and they are what XML bombs are made of. */
static void on_entity(void *user, const XML_Char *name, int is_parameter, const XML_Char *value,
                      int value_length, const XML_Char *base, const XML_Char *system_id,
                      const XML_Char *public_id, const XML_Char *notation)
{
    struct parser *p = user;
    (void)is_parameter, (void)value, (void)value_length, (void)base;
    (void)system_id, (void)public_id, (void)notation;
    if (p->status == LMN_OK)
        stop(p, fail_at(p->err, here(p), "entity declarations (\"%.60s\") are not allowed", name));
}

lmn_status xml_parse(const char *path, const char *text, size_t size, struct arena *arena,
                     struct xml_budget *budget, struct xml_node **root, struct error *err)
{
    lmn_status status = LMN_OK;
    struct parser p = {.path = path, .arena = arena, .budget = budget, .err = err};
    if (size > budget->size)
        return fail_at(err, (struct place){path, 0, 0}, "more than %d MiB of XML",
                       XML_MAX_SIZE >> 20);
    budget->size -= size;
    p.expat = XML_ParserCreate(NULL);
    if (!p.expat) return fail_memory(err, path);
    XML_SetUserData(p.expat, &p);
    XML_SetElementHandler(p.expat, on_start, on_end);
    XML_SetCharacterDataHandler(p.expat, on_text);
    /* A fixed salt: the order of nothing we read depends on expat's hash tables. */
    XML_SetHashSalt(p.expat, 0x4C4D4Eu);
    XML_SetEntityDeclHandler(p.expat, on_entity);
    if (XML_Parse(p.expat, text, (int)size, XML_TRUE) == XML_STATUS_ERROR) {
        status = p.status != LMN_OK
                     ? p.status
                     : fail_at(err, here(&p), "%s", XML_ErrorString(XML_GetErrorCode(p.expat)));
        goto done;
    }
    *root = p.root;
done:
    XML_ParserFree(p.expat);
    return status;
}

const char *xml_attribute(const struct xml_node *node, const char *name)
{
    for (uint32_t i = 0; i < node->n_attributes; i++) {
        if (strcmp(node->attributes[i].name, name) == 0) return node->attributes[i].value;
    }
    return NULL;
}
