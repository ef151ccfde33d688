/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "scene/ply_private.h"

/* Stanford PLY: what the header says of the records. */

lmn_status ply_fail(struct ply *p, const char *what)
{
    unsigned line = 1;
    const char *start = p->text;
    for (const char *c = p->text; c < p->at; c++) {
        if (*c != '\n') continue;
        line++;
        start = c + 1;
    }
    if (p->format == FORMAT_LITTLE || p->format == FORMAT_BIG)
        return fail(p->err, LMN_ERR_PARSE, "%s: byte %zu: %s", p->path, (size_t)(p->at - p->text),
                    what);
    return fail(p->err, LMN_ERR_PARSE, "%s:%u:%u: %s", p->path, line, (unsigned)(p->at - start) + 1,
                what);
}

static void skip_blanks(struct ply *p)
{
    while (*p->at == ' ' || *p->at == '\t' || *p->at == '\r') p->at++;
}

/* The next word of the line, "" at its end; words that are too long are cut. */
static void read_word(struct ply *p, char *word)
{
    size_t n = 0;
    skip_blanks(p);
    while (p->at < p->end && (unsigned char)*p->at > ' ') {
        if (n < MAX_WORD - 1) word[n++] = *p->at;
        p->at++;
    }
    word[n] = '\0';
}

static bool read_scalar_type(struct ply *p, enum scalar *out)
{
    static const char *const names[][2] = {
        {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
        {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    char word[MAX_WORD];
    read_word(p, word);
    for (int i = 0; i < N_SCALARS; i++) {
        if (strcmp(word, names[i][0]) != 0 && strcmp(word, names[i][1]) != 0) continue;
        *out = (enum scalar)i;
        return true;
    }
    return false;
}

static enum role find_role(const struct ply_element *e, const char *name, bool is_list)
{
    static const struct {
        const char *name;
        enum role role;
    } roles[] = {{"x", ROLE_X},         {"y", ROLE_Y},         {"z", ROLE_Z},
                 {"nx", ROLE_NX},       {"ny", ROLE_NY},       {"nz", ROLE_NZ},
                 {"u", ROLE_U},         {"v", ROLE_V},         {"s", ROLE_U},
                 {"t", ROLE_V},         {"texture_u", ROLE_U}, {"texture_v", ROLE_V},
                 {"texture_s", ROLE_U}, {"texture_t", ROLE_V}};
    if (e->is_face && is_list &&
        (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0))
        return ROLE_FACE;
    for (size_t i = 0; e->is_vertex && !is_list && i < sizeof roles / sizeof *roles; i++) {
        if (strcmp(name, roles[i].name) == 0) return roles[i].role;
    }
    return ROLE_NONE;
}

static lmn_status read_property(struct ply *p)
{
    char word[MAX_WORD];
    struct property property = {0};
    if (p->n_elements == 0) return ply_fail(p, "a property before any element");
    struct ply_element *e = &p->elements[p->n_elements - 1];
    if (e->n_properties == MAX_PROPERTIES) return ply_fail(p, "too many properties");
    const char *before = p->at;
    read_word(p, word);
    property.is_list = strcmp(word, "list") == 0;
    if (property.is_list) {
        if (!read_scalar_type(p, &property.count_type) || property.count_type >= F32)
            return ply_fail(p, "unknown type of a list's length");
    } else {
        p->at = before;
    }
    if (!read_scalar_type(p, &property.type)) return ply_fail(p, "unknown type of a property");
    read_word(p, word);
    memcpy(property.name, word, sizeof word);
    property.role = find_role(e, word, property.is_list);
    if (property.role == ROLE_FACE && property.type >= F32)
        return ply_fail(p, "vertex indices must be integers");
    e->properties[e->n_properties++] = property;
    return LMN_OK;
}

static lmn_status read_element(struct ply *p)
{
    char name[MAX_WORD], number[MAX_WORD];
    if (p->n_elements == MAX_ELEMENTS) return ply_fail(p, "too many elements");
    read_word(p, name);
    read_word(p, number);
    uint64_t count = 0;
    size_t n = strspn(number, "0123456789");
    if (n == 0 || n > 18 || number[n]) return ply_fail(p, "an element needs a count");
    for (size_t i = 0; i < n; i++) count = 10 * count + (uint64_t)(number[i] - '0');
    p->elements[p->n_elements++] = (struct ply_element){.is_vertex = strcmp(name, "vertex") == 0,
                                                        .is_face = strcmp(name, "face") == 0,
                                                        .count = count};
    return LMN_OK;
}

static lmn_status read_format(struct ply *p)
{
    char word[MAX_WORD];
    read_word(p, word);
    /* Set after the header: until then, errors are told by line. */
    if (strcmp(word, "ascii") == 0) {
        p->format = FORMAT_ASCII;
    } else if (strcmp(word, "binary_little_endian") == 0) {
        p->format = FORMAT_LITTLE;
    } else if (strcmp(word, "binary_big_endian") == 0) {
        p->format = FORMAT_BIG;
    } else {
        return ply_fail(p, "unknown format; known are ascii, binary_little_endian and "
                           "binary_big_endian");
    }
    return LMN_OK;
}

lmn_status ply_read_header(struct ply *p)
{
    lmn_status status = LMN_OK;
    char word[MAX_WORD];
    enum format format = FORMAT_NONE;
    for (uint32_t line = 0;; line++) {
        read_word(p, word);
        if (line == 0 && strcmp(word, "ply") != 0) return ply_fail(p, "not a PLY file");
        if (strcmp(word, "format") == 0) {
            TRY(read_format(p));
            format = p->format;
            p->format = FORMAT_NONE;
        } else if (strcmp(word, "element") == 0) {
            TRY(read_element(p));
        } else if (strcmp(word, "property") == 0) {
            TRY(read_property(p));
        } else if (line > 0 && strcmp(word, "end_header") != 0 && strcmp(word, "comment") != 0 &&
                   strcmp(word, "obj_info") != 0 && word[0]) {
            return ply_fail(p, "unknown line in the header");
        }
        const char *newline = memchr(p->at, '\n', (size_t)(p->end - p->at));
        if (!newline) return ply_fail(p, "the header does not end");
        p->at = newline + 1;
        if (strcmp(word, "end_header") == 0) break;
    }
    if (format == FORMAT_NONE) return ply_fail(p, "the header names no format");
    p->format = format;
done:
    return status;
}

/* ---- Attributes --------------------------------------------------------------------------- */

static struct property *find_property(struct ply_element *e, const char *name)
{
    for (uint32_t i = 0; i < e->n_properties; i++) {
        struct property *p = &e->properties[i];
        if (p->role == ROLE_NONE && !p->is_list && strcmp(p->name, name) == 0) return p;
    }
    return NULL;
}

/* n properties become one attribute. */
static void make_attribute(struct ply_element *e, const char *name, struct property *const *from,
                           uint32_t n)
{
    if (e->n_attributes == MAX_ATTRIBUTES) return;
    struct attribute *a = &e->attributes[e->n_attributes++];
    snprintf(a->name, sizeof a->name, "%s_%s", e->is_face ? "face" : "vertex", name);
    a->n_channels = n;
    a->slot = e->n_slots;
    for (uint32_t i = 0; i < n; i++) {
        from[i]->role = ROLE_ATTRIBUTE;
        from[i]->slot = e->n_slots++;
    }
}

/* As Mitsuba 3 names them: r, g, b (or red, green, blue) are "color", and neighbours a_0, a_1, a_2
 * or a_x, a_y, a_z are "a"; here with one channel or three. */
void ply_find_attributes(struct ply_element *e)
{
    static const char *const colours[2][3] = {{"r", "g", "b"}, {"red", "green", "blue"}};
    for (int i = 0; i < 2; i++) {
        struct property *rgb[3];
        int n = 0;
        while (n < 3 && (rgb[n] = find_property(e, colours[i][n]))) n++;
        if (n < 3) continue;
        make_attribute(e, "color", rgb, 3);
        break;
    }
    for (uint32_t i = 0; i < e->n_properties;) {
        const char *name = e->properties[i].name, *end = strrchr(name, '_');
        struct property *run[3];
        uint32_t n = 0;
        for (; end && i + n < e->n_properties; n++) {
            struct property *p = &e->properties[i + n];
            const char *its_end = strrchr(p->name, '_');
            if (p->role != ROLE_NONE || p->is_list || !its_end || its_end - p->name != end - name ||
                memcmp(p->name, name, (size_t)(end - name)) != 0)
                break;
            if (n < 3) run[n] = p;
        }
        if (n == 1 || n == 3) {
            char stem[MAX_WORD];
            snprintf(stem, sizeof stem, "%.*s", (int)(end - name), name);
            make_attribute(e, stem, run, n);
        }
        i += n > 0 ? n : 1;
    }
}
