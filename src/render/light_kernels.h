/* SPDX-License-Identifier: Apache-2.0 */
/* Light samples in vector code, for one instruction set: a part of stream_kernels.h. */
#include "render/light_table.h"

#ifdef __AVX512F__
#include <immintrin.h>
#endif

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

/* Index, probability and rest of the random number. */
KERNEL choose_light(struct stream *s, const struct light_guide *g)
{
    float weights[LIGHT_GUIDES][STREAM_SIZE], sum[STREAM_SIZE];
    float even[STREAM_SIZE], scale[STREAM_SIZE];
    uint32_t n = s->n, n_lights = g->n;
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
    int32_t high[STREAM_SIZE];
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        struct light_range r = light_table_range(t, s->light_index[i], s->light_left[i]);
        s->element[i] = r.low;
        high[i] = r.high;
    }
    for (int32_t left = t->n_widest; left > 1; left = (left + 1) / 2) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            struct light_range r = {s->element[i], high[i]};
            r = light_table_halve(t, r, s->light_left[i]);
            s->element[i] = r.low;
            high[i] = r.high;
        }
    }
}

/* The same, of few elements one at a time for all lanes. */
KERNEL choose_elements(struct stream *s, const struct light_table *t)
{
    uint32_t n = s->n;
    if (t->n > LIGHT_TABLE_FEW) {
        search_elements(s, t);
        return;
    }
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) s->element[i] = t->first[s->light_index[i]];
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
    float fields[LIGHT_FIELDS][STREAM_SIZE], radiance[3][STREAM_SIZE];
};

/* to[i] = column[index[i]] of LIGHT_TABLE_FEW. Two registers hold a column: that is many times
 * quicker than going to memory lane by lane. */
static inline void look_up(float *to, const float *column, const int32_t *index, uint32_t n)
{
#ifdef __AVX512F__
    const __m512 low = _mm512_loadu_ps(column), high = _mm512_loadu_ps(column + STREAM_VECTOR);
    for (uint32_t i = 0; i < n; i += STREAM_VECTOR) {
        const __m512i at = _mm512_loadu_si512(index + i);
        _mm512_storeu_ps(to + i, _mm512_permutex2var_ps(low, at, high));
    }
#else
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) to[i] = column[index[i]];
#endif
}

KERNEL look_up_elements(struct element_lanes *b, const struct stream *s,
                        const struct light_table *t)
{
    const uint32_t n = s->n, n_fields = light_fields(t->kinds);
    for (int c = 0; c < 3; c++) look_up(b->radiance[c], t->radiance[c], s->light_index, n);
    for (uint32_t f = 0; f < n_fields; f++) {
        const float *column = t->rows + f;
        float *to = b->fields[f];
        if (t->n <= LIGHT_TABLE_FEW) {
            look_up(to, t->columns[f], s->element, n);
            continue;
        }
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) to[i] = column[LIGHT_FIELDS * s->element[i]];
    }
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

LANE void light_lane(struct stream *s, uint32_t i, const struct element_lanes *b, uint32_t kinds,
                     struct sphere_sample on_sphere)
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
    s->has_light[i] &= is_found;
}

LANE struct sphere_sample sphere_lane_sample(const struct stream *s, uint32_t i,
                                             const struct element_lanes *b)
{
    return light_sphere_sample(field3(b, 0, i), b->fields[4][i], lanes3_get(&s->p, i),
                               s->light_left[i], s->u[1][i]);
}

/* In two steps: compilers would branch around the spheres. */
KERNEL light_all(struct stream *s, const struct element_lanes *b)
{
    float x[STREAM_SIZE], y[STREAM_SIZE], z[STREAM_SIZE], pdf[STREAM_SIZE];
    uint32_t n = s->n;
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
        light_lane(s, i, b, LIGHT_ALL, (struct sphere_sample){vec3(x[i], y[i], z[i]), pdf[i]});
}

KERNEL light(struct stream *s, const struct light_table *t)
{
    const struct sphere_sample none = {vec3_splat(0.0f), 0.0f};
    struct element_lanes b;
    uint32_t n = s->n;
    choose_elements(s, t);
    look_up_elements(&b, s, t);
    if (t->kinds == LIGHT_FACES) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) light_lane(s, i, &b, LIGHT_FACES, none);
    } else if (t->kinds == LIGHT_SMOOTH) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) light_lane(s, i, &b, LIGHT_SMOOTH, none);
    } else if (t->kinds == LIGHT_DISKS) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) light_lane(s, i, &b, LIGHT_DISKS, none);
    } else if (t->kinds == LIGHT_SPHERES) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++)
            light_lane(s, i, &b, LIGHT_SPHERES, sphere_lane_sample(s, i, &b));
    } else {
        light_all(s, &b);
    }
}
