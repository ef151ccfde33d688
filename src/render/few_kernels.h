/* SPDX-License-Identifier: Apache-2.0 */
/* Rays of a stream against few primitives (few.h), for one instruction set: a part of
 * stream_kernels.h. */
#include "render/few.h"

/* The point of a face's plane where a ray meets it. */
struct crossing {
    float t, x, y;
};

LANE struct crossing cross_lane(const struct lanes3 *o, const struct lanes3 *d, uint32_t i,
                                const struct few_face *f)
{
    struct vec3 from = vec3_sub(lanes3_get(o, i), f->p), along = lanes3_get(d, i);
    float t = -vec3_dot(f->n, from) / vec3_dot(f->n, along);
    struct vec3 at = vec3_madd(from, along, t);
    return (struct crossing){t, vec3_dot(f->to_x, at), vec3_dot(f->to_y, at)};
}

/* Comparisons with no number fail: rays along the plane miss it. */
LANE bool is_inside(struct crossing c, const struct few_face *f)
{
    return (c.x >= f->least) & (c.y >= f->least) & (c.x <= 1.0f) & (c.y <= 1.0f) &
           (c.x + c.y <= f->most) & (c.x * c.x + c.y * c.y <= f->most2);
}

/* Where rays meet a wall across axis a; b and c are the next two. Infinite or no number for rays
 * along it, which miss it. */
LANE struct crossing wall_lane(const float *const o[3], const float *const d[3], uint32_t i,
                               int axis, float at)
{
    int b = (axis + 1) % 3, c = (axis + 2) % 3;
    float t = (at - o[axis][i]) / d[axis][i];
    return (struct crossing){t, o[b][i] + t * d[b][i], o[c][i] + t * d[c][i]};
}

LANE bool is_on(struct crossing c, const struct few_wall *w)
{
    return (c.x >= w->low[0]) & (c.x <= w->high[0]) & (c.y >= w->low[1]) & (c.y <= w->high[1]);
}

LANE void cast_at_walls(const struct stream *s, const struct few *few, int axis, float *best,
                        int32_t *index)
{
    const float *const o[3] = {s->o.x, s->o.y, s->o.z}, *const d[3] = {s->d.x, s->d.y, s->d.z};
    uint32_t n = s->n;
    for (uint32_t k = few->first_wall[axis]; k < few->first_wall[axis + 1]; k++) {
        const struct few_wall w = few->walls[k];
        int32_t number = (int32_t)(few->n_loose + k);
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            struct crossing c = wall_lane(o, d, i, axis, w.at);
            bool is_best = is_on(c, &w) & (c.t >= 0.0f) & (c.t < best[i]);
            best[i] = choose(is_best, c.t, best[i]);
            index[i] = is_best ? number : index[i];
        }
    }
}

LANE void shade_by_walls(const struct stream *s, const struct few *few, int axis, uint32_t *is_free)
{
    const struct lanes3 *from = &s->shadow_o, *along = &s->shadow_d;
    const float *const o[3] = {from->x, from->y, from->z};
    const float *const d[3] = {along->x, along->y, along->z};
    uint32_t n = s->n;
    for (uint32_t k = few->first_wall[axis]; k < few->first_wall[axis + 1]; k++) {
        const struct few_wall w = few->walls[k];
        if (!w.shades) continue;
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            struct crossing c = wall_lane(o, d, i, axis, w.at);
            bool is_met = is_on(c, &w) & (c.t >= 0.0f) & (c.t <= s->shadow_t_max[i]);
            is_free[i] = is_met ? 0 : is_free[i];
        }
    }
}

/* Where the ray first meets the sphere beyond 0; INFINITY where it does not. In double, and from
 * the point of the ray closest to the centre, as quadric.c: far and large spheres stay exact, and
 * so do paths through glass. a: 1 / |d|^2. */
LANE float sphere_lane(const struct lanes3 *o, const struct lanes3 *d, uint32_t i, double a,
                       const struct few_sphere *s)
{
    double dx = d->x[i], dy = d->y[i], dz = d->z[i];
    double x = (double)o->x[i] - s->center[0], y = (double)o->y[i] - s->center[1],
           z = (double)o->z[i] - s->center[2];
    double middle = -(x * dx + y * dy + z * dz) * a;
    x += middle * dx;
    y += middle * dy;
    z += middle * dz;
    double left = s->radius * s->radius - (x * x + y * y + z * z), inside = left * a;
    double half = sqrt(inside > 0.0 ? inside : 0.0);
    double near = middle - half, far = middle + half, t = near >= 0.0 ? near : far;
    bool is_met = (left >= 0.0) & (t >= 0.0);
    return is_met ? (float)t : INFINITY;
}

KERNEL invert_squares(const struct lanes3 *d, uint32_t n, double *a)
{
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        double dx = d->x[i], dy = d->y[i], dz = d->z[i];
        a[i] = 1.0 / (dx * dx + dy * dy + dz * dz);
    }
}

/* Where a ray goes into a box and out of it, and by which faces. */
struct passage {
    float in, out;
    int32_t in_face, out_face;
};

LANE struct passage pass_lane(const struct lanes3 *o, const struct lanes3 *d, uint32_t i,
                              const struct few_box *b)
{
    struct vec3 from = vec3_sub(lanes3_get(o, i), b->center), along = lanes3_get(d, i);
    struct passage p = {-INFINITY, INFINITY, 0, 0};
    for (int k = 0; k < 3; k++) {
        /* Along a pair of faces these are infinite: of one sign outside of them, of two between. */
        float q = vec3_dot(b->to_local[k], from), inverse = 1.0f / vec3_dot(b->to_local[k], along);
        float low = (-1.0f - q) * inverse, high = (1.0f - q) * inverse;
        float in = min_float(low, high), out = max_float(low, high);
        bool is_forward = inverse >= 0.0f, is_later = in > p.in, is_sooner = out < p.out;
        int32_t first = is_forward ? b->face[k][0] : b->face[k][1];
        int32_t second = is_forward ? b->face[k][1] : b->face[k][0];
        p.in = is_later ? in : p.in;
        p.out = is_sooner ? out : p.out;
        p.in_face = is_later ? first : p.in_face;
        p.out_face = is_sooner ? second : p.out_face;
    }
    return p;
}

/* The nearest primitive for each ray. */
KERNEL few_cast(struct stream *s, const struct few *few)
{
    double inverse[STREAM_SIZE];
    float *best = s->t;
    int32_t *index = s->face;
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        best[i] = s->t_max[i];
        index[i] = -1;
    }
    for (uint32_t k = 0; k < few->n_loose; k++) {
        const struct few_face f = few->faces[k];
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            struct crossing c = cross_lane(&s->o, &s->d, i, &f);
            bool is_best = is_inside(c, &f) & (c.t >= 0.0f) & (c.t < best[i]);
            best[i] = choose(is_best, c.t, best[i]);
            index[i] = is_best ? (int32_t)k : index[i];
        }
    }
    cast_at_walls(s, few, 0, best, index);
    cast_at_walls(s, few, 1, best, index);
    cast_at_walls(s, few, 2, best, index);
    for (uint32_t k = 0; k < few->n_boxes; k++) {
        const struct few_box f = few->boxes[k];
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            struct passage p = pass_lane(&s->o, &s->d, i, &f);
            bool is_outside = p.in >= 0.0f;
            float t = choose(is_outside, p.in, p.out);
            int32_t face = is_outside ? p.in_face : p.out_face;
            bool is_best = (p.in <= p.out) & (t >= 0.0f) & (t < best[i]);
            best[i] = choose(is_best, t, best[i]);
            index[i] = is_best ? face : index[i];
        }
    }
    if (few->n_spheres > 0) invert_squares(&s->d, n, inverse);
    for (uint32_t k = 0; k < few->n_spheres; k++) {
        const struct few_sphere f = few->spheres[k];
        int32_t number = (int32_t)(few->n_faces + k);
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            float t = sphere_lane(&s->o, &s->d, i, inverse[i], &f);
            index[i] = t < best[i] ? number : index[i];
            best[i] = min_float(t, best[i]);
        }
    }
}

static void few_look_up(const struct few *few, float *to, const float *column, const int32_t *face,
                        uint32_t n)
{
    if (few->n_faces + few->n_spheres <= LOOK_UP_FEW)
        look_up(to, column, face, n);
    else
        gather(to, column, face, n);
}

static void few_look_up_3(const struct few *few, struct lanes3 *to, const struct few_vectors *from,
                          const int32_t *face, uint32_t n)
{
    few_look_up(few, to->x, from->x, face, n);
    few_look_up(few, to->y, from->y, face, n);
    few_look_up(few, to->z, from->z, face, n);
}

/* What rays find on faces that are even. */
KERNEL few_arrive(struct stream *s, const struct few *few, bool is_surrounded)
{
    const struct few_look *look = &few->look;
    float flags[STREAM_SIZE];
    int32_t face[STREAM_SIZE] = {0};
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) face[i] = s->face[i] < 0 ? 0 : s->face[i];
    few_look_up(few, flags, look->flags, face, n);
    few_look_up_3(few, &s->reflectance, &look->reflectance, face, n);
    few_look_up_3(few, &s->frame_n, &look->shading, face, n);
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        bool is_hit = s->face[i] >= 0;
        int32_t flag = (int32_t)flags[i];
        float side = choose((flag & FEW_OPPOSITE) != 0, -1.0f, 1.0f);
        lanes3_set(&s->p, i, vec3_madd(lanes3_get(&s->o, i), lanes3_get(&s->d, i), s->t[i]));
        lanes3_set(&s->normal, i, vec3_scale(lanes3_get(&s->frame_n, i), side));
        s->bsdf_is_twosided[i] = (flag & FEW_TWOSIDED) != 0;
        s->bsdf_is_smooth[i] = true;
        s->is_alive[i] &= is_hit | is_surrounded;
        s->is_special[i] = s->is_alive[i] & !(is_hit & ((flag & FEW_EVEN) != 0));
    }
}

/* Whether shadow rays are free. */
KERNEL few_shade(struct stream *s, const struct few *few, uint32_t *is_free)
{
    double inverse[STREAM_SIZE];
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) is_free[i] = s->is_connected[i];
    for (uint32_t k = 0; k < few->n_boxes; k++) {
        const struct few_box f = few->boxes[k];
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            struct passage p = pass_lane(&s->shadow_o, &s->shadow_d, i, &f);
            float t = choose(p.in >= 0.0f, p.in, p.out);
            bool is_met = (p.in <= p.out) & (t >= 0.0f) & (t < s->shadow_t_max[i]);
            is_free[i] = is_met ? 0 : is_free[i];
        }
    }
    shade_by_walls(s, few, 0, is_free);
    shade_by_walls(s, few, 1, is_free);
    shade_by_walls(s, few, 2, is_free);
    for (uint32_t k = 0; k < few->n_loose; k++) {
        const struct few_face f = few->faces[k];
        if (!f.shades) continue;
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            struct crossing c = cross_lane(&s->shadow_o, &s->shadow_d, i, &f);
            bool is_met = is_inside(c, &f) & (c.t >= 0.0f) & (c.t <= s->shadow_t_max[i]);
            is_free[i] = is_met ? 0 : is_free[i];
        }
    }
    if (few->n_spheres > 0) invert_squares(&s->shadow_d, n, inverse);
    for (uint32_t k = 0; k < few->n_spheres; k++) {
        const struct few_sphere f = few->spheres[k];
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            float t = sphere_lane(&s->shadow_o, &s->shadow_d, i, inverse[i], &f);
            is_free[i] = t < s->shadow_t_max[i] ? 0 : is_free[i];
        }
    }
}
