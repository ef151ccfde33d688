/* SPDX-License-Identifier: Apache-2.0 */
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/rng.h"
#include "scene/reader_mitsuba_private.h"

enum { MAX_INCLUDE_DEPTH = 16, MAX_INCLUDES = 4096, MAX_VALUE = 1 << 20, MAX_DEFINES = 4096 };

struct define {
    const char *name, *value;
    bool is_option; /* from -D */
    bool is_used;
};

static bool is_object(enum element e)
{
    return e >= EL_BSDF && e <= EL_VOLUME;
}

static bool is_directive(enum element e)
{
    return e >= EL_DEFAULT && e <= EL_PATH;
}

/* ---- Defines ------------------------------------------------------------------------------ */

static struct define *find_define(struct reader *r, const char *name, size_t length)
{
    for (size_t i = 0; i < r->n_defines; i++) {
        struct define *d = &r->defines[i];
        if (strlen(d->name) == length && memcmp(d->name, name, length) == 0) return d;
    }
    return NULL;
}

static lmn_status add_define(struct reader *r, const char *name, const char *value, bool is_option)
{
    void *block = r->defines;
    if (!mem_grow(&block, &r->cap_defines, r->n_defines + 1, sizeof *r->defines))
        return fail_memory(r->err, "defines");
    r->defines = block;
    r->defines[r->n_defines++] = (struct define){name, value, is_option, false};
    return LMN_OK;
}

static lmn_status add_option_defines(struct reader *r)
{
    lmn_status status = LMN_OK;
    for (uint32_t i = 0; r->options && i < r->options->n_defines; i++) {
        const char *text = r->options->defines[i], *equals = strchr(text, '=');
        if (!equals || equals == text)
            return fail(r->err, LMN_ERR_ARGUMENT, "define \"%s\": expected name=value", text);
        if (find_define(r, text, (size_t)(equals - text)))
            return fail(r->err, LMN_ERR_ARGUMENT, "define \"%s\": given twice", text);
        char *name = arena_strdup(&r->arena, text);
        if (!name) return fail_memory(r->err, "defines");
        name[equals - text] = '\0';
        TRY(add_define(r, name, name + (equals - text) + 1, true));
        builder_hash(r->b, text, strlen(text));
    }
done:
    return status;
}

static lmn_status check_option_defines(struct reader *r)
{
    lmn_status status = LMN_OK;
    const char **names = mem_new(r->n_defines, sizeof *names);
    size_t n = 0;
    if (!names) return fail_memory(r->err, "defines");
    for (size_t i = 0; i < r->n_defines; i++) {
        if (!r->defines[i].is_option) names[n++] = r->defines[i].name;
    }
    for (size_t i = 0; i < r->n_defines && status == LMN_OK; i++) {
        const struct define *d = &r->defines[i];
        if (!d->is_option || d->is_used) continue;
        const char *closest = str_closest(d->name, names, n);
        status = closest ? fail(r->err, LMN_ERR_ARGUMENT,
                                "%s: unknown define \"%s\"; did you mean \"%s\"?", r->b->path,
                                d->name, closest)
                         : fail(r->err, LMN_ERR_ARGUMENT,
                                "%s: unknown define \"%s\": the scene does not use it", r->b->path,
                                d->name);
    }
    mem_free(names);
    return status;
}

static lmn_status fail_undefined(struct reader *r, const struct xml_node *node, const char *name)
{
    const char **names = mem_new(r->n_defines, sizeof *names);
    if (!names) return fail_memory(r->err, "defines");
    for (size_t i = 0; i < r->n_defines; i++) names[i] = r->defines[i].name;
    lmn_status status = fail_unknown(r, node, "undefined parameter", name, names, r->n_defines);
    mem_free(names);
    return status;
}

/* Replaces every $name in a value. */
static lmn_status substitute(struct reader *r, const struct xml_node *node, const char **value)
{
    lmn_status status = LMN_OK;
    struct str out = {0};
    const char *text = *value;
    if (!strchr(text, '$')) return LMN_OK;
    while (*text) {
        size_t plain = strcspn(text, "$");
        str_add_bytes(&out, text, plain);
        text += plain;
        if (!*text) break;
        size_t length = 0;
        while (isalnum((unsigned char)text[1 + length]) || text[1 + length] == '_') length++;
        struct define *d = length ? find_define(r, text + 1, length) : NULL;
        if (!d) {
            char name[64];
            snprintf(name, sizeof name, "%.*s", length < 60 ? (int)length : 60, text + 1);
            status = fail_undefined(r, node, name);
            goto done;
        }
        d->is_used = true;
        str_add_bytes(&out, d->value, strlen(d->value));
        text += 1 + length;
        if (out.length > MAX_VALUE) {
            status = fail_node(r, node, "a value is longer than %d bytes after substitution",
                               MAX_VALUE);
            goto done;
        }
    }
    *value = out.failed || !out.text ? NULL : arena_strdup(&r->arena, out.text);
    if (!*value) status = fail_memory(r->err, "defines");
done:
    str_release(&out);
    return status;
}

/* ---- Ids ---------------------------------------------------------------------------------- */

static size_t id_slot(const struct reader *r, const char *id)
{
    size_t mask = r->cap_ids - 1;
    size_t i = (size_t)rng_mix(hash_bytes(HASH_START, id, strlen(id))) & mask;
    while (r->ids[i].id && strcmp(r->ids[i].id, id) != 0) i = (i + 1) & mask;
    return i;
}

struct xml_node *find_id(const struct reader *r, const char *id)
{
    return r->cap_ids ? r->ids[id_slot(r, id)].node : NULL;
}

static lmn_status add_id(struct reader *r, const struct xml_node *where, const char *id,
                         struct xml_node *node)
{
    if (2 * (r->n_ids + 1) > r->cap_ids) {
        size_t n = r->cap_ids;
        struct id_entry *old = r->ids, *fresh = mem_new(n ? 2 * n : 64, sizeof *fresh);
        if (!fresh) return fail_memory(r->err, "ids");
        r->ids = fresh;
        r->cap_ids = n ? 2 * n : 64;
        for (size_t i = 0; i < n; i++) {
            if (old[i].id) fresh[id_slot(r, old[i].id)] = old[i];
        }
        mem_free(old);
    }
    size_t slot = id_slot(r, id);
    if (r->ids[slot].id)
        return fail_node(r, where, "the id \"%.80s\" is taken: see %s:%u:%u", id,
                         r->ids[slot].node->place.file, r->ids[slot].node->place.line,
                         r->ids[slot].node->place.column);
    r->ids[slot] = (struct id_entry){id, node};
    r->n_ids++;
    return LMN_OK;
}

static lmn_status fail_no_id(struct reader *r, const struct xml_node *node, const char *id)
{
    const char **names = mem_new(r->n_ids, sizeof *names);
    size_t n = 0;
    if (!names) return fail_memory(r->err, "ids");
    for (size_t i = 0; i < r->cap_ids; i++) {
        if (r->ids[i].id) names[n++] = r->ids[i].id;
    }
    char what[64];
    snprintf(what, sizeof what, "<%s> to an unknown id", node->name);
    lmn_status status = fail_unknown(r, node, what, id, names, n);
    mem_free(names);
    return status;
}

lmn_status resolve(struct reader *r, struct xml_node *node, struct xml_node **out)
{
    *out = node;
    if (node->element != EL_REF) return LMN_OK;
    const char *id = xml_attribute(node, "id");
    *out = find_id(r, id);
    return *out ? LMN_OK : fail_no_id(r, node, id);
}

/* ---- Files -------------------------------------------------------------------------------- */

/* "dir/" of "dir/name", "" of "name". */
static size_t folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

static lmn_status try_file(struct reader *r, const char *folder, size_t length, const char *name,
                           const char **out)
{
    lmn_status status = LMN_OK;
    struct str path = {0};
    if (name[0] != '/') str_add_bytes(&path, folder, length);
    str_add_bytes(&path, name, strlen(name));
    *out = NULL;
    if (path.failed) {
        status = fail_memory(r->err, name);
    } else if (access(path.text, F_OK) == 0) {
        *out = arena_strdup(&r->arena, path.text);
        if (!*out) status = fail_memory(r->err, name);
    }
    str_release(&path);
    return status;
}

lmn_status find_file(struct reader *r, const struct xml_node *node, const char *name,
                     const char **out)
{
    lmn_status status = LMN_OK;
    const char *file = node->place.file;
    if (!*name) return fail_node(r, node, "the file name is empty");
    TRY(try_file(r, file, folder_length(file), name, out));
    if (!*out && strchr(name, '\\')) { /* written on Windows */
        char *copy = arena_strdup(&r->arena, name);
        if (!copy) return fail_memory(r->err, name);
        for (char *c = copy; *c; c++)
            if (*c == '\\') *c = '/';
        name = copy;
        TRY(try_file(r, file, folder_length(file), name, out));
    }
    for (size_t i = 0; i < r->n_folders && !*out; i++)
        TRY(try_file(r, r->folders[i], strlen(r->folders[i]), name, out));
    if (!*out) return fail_node(r, node, "no file \"%.200s\"", name);
done:
    return status;
}

static lmn_status add_folder(struct reader *r, const char *folder, size_t length)
{
    struct str path = {0};
    void *block = r->folders;
    bool ok = mem_grow(&block, &r->cap_folders, r->n_folders + 1, sizeof *r->folders);
    r->folders = block;
    str_add_bytes(&path, folder, length);
    if (length && folder[length - 1] != '/') str_add(&path, "/");
    char *copy = ok && !path.failed && path.text ? arena_strdup(&r->arena, path.text) : NULL;
    if (copy) r->folders[r->n_folders++] = copy;
    str_release(&path);
    return copy || (ok && !length) ? LMN_OK : fail_memory(r->err, "folders");
}

/* ---- Expansion: <default>, $name, <include>, <alias>, ids ---------------------------------- */

/* A file being read, up to the scene file. */
struct source {
    const struct source *parent;
    dev_t device;
    ino_t file; /* with the device: which file it is, whatever its name */
    uint32_t depth;
    bool is_legacy; /* version below 2 */
};

static lmn_status read_tree(struct reader *r, const char *path, const struct xml_node *from,
                            const struct source *parent, struct xml_node **out);

/* Names of 0.x (intIOR, toWorld) as newer files have them; they are taken wherever they occur. */
static lmn_status snake_case(struct reader *r, const char **name)
{
    const char *in = *name;
    size_t n = 0;
    while (in[n] && !isupper((unsigned char)in[n])) n++;
    if (!in[n]) return LMN_OK;
    char *out = arena_new(&r->arena, 2 * strlen(in) + 1, 1);
    if (!out) return fail_memory(r->err, "names");
    *name = out;
    for (size_t i = 0; in[i]; i++) {
        bool upper = isupper((unsigned char)in[i]) != 0;
        if (upper && i > 0 && islower((unsigned char)in[i - 1])) *out++ = '_';
        *out++ = (char)tolower((unsigned char)in[i]);
    }
    return LMN_OK;
}

/* What else 0.x called differently: plugin, its name, ours. */
static const char *const old_names[][3] = {
    {"diffuse", "diffuse_reflectance", "reflectance"},
    {"roughdiffuse", "diffuse_reflectance", "reflectance"},
};

static lmn_status expand_attributes(struct reader *r, struct xml_node *node,
                                    const struct xml_node *parent, const struct source *source)
{
    lmn_status status = LMN_OK;
    const char *type = source->is_legacy && parent ? xml_attribute(parent, "type") : NULL;
    node->is_legacy = source->is_legacy;
    for (uint32_t i = 0; i < node->n_attributes; i++) {
        struct xml_attribute *a = &node->attributes[i];
        TRY(substitute(r, node, &a->value));
        if (strcmp(a->name, "name") != 0 || node->element == EL_DEFAULT) continue;
        TRY(snake_case(r, &a->value));
        for (size_t k = 0; type && k < sizeof old_names / sizeof *old_names; k++) {
            const char *const *old = old_names[k];
            if (strcmp(type, old[0]) == 0 && strcmp(a->value, old[1]) == 0) a->value = old[2];
        }
    }
done:
    return status;
}

static lmn_status expand_directive(struct reader *r, struct xml_node *node,
                                   const struct source *source, struct xml_node **included)
{
    lmn_status status = LMN_OK;
    const char *a = NULL, *b = NULL, *path;
    static const char *const needs[][2] = {
        {"name", "value"}, {"filename", NULL}, {"id", "as"}, {"value", NULL}};
    const char *const *need = needs[node->element - EL_DEFAULT];
    if (!(a = xml_attribute(node, need[0])))
        return fail_node(r, node, "<%s> needs \"%s\"", node->name, need[0]);
    if (need[1] && !(b = xml_attribute(node, need[1])))
        return fail_node(r, node, "<%s> needs \"%s\"", node->name, need[1]);
    if (node->first_child)
        return fail_node(r, node->first_child, "<%s> cannot hold elements", node->name);

    switch (node->element) {
    case EL_DEFAULT: {
        struct define *d = find_define(r, a, strlen(a));
        if (d) {
            d->is_used = true;
            /* The name stays known for "did you mean", also when -D gave the value. */
        } else if (r->n_defines >= MAX_DEFINES) { /* they are searched one by one */
            return fail_node(r, node, "more than %d defaults", MAX_DEFINES);
        } else {
            TRY(add_define(r, a, b, false));
        }
        break;
    }
    case EL_INCLUDE:
        TRY(find_file(r, node, a, &path));
        TRY(read_tree(r, path, node, source, included));
        break;
    case EL_ALIAS: {
        struct xml_node *target = find_id(r, a);
        if (!target) return fail_no_id(r, node, a);
        TRY(add_id(r, node, b, target));
        break;
    }
    default: { /* EL_PATH: relative to the file that says it */
        size_t n = a[0] == '/' ? 0 : folder_length(node->place.file);
        struct str folder = {0};
        str_add_bytes(&folder, node->place.file, n);
        str_add_bytes(&folder, a, strlen(a));
        status = folder.failed ? fail_memory(r->err, "folders")
                               : add_folder(r, folder.text, folder.length);
        str_release(&folder);
    }
    }
done:
    return status;
}

/* Checks a node and all below it, in document order. Directives are taken out of the tree and
 * included files put in. */
static lmn_status expand(struct reader *r, struct xml_node *node, const struct xml_node *parent,
                         const struct source *source)
{
    lmn_status status = LMN_OK;
    TRY(check_element(r, node));
    TRY(expand_attributes(r, node, parent, source));
    const char *id = xml_attribute(node, "id");
    if (id && (is_object(node->element))) TRY(add_id(r, node, id, node));
    if (node->element >= EL_FLOAT && node->element <= EL_REF && node->element != EL_TRANSFORM &&
        node->first_child)
        return fail_node(r, node->first_child, "<%s> cannot hold elements", node->name);

    for (struct xml_node **link = &node->first_child; *link;) {
        struct xml_node *c = *link, *included = NULL;
        TRY(check_element(r, c));
        if (c->element == EL_IGNORED) {
            note_ignored(r, c, c->name);
            *link = c->next;
        } else if (!is_directive(c->element)) {
            TRY(expand(r, c, node, source));
            link = &c->next;
        } else {
            TRY(expand_attributes(r, c, node, source));
            TRY(expand_directive(r, c, source, &included));
            *link = c->next;
            if (!included) continue;
            /* The children of an included <scene>; any other root as it is. */
            struct xml_node *first = included->element == EL_SCENE ? included->first_child
                                                                   : included;
            if (!first) continue;
            struct xml_node *last = first;
            while (last->next) last = last->next;
            last->next = c->next;
            *link = first;
            link = &last->next;
        }
    }
done:
    return status;
}

static lmn_status read_version(struct reader *r, const struct xml_node *root, struct source *source)
{
    unsigned major, minor, patch;
    const char *version = xml_attribute(root, "version");
    if (!version) return fail_node(r, root, "<%s> needs a version, as in \"3.0.0\"", root->name);
    if (sscanf(version, "%3u.%5u.%5u", &major, &minor, &patch) < 2)
        return fail_node(r, root, "version \"%.40s\" is not like \"3.0.0\"", version);
    if (major > 3) return fail_node(r, root, "version %u is not known; 3 is the newest", major);
    source->is_legacy = major < 2;
    return LMN_OK;
}

/* Reads a file and everything it includes. `from`: the <include>, or NULL for the scene file. */
static lmn_status read_tree(struct reader *r, const char *path, const struct xml_node *from,
                            const struct source *parent, struct xml_node **out)
{
    lmn_status status = LMN_OK;
    struct source source = {.parent = parent, .depth = parent ? parent->depth + 1 : 0};
    const char *kept;
    struct stat st;
    char *text = NULL;
    size_t size = 0;
    struct xml_node *root = NULL;

    if (stat(path, &st) == 0) {
        source.device = st.st_dev;
        source.file = st.st_ino;
    }
    for (const struct source *s = parent; s; s = s->parent) {
        if (s->device == source.device && s->file == source.file) {
            status = fail_node(r, from, "\"%.200s\" includes itself", path);
            goto done;
        }
    }
    if (source.depth > MAX_INCLUDE_DEPTH) {
        status = fail_node(r, from, "includes are nested deeper than %d", MAX_INCLUDE_DEPTH);
        goto done;
    }
    if (++r->n_includes > MAX_INCLUDES) {
        status = fail_node(r, from, "more than %d includes", MAX_INCLUDES);
        goto done;
    }
    TRY(file_read(path, XML_MAX_SIZE, &text, &size, r->err));
    TRY(keep_string(r, path, &kept));
    builder_hash(r->b, text, size);
    TRY(xml_parse(kept, text, size, &r->arena, &r->budget, &root, r->err));
    TRY(check_element(r, root));
    if (root->element == EL_SCENE) {
        TRY(read_version(r, root, &source));
    } else if (!parent) {
        status = fail_node(r, root, "the root element must be <scene>, not <%.40s>", root->name);
        goto done;
    } else {
        source.is_legacy = parent->is_legacy;
    }
    TRY(expand(r, root, NULL, &source));
    *out = root;
done:
    mem_free(text);
    return status;
}

lmn_status read_document(struct reader *r, struct xml_node **root)
{
    lmn_status status = LMN_OK;
    TRY(add_option_defines(r));
    TRY(add_folder(r, r->b->path, folder_length(r->b->path)));
    TRY(read_tree(r, r->b->path, NULL, NULL, root));
    TRY(check_option_defines(r));
done:
    return status;
}
