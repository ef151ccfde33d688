/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the compact network sees, over lanes of pixels: included once by each instruction set's
 * file, which defines before:
 *
 *   LANES                  pixels of a vector
 *   vec, vec_mask          vectors of floats, of lanes' truth
 *   and the operations used below
 *
 * The operations are those of sight_plain.c in the same order, none fused, so that results have the
 * same bytes.
 */

#define INLINE static inline __attribute__((always_inline))

/* Three numbers of each pixel. */
struct lanes3 {
    vec x, y, z;
};

INLINE struct lanes3 lanes3_splat(struct vec3 v)
{
    return (struct lanes3){vec_set1(v.x), vec_set1(v.y), vec_set1(v.z)};
}

INLINE struct lanes3 lanes3_sub(struct lanes3 a, struct lanes3 b)
{
    return (struct lanes3){vec_sub(a.x, b.x), vec_sub(a.y, b.y), vec_sub(a.z, b.z)};
}

INLINE struct lanes3 lanes3_scale(struct lanes3 a, vec s)
{
    return (struct lanes3){vec_mul(a.x, s), vec_mul(a.y, s), vec_mul(a.z, s)};
}

/* a + b s */
INLINE struct lanes3 lanes3_madd(struct lanes3 a, struct lanes3 b, vec s)
{
    return (struct lanes3){vec_add(a.x, vec_mul(b.x, s)), vec_add(a.y, vec_mul(b.y, s)),
                           vec_add(a.z, vec_mul(b.z, s))};
}

INLINE vec lanes3_dot(struct lanes3 a, struct lanes3 b)
{
    return vec_add(vec_add(vec_mul(a.x, b.x), vec_mul(a.y, b.y)), vec_mul(a.z, b.z));
}

INLINE vec lanes3_length(struct lanes3 a)
{
    return vec_sqrt(lanes3_dot(a, a));
}

INLINE struct lanes3 lanes3_where(vec_mask mask, struct lanes3 a)
{
    return (struct lanes3){vec_where(mask, a.x), vec_where(mask, a.y), vec_where(mask, a.z)};
}

INLINE vec row_point(const float m[4], struct lanes3 p)
{
    const vec xy = vec_add(vec_mul(vec_set1(m[0]), p.x), vec_mul(vec_set1(m[1]), p.y));
    return vec_add(vec_add(xy, vec_mul(vec_set1(m[2]), p.z)), vec_set1(m[3]));
}

/* Numbers of LANES pixels: what is put next goes to `to`. */
INLINE vec *put(vec *to, struct lanes3 v)
{
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
    return to + 3;
}

INLINE vec *put_direction(vec *to, struct lanes3 v)
{
    const vec one = vec_set1(1.0f), length = lanes3_length(v);
    const vec_mask is_long = vec_above(length, vec_set1(0.0f));
    to = put(to, lanes3_scale(v, vec_where(is_long, vec_div(one, length))));
    *to++ = vec_div(one, vec_add(one, length));
    return to;
}

/* The buffers of LANES pixels, with room for whole blocks to transpose. */
struct source {
    vec channels[(BUFFER_CHANNELS + LANES - 1) / LANES * LANES];
};

/* Rows of n_rows pixels, the last one again for those missing: much faster than to gather. */
INLINE void fetch(const float *buffers, uint32_t n_rows, struct source *to)
{
    for (uint32_t k = 0; k < BUFFER_CHANNELS; k += LANES) {
        const vec_tail mask = vec_first(BUFFER_CHANNELS - k);
        vec rows[LANES];
        for (uint32_t r = 0; r < LANES; r++) {
            const size_t row = r < n_rows ? r : n_rows - 1;
            rows[r] = vec_load_part(buffers + row * BUFFER_CHANNELS + k, mask);
        }
        transpose(to->channels + k, rows);
    }
}

INLINE vec load(const struct source *b, int channel)
{
    const vec x = b->channels[channel];
    return vec_where(vec_equal(vec_sub(x, x), vec_set1(0.0f)), x); /* not finite: 0 */
}

INLINE struct lanes3 load3(const struct source *b, int channel)
{
    return (struct lanes3){load(b, channel), load(b, channel + 1), load(b, channel + 2)};
}

/* The normal on the side that is looked at. */
INLINE struct lanes3 facing(const struct source *b)
{
    const struct lanes3 n = load3(b, BUFFER_NORMAL), wo = load3(b, BUFFER_WO);
    const vec side = lanes3_dot(load3(b, BUFFER_GEO_NORMAL), wo);
    const vec_mask is_behind = vec_above(vec_set1(0.0f), side);
    return lanes3_sub(n, lanes3_where(is_behind, lanes3_scale(n, vec_set1(2.0f))));
}

/* That buffer is zero on diffuse surfaces. */
INLINE vec_mask glossy(const struct source *b)
{
    const vec zero = vec_set1(0.0f);
    const struct lanes3 wi = load3(b, BUFFER_WI);
    return vec_mask_or(vec_mask_or(vec_unequal(wi.x, zero), vec_unequal(wi.y, zero)),
                       vec_unequal(wi.z, zero));
}

INLINE vec *surface(const struct source *b, vec_mask is_glossy, struct lanes3 n,
                    struct lanes3 albedo, vec *to)
{
    const struct lanes3 wo = load3(b, BUFFER_WO);
    const vec twice = vec_mul(vec_set1(2.0f), lanes3_dot(n, wo));
    to = put(to, n);
    to = put(to, lanes3_where(is_glossy, wo));
    to = put(to, lanes3_where(is_glossy, lanes3_sub(lanes3_scale(n, twice), wo)));
    *to++ = load(b, BUFFER_ROUGHNESS);
    to = put(to, albedo);
    *to++ = vec_where(is_glossy, vec_set1(1.0f));
    return to;
}

/* The point of the segment from p to q that is closest to the origin. */
INLINE struct lanes3 closest(struct lanes3 p, struct lanes3 q)
{
    const vec zero = vec_set1(0.0f);
    const struct lanes3 d = lanes3_sub(q, p);
    const vec length2 = lanes3_dot(d, d), t = vec_div(vec_sub(zero, lanes3_dot(p, d)), length2);
    const vec within = vec_max(vec_where(vec_above(length2, zero), t), zero);
    return lanes3_madd(p, d, vec_min(within, vec_set1(1.0f)));
}

/* `count` numbers of the first n_rows pixels, to [n_rows][count]. */
static void store(const vec *numbers, uint32_t count, uint32_t n_rows, float *to)
{
    for (uint32_t k = 0; k < count; k += LANES) {
        const vec_tail mask = vec_first(count - k);
        vec rows[LANES];
        transpose(rows, numbers + k);
        for (uint32_t r = 0; r < n_rows; r++)
            vec_store_part(to + (size_t)r * count + k, mask, rows[r]);
    }
}

/* Numbers of LANES pixels; room for whole blocks to transpose. */
struct numbers {
    vec positions[(3 * (1 + SIGHT_FRAMES) + LANES - 1) / LANES * LANES];
    vec features[(SIGHT_MOST_FEATURES + LANES - 1) / LANES * LANES];
    vec scale[LANES];
};

static void look(const struct sight_moment *m, const struct source *b, struct numbers *to)
{
    const vec one = vec_set1(1.0f), zero = vec_set1(0.0f);
    const struct lanes3 p = load3(b, BUFFER_POSITION);
    const struct lanes3 normal = facing(b);
    const struct lanes3 albedo = load3(b, BUFFER_ALBEDO), box = lanes3_splat(m->size);
    const struct lanes3 in_box = lanes3_sub(p, lanes3_splat(m->corner));
    const vec_mask is_glossy = glossy(b);
    struct lanes3 local[SIGHT_FRAMES];
    vec *x = to->positions, *f = to->features;
    x = put(x, (struct lanes3){vec_div(in_box.x, box.x), vec_div(in_box.y, box.y),
                               vec_div(in_box.z, box.z)});
    f = surface(b, is_glossy, normal, albedo, f);
    for (uint32_t k = 0; k < m->n_frames; k++) {
        const float(*t)[4] = m->frames[k].to_local.m;
        local[k] = (struct lanes3){zero, zero, zero};
        if (!m->frames[k].is_visible) {
            x = put(x, lanes3_splat(vec3_splat(0.5f)));
            f = put(f, local[k]);
            *f++ = zero;
            continue;
        }
        local[k] = (struct lanes3){row_point(t[0], p), row_point(t[1], p), row_point(t[2], p)};
        const vec to_cube = vec_div(vec_set1(0.5f), vec_add(one, lanes3_length(local[k])));
        x = put(x, lanes3_madd(lanes3_splat(vec3_splat(0.5f)), local[k], to_cube));
        f = put_direction(f, local[k]);
    }
    for (uint32_t l = 0; l < m->n_lights; l++) {
        const struct lanes3 way = lanes3_sub(lanes3_splat(m->lights[l]), p);
        f = put_direction(f, lanes3_scale(way, vec_set1(m->light_scale)));
        *f = lanes3_dot((struct lanes3){f[-4], f[-3], f[-2]}, normal);
        f++;
        for (uint32_t k = 0; k < m->n_frames; k++) {
            const struct lanes3 at = closest(local[k], lanes3_splat(m->local_lights[l][k]));
            const vec near = m->frames[k].is_visible ? vec_div(one, vec_add(one, lanes3_length(at)))
                                                     : zero;
            f = put(f, lanes3_scale(at, near));
            *f++ = near;
        }
    }
    *f++ = one;
    const vec_mask is_hit = vec_above(b->channels[BUFFER_DEPTH], zero);
    const vec least = vec_where(is_glossy, vec_set1(LEAST_SCALE));
    put(to->scale,
        lanes3_where(is_hit, (struct lanes3){vec_max(albedo.x, least), vec_max(albedo.y, least),
                                             vec_max(albedo.z, least)}));
}

static void look_all(const struct sight_job *j)
{
    const struct sight_moment *m = j->moment;
    const uint32_t n_coordinates = 3 * (1 + m->n_frames);
    struct numbers numbers;
    memset(&numbers, 0, sizeof numbers);
    for (uint32_t at = 0; at < j->n; at += LANES) {
        const size_t first = at;
        const uint32_t n_rows = j->n - at < LANES ? j->n - at : LANES;
        struct source b;
        fetch(j->buffers + first * BUFFER_CHANNELS, n_rows, &b);
        look(m, &b, &numbers);
        store(numbers.positions, n_coordinates, n_rows, j->positions + first * n_coordinates);
        store(numbers.features, m->n_features, n_rows, j->features + first * m->n_features);
        store(numbers.scale, 3, n_rows, j->scale + first * 3);
    }
}
