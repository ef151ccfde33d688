/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/reader_mitsuba_private.h"

/* ---- Values ------------------------------------------------------------------------------- */

const char *read_value(const struct xml_node *node)
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

lmn_status read_number(struct reader *r, const struct xml_node *node, const char *attribute,
                       double *out)
{
    uint32_t n;
    return read_numbers(r, node, attribute, out, 1, &n);
}

lmn_status read_xyz(struct reader *r, const struct xml_node *node, bool is_splat, struct vec3 *out)
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
        /* Embree gives up on coordinates beyond this. */
        if (!(fabsf(out->m[i / 4][i % 4]) < 1e18f) || !isfinite(out->inv[i / 4][i % 4]))
            return fail_node(r, node, "<transform> is singular or overflows");
    }
done:
    return status;
}
