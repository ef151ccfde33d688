/* SPDX-License-Identifier: Apache-2.0 */
#include "train/meaning.h"

#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MAX_GRIDS = 64, MAX_FEATURES = 1024, MAX_VARIABLES = 65536 };

static const struct {
    const char *list, *word;
    uint32_t most;
} kinds[] = {[MEANING_GRID] = {"grids", "grid of", MAX_GRIDS},
             [MEANING_FEATURES] = {"features", "features of", MAX_FEATURES},
             [MEANING_VARIABLE] = {"variables", "variable", MAX_VARIABLES},
             [MEANING_LIGHT] = {"lights", "light of", FIELD_MAX_LIGHTS}};

void meaning_add(struct meaning *m, enum meaning_kind kind, uint32_t n, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    const int length = vsnprintf(NULL, 0, format, args);
    va_end(args);
    void *parts = m->parts;
    char *name = length < 0 ? NULL : arena_new(&m->arena, (size_t)length + 1, 1);
    if (name && mem_grow(&parts, &m->capacity, m->n_parts + 1, sizeof *m->parts)) {
        vsnprintf(name, (size_t)length + 1, format, again);
        m->parts = parts;
        m->parts[m->n_parts++] = (struct meaning_part){kind, name, n};
    } else {
        m->failed = true;
    }
    va_end(again);
}

void meaning_release(struct meaning *m)
{
    arena_release(&m->arena);
    mem_free(m->parts);
    *m = (struct meaning){0};
}

void meaning_tell(const struct meaning_part *part, struct str *to)
{
    str_add(to, "%s %.80s", kinds[part->kind].word, part->name);
}

static uint32_t count(const struct meaning *m, enum meaning_kind kind)
{
    uint32_t n = 0;
    for (size_t i = 0; i < m->n_parts; i++)
        if (m->parts[i].kind == kind) n += kind == MEANING_FEATURES ? m->parts[i].n : 1;
    return n;
}

/* Positions are told apart by a thousandth of the box. */
static bool is_same_box(const struct meaning *a, const struct meaning *b)
{
    const float most = 1e-3f * vec3_length(vec3_sub(a->box_max, a->box_min));
    return vec3_length(vec3_sub(a->box_min, b->box_min)) <= most &&
           vec3_length(vec3_sub(a->box_max, b->box_max)) <= most;
}

const struct meaning_part *meaning_find(const struct meaning *m, const struct meaning *other,
                                        const struct meaning_part *part)
{
    for (size_t i = 0; i < m->n_parts; i++) {
        const struct meaning_part *p = &m->parts[i];
        const bool is_scene = i == 0, other_is_scene = part == &other->parts[0];
        const bool is_only = p->kind == MEANING_LIGHT && count(m, MEANING_LIGHT) == 1 &&
                             count(other, MEANING_LIGHT) == 1;
        if (p->kind != part->kind || p->n != part->n || is_scene != other_is_scene ||
            (strcmp(p->name, part->name) != 0 && !is_only))
            continue;
        return !is_scene || is_same_box(m, other) ? p : NULL;
    }
    return NULL;
}

struct field_config meaning_field(const struct meaning *m)
{
    return (struct field_config){.n_grids = count(m, MEANING_GRID),
                                 .n_features = count(m, MEANING_FEATURES),
                                 .n_variables = count(m, MEANING_VARIABLE),
                                 .n_lights = count(m, MEANING_LIGHT)};
}

/* ---- In files ------------------------------------------------------------------------------- */

static void write_point(struct json *j, struct vec3 p)
{
    json_begin_array(j, NULL);
    json_put_float(j, NULL, p.x);
    json_put_float(j, NULL, p.y);
    json_put_float(j, NULL, p.z);
    json_end(j);
}

void meaning_write(const struct meaning *m, struct json *j)
{
    json_begin_object(j, NULL);
    for (enum meaning_kind kind = MEANING_GRID; kind <= MEANING_LIGHT; kind++) {
        json_begin_array(j, kinds[kind].list);
        for (size_t i = 0; i < m->n_parts; i++) {
            const struct meaning_part *p = &m->parts[i];
            if (p->kind != kind) continue;
            if (kind == MEANING_FEATURES) json_begin_array(j, NULL);
            json_put_string(j, NULL, p->name);
            if (kind == MEANING_FEATURES) json_put_integer(j, NULL, p->n);
            if (kind == MEANING_FEATURES) json_end(j);
        }
        json_end(j);
    }
    json_begin_array(j, "box");
    write_point(j, m->box_min);
    write_point(j, m->box_max);
    json_end(j);
    json_end(j);
}

static bool read_list(struct meaning *m, enum meaning_kind kind, const json_t *list)
{
    const json_t *item;
    size_t i;
    if (!json_is_array(list)) return false;
    uint64_t sum = 0;
    json_array_foreach(list, i, item)
    {
        const bool has_size = kind == MEANING_FEATURES;
        const char *name = json_string_value(has_size ? json_array_get(item, 0) : item);
        json_int_t n = kind == MEANING_GRID || kind == MEANING_LIGHT ? 3 : 1;
        if (has_size) n = json_integer_value(json_array_get(item, 1));
        if (!name || n < 1 || n > MAX_FEATURES) return false;
        sum += has_size ? (uint64_t)n : 1;
        if (sum > kinds[kind].most) return false;
        meaning_add(m, kind, (uint32_t)n, "%s", name);
    }
    return true;
}

static bool read_point(const json_t *list, struct vec3 *out)
{
    double x[3];
    for (size_t i = 0; i < 3; i++) {
        if (!json_is_number(json_array_get(list, i))) return false;
        x[i] = json_number_value(json_array_get(list, i));
        if (!(fabs(x[i]) < 1e30)) return false;
    }
    *out = vec3((float)x[0], (float)x[1], (float)x[2]);
    return true;
}

lmn_status meaning_read(struct meaning *m, const char *text, const char *where, struct error *err)
{
    lmn_status status = LMN_OK;
    json_t *object = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    const json_t *box = json_object_get(object, "box");
    *m = (struct meaning){0};
    for (enum meaning_kind kind = MEANING_GRID; kind <= MEANING_LIGHT; kind++)
        if ((!read_list(m, kind, json_object_get(object, kinds[kind].list)) ||
             (kind == MEANING_LIGHT && count(m, kind) == 0)) &&
            !m->failed) {
            status = fail(err, LMN_ERR_PARSE, "%s: \"network\" has no good list of %s", where,
                          kinds[kind].list);
            goto done;
        }
    if (m->failed)
        status = fail_memory(err, where);
    else if (!read_point(json_array_get(box, 0), &m->box_min) ||
             !read_point(json_array_get(box, 1), &m->box_max))
        status = fail(err, LMN_ERR_PARSE, "%s: \"network\" has no good box", where);
done:
    json_decref(object);
    if (status != LMN_OK) meaning_release(m);
    return status;
}
