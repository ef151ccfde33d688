/* SPDX-License-Identifier: Apache-2.0 */
#include "train/tails.h"

#include "base/mem.h"

struct list {
    struct path_ends ends;
    uint32_t n_looked;
    float **to;     /* [capacity], of the target's pixel */
    float *weights; /* [capacity][3] */
    float *positions, *features, *scale, *v;
};

struct tails {
    const struct sight *sight;
    uint32_t n_items, capacity;
    uint64_t memory_size;
    struct list *lists;
    struct field_run *runs;
    float *groups; /* [n_items][capacity][n_lights][3] */
};

static void *take(struct tails *t, size_t count, size_t size, bool *is_short)
{
    void *block = mem_new(count > 0 ? count : 1, size);
    if (block)
        t->memory_size += (uint64_t)count * size;
    else
        *is_short = true;
    return block;
}

static bool take_list(struct tails *t, struct list *l)
{
    const size_t n = t->capacity;
    const struct sight *s = t->sight;
    bool is_short = false;
    l->ends.capacity = t->capacity;
    l->ends.ends = take(t, n, sizeof *l->ends.ends, &is_short);
    l->ends.buffers = take(t, n, sizeof(float[BUFFER_CHANNELS]), &is_short);
    l->to = take(t, n, sizeof *l->to, &is_short);
    l->weights = take(t, n, sizeof(float[3]), &is_short);
    l->positions = take(t, n * s->n_positions, sizeof(float[3]), &is_short);
    l->features = take(t, n * s->n_features, sizeof(float), &is_short);
    l->scale = take(t, n, sizeof(float[3]), &is_short);
    l->v = take(t, s->n_variables, sizeof(float), &is_short);
    return !is_short;
}

lmn_status tails_new(const struct sight *sight, uint32_t n_items, uint32_t capacity,
                     struct tails **out, struct error *err)
{
    struct tails *t = mem_new(1, sizeof *t);
    bool is_short = false;
    *out = NULL;
    if (!t) return fail_memory(err, "the ends of paths");
    t->sight = sight;
    t->capacity = capacity;
    t->lists = take(t, n_items, sizeof *t->lists, &is_short);
    t->runs = take(t, n_items, sizeof *t->runs, &is_short);
    t->groups = take(t, (size_t)n_items * capacity * sight->powers.n, sizeof(float[3]), &is_short);
    while (!is_short && t->n_items < n_items) is_short |= !take_list(t, &t->lists[t->n_items++]);
    if (is_short) {
        tails_free(t);
        return fail_memory(err, "the ends of paths");
    }
    *out = t;
    return LMN_OK;
}

void tails_free(struct tails *t)
{
    if (!t) return;
    for (uint32_t i = 0; i < t->n_items; i++) {
        struct list *l = &t->lists[i];
        void *const blocks[] = {l->ends.ends, l->ends.buffers, l->to,    l->weights,
                                l->positions, l->features,     l->scale, l->v};
        for (size_t k = 0; k < sizeof blocks / sizeof *blocks; k++) mem_free(blocks[k]);
    }
    mem_free(t->lists);
    mem_free(t->runs);
    mem_free(t->groups);
    mem_free(t);
}

uint64_t tails_memory_size(const struct tails *t)
{
    return t->memory_size;
}

struct path_ends *tails_ends(struct tails *t, uint32_t item)
{
    return &t->lists[item].ends;
}

void tails_clear(struct tails *t, uint32_t item)
{
    t->lists[item].ends.n = t->lists[item].n_looked = 0;
}

void tails_look(struct tails *t, uint32_t item, const struct scene_state *state, float *targets,
                uint32_t spp)
{
    const struct sight *s = t->sight;
    struct list *l = &t->lists[item];
    const uint32_t first = l->n_looked, n = l->ends.n - first;
    const float share = 1.0f / (float)spp;
    sight_look(s, state, l->ends.buffers + (size_t)first * BUFFER_CHANNELS, n,
               l->positions + (size_t)first * s->n_positions * 3,
               l->features + (size_t)first * s->n_features, l->scale + (size_t)first * 3);
    for (uint32_t i = first; i < l->ends.n; i++) {
        const struct path_end *end = &l->ends.ends[i];
        const struct vec3 w = vec3_scale(end->throughput, share);
        const bool is_finite = vec3_is_finite(w);
        const float bounces = sight_bounces(s, end->max_depth);
        sight_set_bounces(s, &bounces, 1, l->features + (size_t)i * s->n_features);
        l->to[i] = targets + (size_t)end->pixel * s->powers.n * 3;
        l->weights[3 * i + 0] = is_finite ? w.x : 0.0f;
        l->weights[3 * i + 1] = is_finite ? w.y : 0.0f;
        l->weights[3 * i + 2] = is_finite ? w.z : 0.0f;
    }
    l->n_looked = l->ends.n;
}

void tails_add(struct tails *t, struct field *field, tails_u_fn *us, const void *user)
{
    const struct sight *s = t->sight;
    const uint32_t n_colors = 3 * s->powers.n;
    const float *groups = t->groups;
    uint32_t n_runs = 0;
    for (uint32_t i = 0; i < t->n_items; i++) {
        const struct list *l = &t->lists[i];
        if (l->ends.n == 0) continue;
        sight_variables(s, us(user, i), l->v);
        t->runs[n_runs++] = (struct field_run){.n = l->ends.n,
                                               .positions = l->positions,
                                               .features = l->features,
                                               .scale = l->scale,
                                               .v = l->v};
    }
    field_render_groups(field, t->runs, n_runs, t->groups);
    for (uint32_t i = 0; i < t->n_items; i++) {
        const struct list *l = &t->lists[i];
        for (uint32_t k = 0; k < l->ends.n; k++, groups += n_colors)
            for (uint32_t c = 0; c < n_colors; c++)
                l->to[k][c] += l->weights[3 * k + c % 3] * groups[c];
    }
}
