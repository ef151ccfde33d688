/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

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

/* ---- Values ------------------------------------------------------------------------------- */

/* The attribute's text; an empty one when it is missing. */
static const char *value_of(const struct xml_node *node)
{
    const char *value = xml_attribute(node, "value");
    return value ? value : "";
}

lmn_status read_numbers(struct reader *r, const struct xml_node *node, const char *attribute,
                        double *out, uint32_t max, uint32_t *n)
{
    static const char separators[] = " \t\r\n,";
    const char *text = xml_attribute(node, attribute);
    *n = 0;
    if (!text) text = "";
    for (text += strspn(text, separators); *text; text += strspn(text, separators)) {
        size_t length = strcspn(text, separators);
        char token[64];
        if (*n == max)
            return fail_node(r, node, "<%s> %s: more than %u numbers", node->name, attribute, max);
        if (length < sizeof token) {
            memcpy(token, text, length);
            token[length] = '\0';
        }
        if (length >= sizeof token || !str_to_double(token, &out[*n]) || fabs(out[*n]) > 3.4e38)
            return fail_node(r, node, "<%s> %s: \"%.*s\" is not a number", node->name, attribute,
                             length < 40 ? (int)length : 40, text);
        text += length;
        (*n)++;
    }
    if (*n == 0) return fail_node(r, node, "<%s> %s: a number is missing", node->name, attribute);
    return LMN_OK;
}

static lmn_status read_number(struct reader *r, const struct xml_node *node, const char *attribute,
                              double *out)
{
    uint32_t n;
    return read_numbers(r, node, attribute, out, 1, &n);
}

/* x, y and z from attributes of that name (absent: *out as it was), or from `value`, where one
 * number stands for all three when `is_splat`. */
static lmn_status read_xyz(struct reader *r, const struct xml_node *node, bool is_splat,
                           struct vec3 *out)
{
    lmn_status status = LMN_OK;
    double v[3] = {out->x, out->y, out->z};
    uint32_t n;
    if (xml_attribute(node, "value")) {
        TRY(read_numbers(r, node, "value", v, 3, &n));
        if (n == 1 && is_splat) v[1] = v[2] = v[0];
        if (n == 2 || (n == 1 && !is_splat))
            return fail_node(r, node, "<%s> needs three numbers", node->name);
    } else {
        static const char *const axes[] = {"x", "y", "z"};
        for (int i = 0; i < 3; i++) {
            if (xml_attribute(node, axes[i])) TRY(read_number(r, node, axes[i], &v[i]));
        }
    }
    *out = vec3((float)v[0], (float)v[1], (float)v[2]);
done:
    return status;
}

static int hex_digit(char c)
{
    const char *digits = "0123456789abcdef", *at = strchr(digits, c | 0x20);
    return c && at ? (int)(at - digits) : -1;
}

/* "#rrggbb": each byte / 255, taken as linear, as Mitsuba's <rgb> had it. */
static bool read_hex(const char *text, struct vec3 *out)
{
    float c[3];
    if (strlen(text) != 7) return false;
    for (int i = 0; i < 3; i++) {
        int hi = hex_digit(text[1 + 2 * i]), lo = hex_digit(text[2 + 2 * i]);
        if (hi < 0 || lo < 0) return false;
        c[i] = (float)(16 * hi + lo) / 255.0f;
    }
    *out = vec3(c[0], c[1], c[2]);
    return true;
}

lmn_status read_colour(struct reader *r, const struct xml_node *node, struct vec3 *out,
                       bool is_light)
{
    lmn_status status = LMN_OK;
    const char *text = value_of(node);
    double v[3];
    uint32_t n;
    if (node->element == EL_SPECTRUM) {
        if (xml_attribute(node, "filename") || strchr(text, ':'))
            return fail_node(r, node,
                             "<spectrum name=\"%s\">: spectra by wavelength are not supported; "
                             "use <rgb>",
                             xml_attribute(node, "name"));
        TRY(read_numbers(r, node, "value", v, 3, &n));
        if (n != 1)
            return fail_node(r, node, "<spectrum> takes one number; use <rgb> for a colour");
        /* Light of equal energy at all wavelengths is not white in sRGB, whose white is D65. */
        *out = is_light ? vec3_scale(vec3(1.2047939f, 0.9482910f, 0.9089161f), (float)v[0])
                        : vec3_splat((float)v[0]);
        return LMN_OK;
    }
    text += strspn(text, " \t\r\n");
    if (text[0] == '#') {
        if (!read_hex(text, out))
            return fail_node(r, node, "<%s>: \"%.40s\" is not a colour like #ff8000", node->name,
                             text);
        return LMN_OK;
    }
    TRY(read_numbers(r, node, "value", v, 3, &n));
    if (n == 2) return fail_node(r, node, "<%s> takes one or three numbers", node->name);
    if (n == 1) v[1] = v[2] = v[0];
    *out = vec3((float)v[0], (float)v[1], (float)v[2]);
done:
    return status;
}

/* ---- Transforms --------------------------------------------------------------------------- */

static lmn_status read_matrix(struct reader *r, const struct xml_node *node, struct transform *out)
{
    lmn_status status = LMN_OK;
    double v[16], m[16] = {0};
    uint32_t n;
    TRY(read_numbers(r, node, "value", v, 16, &n));
    if (n != 16 && n != 9) return fail_node(r, node, "<matrix> needs 16 or 9 numbers, not %u", n);
    uint32_t side = n == 16 ? 4 : 3;
    for (uint32_t i = 0; i < side; i++) {
        for (uint32_t j = 0; j < side; j++) m[4 * i + j] = v[side * i + j];
    }
    if (n == 9) m[15] = 1.0;
    if (fabs(m[12]) > 1e-5 || fabs(m[13]) > 1e-5 || fabs(m[14]) > 1e-5 || fabs(m[15] - 1.0) > 1e-5)
        return fail_node(r, node, "<matrix>: the last row must be 0 0 0 1");
    if (!transform_from_matrix(m, out)) return fail_node(r, node, "<matrix> is singular");
done:
    return status;
}

static lmn_status read_triple(struct reader *r, const struct xml_node *node, const char *attribute,
                              struct vec3 *out)
{
    double v[3];
    uint32_t n;
    lmn_status status = read_numbers(r, node, attribute, v, 3, &n);
    if (status != LMN_OK) return status;
    if (n != 3) return fail_node(r, node, "<%s> %s needs three numbers", node->name, attribute);
    *out = vec3((float)v[0], (float)v[1], (float)v[2]);
    return LMN_OK;
}

static lmn_status read_look_at(struct reader *r, const struct xml_node *node, struct transform *out)
{
    lmn_status status = LMN_OK;
    struct vec3 origin, target, up = vec3(0, 0, 0);
    TRY(read_triple(r, node, "origin", &origin));
    TRY(read_triple(r, node, "target", &target));
    if (xml_attribute(node, "up")) TRY(read_triple(r, node, "up", &up));
    struct vec3 d = vec3_sub(target, origin);
    if (!(vec3_length(d) > 0.0f))
        return fail_node(r, node, "<lookat>: origin and target are equal");
    if (vec3_is_zero(up)) up = frame_from_normal(vec3_normalize(d)).s;
    if (!(vec3_length(vec3_cross(vec3_normalize(up), vec3_normalize(d))) > 1e-6f))
        return fail_node(r, node, "<lookat>: up is parallel to the view direction");
    *out = transform_look_at(origin, target, up);
done:
    return status;
}

static lmn_status read_step(struct reader *r, const struct xml_node *node, struct transform *out)
{
    lmn_status status = LMN_OK;
    struct vec3 v = vec3(0, 0, 0);
    double angle;
    switch (node->element) {
    case EL_TRANSLATE:
        TRY(read_xyz(r, node, false, &v));
        *out = transform_translate(v);
        break;
    case EL_SCALE:
        v = vec3(1, 1, 1);
        TRY(read_xyz(r, node, true, &v));
        if (v.x == 0.0f || v.y == 0.0f || v.z == 0.0f)
            return fail_node(r, node, "<scale> by zero has no inverse");
        *out = transform_scale(v);
        break;
    case EL_ROTATE:
        TRY(read_xyz(r, node, false, &v));
        TRY(read_number(r, node, "angle", &angle));
        if (!(vec3_length(v) > 0.0f)) return fail_node(r, node, "<rotate> needs an axis");
        *out = transform_rotate(v, (float)angle);
        break;
    case EL_LOOKAT:
        TRY(read_look_at(r, node, out));
        break;
    case EL_MATRIX:
        TRY(read_matrix(r, node, out));
        break;
    default:
        return fail_node(r, node, "<%s> cannot be part of a <transform>", node->name);
    }
done:
    return status;
}

lmn_status read_transform(struct reader *r, struct xml_node *node, struct transform *out)
{
    lmn_status status = LMN_OK;
    *out = transform_identity();
    for (struct xml_node *c = node->first_child; c; c = c->next) {
        struct transform step;
        TRY(read_step(r, c, &step));
        *out = transform_mul(&step, out);
    }
    for (int i = 0; i < 12; i++) {
        if (!isfinite(out->m[i / 4][i % 4]) || !isfinite(out->inv[i / 4][i % 4]))
            return fail_node(r, node, "<transform> is singular or overflows");
    }
done:
    return status;
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
    const char *text = value_of(c);
    if (strcmp(text, "true") == 0) {
        *out = true;
    } else if (strcmp(text, "false") == 0) {
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
    *out = value_of(c);
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

lmn_status props_colour(struct props *p, const char *name, struct vec3 *out)
{
    double number;
    lmn_status status;
    struct xml_node *c = take(p, name);
    if (!c) return LMN_OK;
    if (c->element == EL_RGB || c->element == EL_SPECTRUM) return read_colour(p->r, c, out, false);
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
    switch (c->element) {
    case EL_FLOAT:
    case EL_INTEGER:
        TRY(read_number(r, c, "value", &number));
        TRY(builder_add_constant(r->b, c->place, vec3_splat((float)number), out, r->err));
        break;
    case EL_RGB:
    case EL_SPECTRUM:
        TRY(read_colour(r, c, &value, is_light));
        TRY(builder_add_constant(r->b, c->place, value, out, r->err));
        break;
    case EL_TEXTURE:
    case EL_REF:
        TRY(resolve(r, c, &target));
        if (target->element != EL_TEXTURE) return fail_type(p, c, "a texture or a colour");
        TRY(load_object(r, target));
        *out = target->index;
        break;
    default:
        return fail_type(p, c, "a number, a colour or a texture");
    }
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

static lmn_status fail_leftover(struct props *p, struct xml_node *c, const char *name)
{
    struct reader *r = p->r;
    const char *object = element_name(p->node->element);
    char what[256];
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
    const char *closest = str_closest(name, p->asked, p->n_asked);
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
