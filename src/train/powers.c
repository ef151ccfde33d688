/* SPDX-License-Identifier: Apache-2.0 */
#include "train/powers.h"

#include <stddef.h>
#include <string.h>

#include "base/mem.h"
#include "scene/binding.h"

static struct vec3 radiance(const struct scene_state *state, uint32_t emitter)
{
    const struct emitter *e = &state->emitters[emitter];
    const struct vec3 one = {1, 1, 1}; /* an environment's picture does not change */
    return vec3_scale(e->radiance == SCENE_NONE ? one : state->textures[e->radiance].value,
                      e->scale);
}

/* ---- Which variables ------------------------------------------------------------------------- */

/* Does any material, or a light as its picture, use this texture? */
static bool is_shared(const struct scene *s, uint32_t texture)
{
    for (uint32_t i = 0; i < s->n_bsdfs; i++)
        for (int k = 0; k < BSDF_TEXTURES; k++)
            if (bsdf_texture(&s->defaults.bsdfs[i], k) == texture) return true;
    for (uint32_t i = 0; i < s->n_emitters; i++)
        if (s->defaults.emitters[i].picture == texture) return true;
    return false;
}

/* Does the binding write the power of this emitter? */
static bool is_power_of(const struct scene *s, const struct binding *b, uint32_t emitter)
{
    const struct emitter *e = &s->defaults.emitters[emitter];
    if (b->array == STATE_EMITTERS)
        return b->index == emitter && b->kind == BINDING_NUMBER &&
               b->offset == offsetof(struct emitter, scale);
    return b->array == STATE_TEXTURES && b->index == e->radiance &&
           (b->kind == BINDING_SPLAT || b->kind == BINDING_RGB) &&
           b->offset == offsetof(struct texture, value) && !is_shared(s, b->index);
}

static bool writes_power(const struct scene *s, const struct binding *b)
{
    for (uint32_t e = 0; e < s->n_emitters; e++)
        if (is_power_of(s, b, e)) return true;
    return false;
}

/* All that the variable drives is the power of lights, none of it darker while it rises. `at`: the
 * brighter end. */
static bool drives_powers_alone(const struct scene *s, uint32_t variable, float *at)
{
    bool rises = false, falls = false, is_used = false;
    for (uint32_t i = 0; i < s->n_bindings; i++) {
        const struct binding *b = &s->bindings[i];
        if (!binding_follows(b, variable)) continue;
        if (!writes_power(s, b)) return false;
        is_used = true;
        for (int k = 0; k < (b->kind == BINDING_RGB ? 3 : 1); k++) {
            const struct drive *d = &b->drive[k];
            if (d->variable != variable) continue;
            if (d->at_0 < 0.0f || d->at_1 < 0.0f) return false;
            rises |= d->at_1 > d->at_0;
            falls |= d->at_1 < d->at_0;
        }
    }
    *at = falls ? 0.0f : 1.0f;
    return is_used && !(rises && falls);
}

/* ---- Groups ---------------------------------------------------------------------------------- */

static bool is_equal(const struct drive *a, const struct drive *b)
{
    return a->variable == b->variable && a->at_0 * b->at_1 == a->at_1 * b->at_0;
}

/* Do both emitters follow the same variables in the same proportion? */
static bool is_alike(const struct scene *s, uint32_t a, uint32_t b)
{
    uint32_t n[2] = {0, 0};
    for (uint32_t i = 0; i < s->n_bindings; i++) {
        const struct binding *x = &s->bindings[i];
        bool has_twin = false;
        n[0] += is_power_of(s, x, a);
        n[1] += is_power_of(s, x, b);
        if (!is_power_of(s, x, a)) continue;
        for (uint32_t k = 0; k < s->n_bindings && !has_twin; k++) {
            const struct binding *y = &s->bindings[k];
            if (!is_power_of(s, y, b) || y->kind != x->kind) continue;
            has_twin = is_equal(&x->drive[0], &y->drive[0]) &&
                       (x->kind != BINDING_RGB || (is_equal(&x->drive[1], &y->drive[1]) &&
                                                   is_equal(&x->drive[2], &y->drive[2])));
        }
        if (!has_twin) return false;
    }
    return n[0] == n[1];
}

/* Is the emitter's power driven, and only by such variables? */
static bool is_driven(const struct scene *s, const bool *is_free, uint32_t emitter)
{
    bool any = false;
    for (uint32_t i = 0; i < s->n_bindings; i++) {
        const struct binding *b = &s->bindings[i];
        if (!is_power_of(s, b, emitter)) continue;
        for (uint32_t v = 0; v < s->n_variables; v++) {
            if (!binding_follows(b, v)) continue;
            if (!is_free[v]) return false;
            any = true;
        }
    }
    return any;
}

/* Group 0 is that of fixed powers, if there is such an emitter or no group at all. Lights that find
 * no room keep their variables in the space that is learnt. */
static void make_groups(struct powers *p, const struct scene *s, bool *is_free)
{
    bool has_fixed = s->n_emitters == 0;
    for (uint32_t e = 0; e < s->n_emitters; e++) has_fixed |= !is_driven(s, is_free, e);
    if (has_fixed) p->first[p->n++] = SCENE_NONE;
    for (uint32_t e = 0; e < s->n_emitters; e++) {
        if (!is_driven(s, is_free, e)) continue;
        uint32_t g = has_fixed;
        while (g < p->n && !is_alike(s, p->first[g], e)) g++;
        p->group_of[e] = g;
        if (g == p->n && g < FIELD_MAX_LIGHTS) p->first[p->n++] = e;
        if (g < p->n) continue;
        for (uint32_t v = 0; v < s->n_variables; v++)
            for (uint32_t i = 0; i < s->n_bindings; i++)
                if (is_power_of(s, &s->bindings[i], e) && binding_follows(&s->bindings[i], v))
                    is_free[v] = false;
    }
}

static lmn_status measure_reference(struct powers *p, const struct scene *s, struct error *err)
{
    struct scene_state state = {0};
    float *u = mem_new((size_t)s->n_variables + 1, sizeof *u);
    lmn_status status = LMN_OK;
    if (!u) {
        status = fail_memory(err, "groups of lights");
        goto done;
    }
    TRY(scene_state_init(s, &state, err));
    powers_set_reference(p, u);
    scene_apply(s, u, &state);
    for (uint32_t g = 0; g < p->n; g++) {
        if (p->first[g] == SCENE_NONE) continue;
        const struct vec3 r = radiance(&state, p->first[g]);
        p->reference[g][0] = r.x;
        p->reference[g][1] = r.y;
        p->reference[g][2] = r.z;
    }
done:
    scene_state_release(&state);
    mem_free(u);
    return status;
}

lmn_status powers_init(struct powers *p, const struct scene *s, bool is_off, struct error *err)
{
    lmn_status status = LMN_OK;
    const size_t n = (size_t)s->n_variables + 1;
    bool *is_free = mem_new(n, sizeof *is_free), is_settled = false;
    *p = (struct powers){.group_of = mem_new((size_t)s->n_emitters + 1, sizeof *p->group_of),
                         .variables = mem_new(n, sizeof *p->variables),
                         .at = mem_new(n, sizeof *p->at)};
    if (!is_free || !p->group_of || !p->variables || !p->at) {
        status = fail_memory(err, "groups of lights");
        goto done;
    }
    float at;
    for (uint32_t v = 0; v < s->n_variables; v++)
        is_free[v] = !is_off && drives_powers_alone(s, v, &at);
    /* A variable that one light takes away takes others from their groups: again, with fewer. */
    while (!is_settled) {
        uint32_t before = 0, after = 0;
        for (uint32_t v = 0; v < s->n_variables; v++) before += is_free[v];
        p->n = 0;
        memset(p->group_of, 0, s->n_emitters * sizeof *p->group_of);
        make_groups(p, s, is_free);
        for (uint32_t v = 0; v < s->n_variables; v++) after += is_free[v];
        is_settled = before == after;
    }
    for (uint32_t v = 0; v < s->n_variables; v++) {
        if (!is_free[v] || !drives_powers_alone(s, v, &at)) continue;
        p->variables[p->n_variables] = v;
        p->at[p->n_variables++] = at;
    }
    TRY(measure_reference(p, s, err));
done:
    mem_free(is_free);
    if (status != LMN_OK) powers_release(p);
    return status;
}

void powers_release(struct powers *p)
{
    mem_free(p->group_of);
    mem_free(p->variables);
    mem_free(p->at);
    *p = (struct powers){0};
}

/* ---- Use ------------------------------------------------------------------------------------- */

bool powers_has(const struct powers *p, uint32_t variable)
{
    for (uint32_t i = 0; i < p->n_variables; i++)
        if (p->variables[i] == variable) return true;
    return false;
}

void powers_set_reference(const struct powers *p, float *u)
{
    for (uint32_t i = 0; i < p->n_variables; i++) u[p->variables[i]] = p->at[i];
}

void powers_draw(const struct powers *p, struct rng *r, float *u)
{
    for (uint32_t i = 0; i < p->n_variables; i++) u[p->variables[i]] = rng_float(r);
}

void powers_at(const struct powers *p, const struct scene_state *state, float *out)
{
    for (uint32_t g = 0; g < p->n; g++) {
        const bool is_fixed = p->first[g] == SCENE_NONE;
        const struct vec3 now = is_fixed ? vec3_splat(1.0f) : radiance(state, p->first[g]);
        const float rgb[3] = {now.x, now.y, now.z};
        for (int c = 0; c < 3; c++) {
            const float full = is_fixed ? 1.0f : p->reference[g][c];
            out[3 * g + (uint32_t)c] = full > 0.0f ? rgb[c] / full : 0.0f;
        }
    }
}
