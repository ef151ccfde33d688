/* SPDX-License-Identifier: Apache-2.0 */
/* Light samples in vector code, for one instruction set: a part of stream_kernels.h. */
#include "render/light_around.h"
#include "render/light_table.h"

/* ---- Which light ----------------------------------------------------------------------------- */

/* A step of light_choose(): does the lane's random number fall on light k? */
LANE void choose_lane(struct stream *s, uint32_t i, float p, int32_t k, bool is_last)
{
    float left = s->light_left[i];
    bool is_open = s->light_index[i] < 0;
    bool takes = is_open & ((left < p) | is_last);
    s->light_index[i] = takes ? k : s->light_index[i];
    s->light_choice[i] = choose(takes, p, s->light_choice[i]);
    s->light_left[i] = choose(is_open & !takes, left - p, left);
}

/* Index, probability and rest of the random number; as all here up to the last vector's end, where
 * indices must be valid, too. */
KERNEL choose_light(struct stream *s, const struct light_guide *g)
{
    float weights[LIGHT_GUIDES][STREAM_SIZE], sum[STREAM_SIZE];
    float even[STREAM_SIZE], scale[STREAM_SIZE];
    uint32_t n = stream_whole(s->n), n_lights = g->n;
    int32_t none = n_lights > 0 ? -1 : 0;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        s->light_left[i] = s->u[0][i];
        s->light_choice[i] = 1.0f;
        s->light_index[i] = none;
        sum[i] = 0.0f;
    }
    if (n_lights == 0) return;
    for (uint32_t k = 0; k < n_lights; k++) {
        const struct light_hint h = g->hints[k];
        float *w = weights[k];
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            w[i] = light_weight(&h, lanes3_get(&s->p, i));
            sum[i] += w[i];
        }
    }
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        struct light_shares shares = light_shares(n_lights, sum[i]);
        even[i] = shares.even;
        scale[i] = shares.scale;
    }
    for (uint32_t k = 0; k < n_lights; k++) {
        const float *w = weights[k];
        bool is_last = k + 1 == n_lights;
#pragma omp simd
        for (uint32_t i = 0; i < n; i++)
            choose_lane(s, i, light_share((struct light_shares){even[i], scale[i]}, w[i]),
                        (int32_t)k, is_last);
    }
#pragma omp simd
    for (uint32_t i = 0; i < n; i++)
        s->light_left[i] = light_rest(s->light_left[i], s->light_choice[i]);
}

/* ---- Which element --------------------------------------------------------------------------- */

/* As light_table_sample() does, all lanes in step: more steps leave what is found as it is. */
KERNEL search_elements(struct stream *s, const struct light_table *t)
{
    int32_t part[STREAM_SIZE], count[STREAM_SIZE], high[STREAM_SIZE], middle[STREAM_SIZE];
    float cdf[STREAM_SIZE];
    uint32_t n = stream_whole(s->n);
    look_up(part, t->first_part, s->light_index, n);
    look_up(count, t->count, s->light_index, n);
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) part[i] += light_table_part(s->light_left[i], count[i]);
    gather2(s->element, high, t->parts, part, n);
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) high[i]++;
    for (int32_t left = t->n_widest; left > 1; left = (left + 1) / 2) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) middle[i] = (s->element[i] + high[i]) / 2;
        gather(cdf, t->cdf, middle, n);
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            bool is_above = cdf[i] <= s->light_left[i];
            s->element[i] = is_above ? middle[i] : s->element[i];
            high[i] = is_above ? high[i] : middle[i];
        }
    }
}

/* The same, of few elements one at a time for all lanes. */
KERNEL choose_elements(struct stream *s, const struct light_table *t)
{
    uint32_t n = stream_whole(s->n);
    if (t->n > LIGHT_TABLE_FEW) {
        search_elements(s, t);
        return;
    }
    if (t->holds == UINT32_MAX >> (32 - t->n)) { /* every light is one element */
        memcpy(s->element, s->light_index, n * sizeof *s->element);
        return;
    }
    look_up(s->element, t->first, s->light_index, n);
    for (int32_t light = 0; light < LIGHT_GUIDES; light++) {
        if (!(t->holds >> light & 1)) continue;
        for (int32_t k = 1; k < t->count[light]; k++) {
            float cdf = t->cdf[t->first[light] + k];
#pragma omp simd
            for (uint32_t i = 0; i < n; i++)
                s->element[i] += (s->light_index[i] == light) & (cdf <= s->light_left[i]);
        }
    }
}

/* ---- Looking it up --------------------------------------------------------------------------- */

/* What is known of all lanes' elements: struct light_element, number by number. */
struct element_lanes {
    _Alignas(STREAM_ALIGNMENT) float fields[LIGHT_FIELDS][STREAM_SIZE];
    float radiance[3][STREAM_SIZE];
};

KERNEL look_up_elements(struct element_lanes *b, const struct stream *s,
                        const struct light_table *t)
{
    const uint32_t n = stream_whole(s->n), n_fields = light_fields(t->kinds);
    for (int c = 0; c < 3; c++) look_up(b->radiance[c], t->radiance[c], s->light_index, n);
    if (t->n <= LIGHT_TABLE_FEW) {
        for (uint32_t f = 0; f < n_fields; f++) look_up(b->fields[f], t->columns[f], s->element, n);
        return;
    }
    int32_t row[STREAM_SIZE];
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) row[i] = LIGHT_FIELDS * s->element[i];
    for (uint32_t f = 0; f < n_fields; f += 2)
        gather2(b->fields[f], b->fields[f + 1], t->rows + f, row, n);
}

LANE struct vec3 field3(const struct element_lanes *b, int f, uint32_t i)
{
    return vec3(b->fields[f][i], b->fields[f + 1][i], b->fields[f + 2][i]);
}

LANE struct light_element lane_element(const struct element_lanes *b, uint32_t i)
{
    return (struct light_element){field3(b, 0, i),  b->fields[3][i],  b->fields[4][i],
                                  field3(b, 5, i),  field3(b, 8, i),  field3(b, 11, i),
                                  b->fields[14][i], b->fields[15][i], b->fields[16][i],
                                  field3(b, 17, i), field3(b, 20, i), b->fields[23][i]};
}

/* ---- Samples --------------------------------------------------------------------------------- */

/* Lanes of lights that are not in the table are left wanting one. */
LANE void light_lane(struct stream *s, uint32_t i, const struct element_lanes *b, uint32_t holds,
                     uint32_t kinds, struct sphere_sample on_sphere)
{
    const struct vec3 radiance = {b->radiance[0][i], b->radiance[1][i], b->radiance[2][i]};
    struct light_sample l;
    bool is_found = light_element_sample(&l, kinds, lane_element(b, i), radiance,
                                         lanes3_get(&s->p, i), s->light_left[i], s->u[1][i],
                                         s->light_choice[i], on_sphere);
    lanes3_set(&s->light_p, i, l.p);
    lanes3_set(&s->light_d, i, l.d);
    lanes3_set(&s->light_weight, i, l.weight);
    s->light_pdf[i] = l.pdf;
    s->light_is_delta[i] = s->light_is_infinite[i] = false;
    s->has_light[i] &= is_found | (~holds >> s->light_index[i] & 1);
}

LANE struct sphere_sample sphere_lane_sample(const struct stream *s, uint32_t i,
                                             const struct element_lanes *b)
{
    return light_sphere_sample(field3(b, 0, i), b->fields[4][i], lanes3_get(&s->p, i),
                               s->light_left[i], s->u[1][i]);
}

/* In two steps: compilers would branch around the spheres. */
KERNEL light_all(struct stream *s, const struct element_lanes *b, uint32_t holds)
{
    float x[STREAM_SIZE], y[STREAM_SIZE], z[STREAM_SIZE], pdf[STREAM_SIZE];
    uint32_t n = stream_whole(s->n);
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        struct sphere_sample a = sphere_lane_sample(s, i, b);
        x[i] = a.n.x;
        y[i] = a.n.y;
        z[i] = a.n.z;
        pdf[i] = a.pdf;
    }
#pragma omp simd
    for (uint32_t i = 0; i < n; i++)
        light_lane(s, i, b, holds, LIGHT_ALL,
                   (struct sphere_sample){vec3(x[i], y[i], z[i]), pdf[i]});
}

KERNEL light(struct stream *s, const struct light_table *t)
{
    const struct sphere_sample none = {vec3_splat(0.0f), 0.0f};
    struct element_lanes b;
    const uint32_t n = stream_whole(s->n), holds = t->holds;
    choose_elements(s, t);
    look_up_elements(&b, s, t);
    if (t->kinds == LIGHT_FACES) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) light_lane(s, i, &b, holds, LIGHT_FACES, none);
    } else if (t->kinds == LIGHT_SMOOTH) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) light_lane(s, i, &b, holds, LIGHT_SMOOTH, none);
    } else if (t->kinds == LIGHT_DISKS) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) light_lane(s, i, &b, holds, LIGHT_DISKS, none);
    } else if (t->kinds == LIGHT_SPHERES) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++)
            light_lane(s, i, &b, holds, LIGHT_SPHERES, sphere_lane_sample(s, i, &b));
    } else {
        light_all(s, &b, holds);
    }
}

/* ---- Environments ---------------------------------------------------------------------------- */

/* The lanes that have chosen one environment, brought together. */
struct around_block {
    uint32_t n, n_filled; /* as in struct facet_block */
    _Alignas(STREAM_ALIGNMENT) float u[STREAM_SIZE];
    float v[STREAM_SIZE], choice[STREAM_SIZE];
    struct lanes3 d, weight;
    float pdf[STREAM_SIZE];
    uint32_t is_found[STREAM_SIZE];
    /* Maps: a cell, its density, and the values around it. */
    int32_t column[STREAM_SIZE], row[STREAM_SIZE], at[STREAM_SIZE];
    float low[STREAM_SIZE], high[STREAM_SIZE], density[STREAM_SIZE];
    struct lanes3 nodes[4];
};

/* Inverts cumulative sums of n items, which begin at from[at] for each lane: at becomes the place
 * of the item's, u the rest of the random number, density the item's probability times n. Steps
 * are those of distribution.c. */
KERNEL invert_lanes(struct around_block *b, const float *from, uint32_t n, float *u)
{
    float *low = b->low, *high = b->high;
    int32_t *at = b->at;
    const uint32_t n_lanes = b->n_filled;
#pragma omp simd
    for (uint32_t k = 0; k < n_lanes; k++) u[k] = min_float(max_float(u[k], 0.0f), 0x1.fffffep-1f);
    for (uint32_t size = n; size > 1; size -= size / 2) {
        const int32_t half = (int32_t)(size / 2);
        gather(low, from + half, at, n_lanes);
#pragma omp simd
        for (uint32_t k = 0; k < n_lanes; k++) at[k] += low[k] <= u[k] ? half : 0;
    }
    gather2(low, high, from, at, n_lanes);
#pragma omp simd
    for (uint32_t k = 0; k < n_lanes; k++) {
        float share = high[k] - low[k];
        u[k] = min_float((u[k] - low[k]) / share, 0x1.fffffep-1f);
        b->density[k] = b->density[k] * share * (float)n;
    }
}

KERNEL choose_cells(struct around_block *b, const struct world_envmap *e)
{
    const uint32_t n = b->n_filled;
    const int32_t width = (int32_t)e->width;
    int32_t left[STREAM_SIZE], right[STREAM_SIZE];
#pragma omp simd
    for (uint32_t k = 0; k < n; k++) {
        b->at[k] = 0;
        b->density[k] = 1.0f;
    }
    invert_lanes(b, e->cells.rows, e->cells.height, b->v);
#pragma omp simd
    for (uint32_t k = 0; k < n; k++) {
        b->row[k] = b->at[k];
        b->at[k] *= width + 1;
    }
    invert_lanes(b, e->cells.cells, e->cells.width, b->u);
#pragma omp simd
    for (uint32_t k = 0; k < n; k++) {
        int32_t column = b->at[k] - b->row[k] * (width + 1);
        b->column[k] = column;
        left[k] = 3 * (b->row[k] * width + column);
        right[k] = 3 * (b->row[k] * width + (column + 1 < width ? column + 1 : 0));
    }
    for (int half = 0; half < 2; half++) {
        const float *rgb = e->rgb + half * 3 * (size_t)width;
        for (int side = 0; side < 2; side++) {
            struct lanes3 *node = &b->nodes[2 * half + side];
            const int32_t *at = side ? right : left;
            gather2(node->x, node->y, rgb, at, n);
            gather(node->z, rgb + 2, at, n);
        }
    }
}

LANE void around_lane(struct around_block *b, uint32_t k, const struct light_around *a,
                      enum emitter_kind kind)
{
    struct light_sample l;
    if (kind == EMITTER_CONSTANT) {
        light_around_constant(a, b->u[k], b->v[k], &l);
    } else if (kind == EMITTER_SUN) {
        light_around_sun(a, b->u[k], b->v[k], &l);
    } else {
        const struct vec3 nodes[4] = {lanes3_get(&b->nodes[0], k), lanes3_get(&b->nodes[1], k),
                                      lanes3_get(&b->nodes[2], k), lanes3_get(&b->nodes[3], k)};
        light_around_map(a, b->column[k], b->row[k], b->u[k], b->v[k], b->density[k], nodes, &l);
    }
    float pdf = l.pdf * b->choice[k];
    b->is_found[k] = (l.pdf > 0.0f) & (l.pdf < INFINITY);
    b->pdf[k] = pdf;
    lanes3_set(&b->d, k, l.d);
    lanes3_set(&b->weight, k, vec3_scale(l.weight, 1.0f / pdf));
}

KERNEL around_lanes(struct around_block *b, const struct light_around *around)
{
    const struct light_around a = *around;
    const uint32_t n = b->n_filled;
    if (a.kind == EMITTER_CONSTANT) {
#pragma omp simd
        for (uint32_t k = 0; k < n; k++) around_lane(b, k, &a, EMITTER_CONSTANT);
    } else if (a.kind == EMITTER_SUN) {
#pragma omp simd
        for (uint32_t k = 0; k < n; k++) around_lane(b, k, &a, EMITTER_SUN);
    } else {
        choose_cells(b, a.map);
#pragma omp simd
        for (uint32_t k = 0; k < n; k++) around_lane(b, k, &a, EMITTER_ENVMAP);
    }
}

static void light_around(struct stream *s, const struct light_around *a, const uint32_t *lanes,
                         uint32_t n_lanes)
{
    struct around_block b;
    b.n = n_lanes;
    b.n_filled = stream_whole(n_lanes);
    for (uint32_t k = 0; k < b.n_filled; k++) {
        const uint32_t i = lanes[k < b.n ? k : 0];
        b.u[k] = s->light_left[i];
        b.v[k] = s->u[1][i];
        b.choice[k] = s->light_choice[i];
    }
    around_lanes(&b, a);
    for (uint32_t k = 0; k < b.n; k++) {
        const uint32_t i = lanes[k];
        lanes3_set(&s->light_p, i, vec3_splat(0.0f));
        lanes3_set(&s->light_d, i, lanes3_get(&b.d, k));
        lanes3_set(&s->light_weight, i, lanes3_get(&b.weight, k));
        s->light_pdf[i] = b.pdf[k];
        s->light_is_delta[i] = false;
        s->light_is_infinite[i] = true;
        s->has_light[i] = b.is_found[k];
    }
}
