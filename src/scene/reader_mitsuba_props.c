/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "scene/reader_mitsuba_private.h"

/* ---- Messages ----------------------------------------------------------------------------- */

lmn_status fail_node(struct reader *r, const struct xml_node *node, const char *format, ...)
{
    char text[768];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return fail_at(r->err, node->place, "%s", text);
}

lmn_status fail_unknown(struct reader *r, const struct xml_node *node, const char *what,
                        const char *name, const char *const *candidates, size_t n)
{
    const char *closest = str_closest(name, candidates, n);
    if (closest) return fail_node(r, node, "%s \"%s\"; did you mean \"%s\"?", what, name, closest);
    return fail_node(r, node, "%s \"%s\"", what, name);
}

lmn_status fail_unsupported(struct reader *r, const struct xml_node *node)
{
    return fail_node(r, node, "<%s type=\"%.60s\"> is not supported yet", node->name,
                     xml_attribute(node, "type"));
}

/* ---- Properties --------------------------------------------------------------------------- */

struct props props_of(struct reader *r, struct xml_node *node)
{
    const char *type = xml_attribute(node, "type");
    return (struct props){.r = r, .node = node, .type = type ? type : ""};
}

static void ask(struct props *p, const char *name)
{
    for (uint32_t i = 0; i < p->n_asked; i++) {
        if (strcmp(p->asked[i], name) == 0) return;
    }
    if (p->n_asked < MAX_ASKED) p->asked[p->n_asked++] = name;
}

/* The first child of that name, marked; NULL when absent. */
static struct xml_node *take(struct props *p, const char *name)
{
    ask(p, name);
    for (struct xml_node *c = p->node->first_child; c; c = c->next) {
        const char *its = xml_attribute(c, "name");
        if (!its || strcmp(its, name) != 0) continue;
        c->is_used = true;
        return c;
    }
    return NULL;
}

struct xml_node *props_child(struct props *p, const char *name)
{
    return take(p, name);
}

static lmn_status fail_type(struct props *p, const struct xml_node *c, const char *wanted)
{
    return fail_node(p->r, c, "<%s name=\"%s\">: expected %s", c->name, xml_attribute(c, "name"),
                     wanted);
}

bool props_has(struct props *p, const char *name)
{
    ask(p, name);
    for (struct xml_node *c = p->node->first_child; c; c = c->next) {
        const char *its = xml_attribute(c, "name");
        if (its && strcmp(its, name) == 0) return true;
    }
    return false;
}

bool props_is_string(struct props *p, const char *name)
{
    for (struct xml_node *c = p->node->first_child; c; c = c->next) {
        const char *its = xml_attribute(c, "name");
        if (its && strcmp(its, name) == 0) return c->element == EL_STRING;
    }
    return false;
}

lmn_status props_float(struct props *p, const char *name, float *out)
{
    double v;
    struct xml_node *c = take(p, name);
    if (!c) return LMN_OK;
    if (c->element != EL_FLOAT && c->element != EL_INTEGER) return fail_type(p, c, "a <float>");
    lmn_status status = read_number(p->r, c, "value", &v);
    if (status == LMN_OK) *out = (float)v;
    return status;
}

lmn_status props_positive(struct props *p, const char *name, float *out)
{
    lmn_status status = props_float(p, name, out);
    if (status != LMN_OK || *out > 0.0f) return status;
    return fail_node(p->r, take(p, name), "\"%s\" must be above 0", name);
}

lmn_status props_integer(struct props *p, const char *name, int32_t min, int32_t max, int32_t *out)
{
    double v;
    struct xml_node *c = take(p, name);
    if (!c) return LMN_OK;
    if (c->element != EL_FLOAT && c->element != EL_INTEGER) return fail_type(p, c, "an <integer>");
    lmn_status status = read_number(p->r, c, "value", &v);
    if (status != LMN_OK) return status;
    if (v != floor(v)) return fail_node(p->r, c, "\"%s\" must be a whole number", name);
    if (v < min || v > max)
        return fail_node(p->r, c, "\"%s\" must be from %d to %d", name, min, max);
    *out = (int32_t)v;
    return LMN_OK;
}

lmn_status props_boolean(struct props *p, const char *name, bool *out)
{
    struct xml_node *c = take(p, name);
    if (!c) return LMN_OK;
    if (c->element != EL_BOOLEAN) return fail_type(p, c, "a <boolean>");
    const char *text = read_value(c);
    if (strcasecmp(text, "true") == 0) {
        *out = true;
    } else if (strcasecmp(text, "false") == 0) {
        *out = false;
    } else {
        return fail_node(p->r, c, "\"%s\" must be true or false, not \"%.40s\"", name, text);
    }
    return LMN_OK;
}

lmn_status props_string(struct props *p, const char *name, const char **out)
{
    struct xml_node *c = take(p, name);
    if (!c) return LMN_OK;
    if (c->element != EL_STRING) return fail_type(p, c, "a <string>");
    *out = read_value(c);
    return LMN_OK;
}

lmn_status props_choice(struct props *p, const char *name, const char *const *words, size_t n,
                        uint32_t *out)
{
    const char *text = NULL;
    lmn_status status = props_string(p, name, &text);
    if (status != LMN_OK || !text) return status;
    for (size_t i = 0; i < n; i++) {
        if (strcmp(text, words[i]) == 0) {
            *out = (uint32_t)i;
            return LMN_OK;
        }
    }
    char what[96];
    snprintf(what, sizeof what, "unknown %.60s", name);
    return fail_unknown(p->r, take(p, name), what, text, words, n);
}

lmn_status props_point(struct props *p, const char *name, struct vec3 *out)
{
    struct xml_node *c = take(p, name);
    if (!c) return LMN_OK;
    if (c->element != EL_POINT && c->element != EL_VECTOR) return fail_type(p, c, "a <point>");
    *out = vec3(0, 0, 0);
    return read_xyz(p->r, c, false, out);
}

lmn_status props_transform(struct props *p, const char *name, struct transform *out)
{
    struct xml_node *c = take(p, name);
    if (!c) return LMN_OK;
    if (c->element != EL_TRANSFORM) return fail_type(p, c, "a <transform>");
    return read_transform(p->r, c, out);
}

static bool is_colour(const struct xml_node *c)
{
    return c->element >= EL_RGB && c->element <= EL_BLACKBODY;
}

lmn_status props_colour(struct props *p, const char *name, struct vec3 *out)
{
    double number;
    lmn_status status;
    struct xml_node *c = take(p, name);
    if (!c) return LMN_OK;
    if (is_colour(c)) return read_colour(p->r, c, out, false);
    if (c->element != EL_FLOAT && c->element != EL_INTEGER) return fail_type(p, c, "a colour");
    status = read_number(p->r, c, "value", &number);
    if (status == LMN_OK) *out = vec3_splat((float)number);
    return status;
}

/* Value of a child that stands for a texture: written directly, nested, or by reference. */
static lmn_status read_texture(struct props *p, struct xml_node *c, bool is_light, uint32_t *out)
{
    lmn_status status = LMN_OK;
    struct reader *r = p->r;
    struct xml_node *target;
    struct vec3 value;
    double number;
    if (c->element == EL_TEXTURE || c->element == EL_REF) {
        TRY(resolve(r, c, &target));
        if (target->element != EL_TEXTURE) return fail_type(p, c, "a texture or a colour");
        TRY(load_object(r, target));
        *out = target->index;
        if (is_light && r->b->textures[*out].texture.kind == TEXTURE_MESH_ATTRIBUTE)
            return fail_node(r, c, "light from a mesh attribute is not supported");
        return LMN_OK;
    }
    if (c->element == EL_FLOAT || c->element == EL_INTEGER) {
        TRY(read_number(r, c, "value", &number));
        value = vec3_splat((float)number);
    } else if (is_colour(c)) {
        TRY(read_colour(r, c, &value, is_light));
    } else {
        return fail_type(p, c, "a number, a colour or a texture");
    }
    if (value.x < 0.0f || value.y < 0.0f || value.z < 0.0f)
        return fail_node(r, c, "\"%s\" must not be negative", xml_attribute(c, "name"));
    TRY(builder_add_constant(r->b, c->place, value, out, r->err));
done:
    return status;
}

lmn_status props_texture(struct props *p, const char *name, const struct vec3 *fallback,
                         uint32_t *out)
{
    struct xml_node *c = take(p, name);
    if (c) return read_texture(p, c, false, out);
    *out = SCENE_NONE;
    if (!fallback) return LMN_OK;
    return builder_add_constant(p->r->b, p->node->place, *fallback, out, p->r->err);
}

lmn_status props_radiance(struct props *p, const char *name, uint32_t *out)
{
    struct xml_node *c = take(p, name);
    if (c) return read_texture(p, c, true, out);
    return builder_add_constant(p->r->b, p->node->place, vec3_splat(1.0f), out, p->r->err);
}

lmn_status props_object(struct props *p, enum element element, struct xml_node **out)
{
    lmn_status status = LMN_OK;
    *out = NULL;
    for (struct xml_node *c = p->node->first_child; c; c = c->next) {
        struct xml_node *target;
        if (c->is_used || (c->element != element && c->element != EL_REF)) continue;
        TRY(resolve(p->r, c, &target));
        if (target->element != element) continue;
        c->is_used = true;
        *out = target;
        break;
    }
done:
    return status;
}

void props_ignore(struct props *p, const char *name)
{
    struct xml_node *c = take(p, name);
    if (c) note_ignored(p->r, c, name);
}

void props_ignore_rest(struct props *p)
{
    for (struct xml_node *c = p->node->first_child; c; c = c->next) {
        const char *name = xml_attribute(c, "name");
        if (c->is_used) continue;
        c->is_used = true;
        note_ignored(p->r, c, name ? name : c->name);
    }
}

/* ---- What is left ------------------------------------------------------------------------- */

static const char *const extra_names[] = {"num_parameters", "min_bounds", "range_bounds",
                                          "rotation_axis",  "min_angle",  "range_angle"};

static bool is_extra(const struct props *p, const struct xml_node *c, const char *name)
{
    for (size_t i = 0; i < sizeof extra_names / sizeof *extra_names; i++) {
        if (strcmp(name, extra_names[i]) == 0) return true;
    }
    const char *id = xml_attribute(p->node, "id");
    return id && str_starts(id, "var_") && strcmp(name, "reflectance") == 0 &&
           (c->element == EL_REF || c->element == EL_TEXTURE || c->element == EL_RGB);
}

static lmn_status read_extra(struct props *p, struct xml_node *c, const char *name,
                             struct extra *out)
{
    lmn_status status = LMN_OK;
    *out = (struct extra){.place = c->place, .texture = SCENE_NONE};
    TRY(keep_string(p->r, name, &out->name));
    if (strcmp(name, "reflectance") == 0) {
        TRY(read_texture(p, c, false, &out->texture));
    } else if (xml_attribute(c, "value")) {
        TRY(read_numbers(p->r, c, "value", out->values, 4, &out->n_values));
    } else {
        struct vec3 v = vec3(0, 0, 0);
        TRY(read_xyz(p->r, c, false, &v));
        out->values[0] = (double)v.x;
        out->values[1] = (double)v.y;
        out->values[2] = (double)v.z;
        out->n_values = 3;
    }
done:
    return status;
}

/* What people call things elsewhere, and what Mitsuba calls them. */
static const char *const synonyms[][2] = {
    {"roughness", "alpha"},
    {"color", "reflectance"},
    {"albedo", "reflectance"},
    {"base_color", "reflectance"},
    {"diffuse", "reflectance"},
    {"ior", "int_ior"},
    {"eta", "int_ior"},
    {"emission", "radiance"},
    {"intensity", "radiance"},
    {"radiance", "intensity"},
    {"power", "intensity"},
    {"transform", "to_world"},
    {"toworld", "to_world"},
    {"file", "filename"},
    {"path", "filename"},
    {"samples", "sample_count"},
    {"spp", "sample_count"},
    {"bounces", "max_depth"},
    {"resx", "width"},
    {"resy", "height"},
    {"flip_uvs", "flip_tex_coords"},
};
enum { N_SYNONYMS = sizeof synonyms / sizeof *synonyms };

/* The known property that was meant, or NULL. */
static const char *meant_property(const struct props *p, const char *name)
{
    const char *closest = str_closest(name, p->asked, p->n_asked);
    for (size_t i = 0; i < N_SYNONYMS && !closest; i++) {
        if (!str_closest(name, &synonyms[i][0], 1)) continue;
        for (uint32_t k = 0; k < p->n_asked && !closest; k++) {
            if (strcmp(p->asked[k], synonyms[i][1]) == 0) closest = p->asked[k];
        }
    }
    return closest;
}

static lmn_status fail_leftover(struct props *p, struct xml_node *c, const char *name)
{
    struct reader *r = p->r;
    const char *object = element_name(p->node->element);
    char what[256];
    if (c->element >= EL_MEDIUM && c->element <= EL_VOLUME)
        return fail_node(r, c, "<%s> is not supported", c->name);
    if (!name) {
        const char *type = xml_attribute(c, "type");
        if (c->element == EL_REF)
            return fail_node(r, c, "<ref id=\"%s\"> has no place in <%s type=\"%s\">",
                             xml_attribute(c, "id"), object, p->type);
        return fail_node(r, c, "<%s type=\"%s\"> has no place in <%s type=\"%s\">", c->name,
                         type ? type : "", object, p->type);
    }
    for (uint32_t i = 0; i < p->n_asked; i++) {
        if (strcmp(p->asked[i], name) == 0)
            return fail_node(r, c, "<%s name=\"%s\">: given twice", c->name, name);
    }
    snprintf(what, sizeof what, "<%s name=\"%.80s\">: unknown property of <%s type=\"%.40s\">",
             c->name, name, object, p->type);
    const char *closest = meant_property(p, name);
    if (closest) return fail_node(r, c, "%s; did you mean \"%s\"?", what, closest);
    return fail_node(r, c, "%s", what);
}

lmn_status props_finish(struct props *p, struct builder_object *object)
{
    lmn_status status = LMN_OK;
    struct reader *r = p->r;
    const char *id = xml_attribute(p->node, "id");
    struct extra *extras = NULL;
    uint32_t n = 0, n_max = 0;
    *object = (struct builder_object){.place = p->node->place};
    if (id) TRY(keep_string(r, id, &object->id));
    for (struct xml_node *c = p->node->first_child; c; c = c->next) n_max += !c->is_used;
    if (n_max == 0) return LMN_OK;
    extras = arena_new(r->b->arena, n_max, sizeof *extras);
    if (!extras) return fail_memory(r->err, p->node->name);
    for (struct xml_node *c = p->node->first_child; c; c = c->next) {
        if (c->is_used) continue;
        const char *name = xml_attribute(c, "name");
        if (!name || !is_extra(p, c, name)) return fail_leftover(p, c, name);
        TRY(read_extra(p, c, name, &extras[n]));
        c->is_used = true;
        n++;
    }
    object->extras = extras;
    object->n_extras = n;
done:
    return status;
}
