/* SPDX-License-Identifier: Apache-2.0 */
#include "render/quadric.h"

#include <math.h>

void quadric_init(struct quadric *q, const struct shape *s)
{
    *q = (struct quadric){.kind = s->kind, .to_group = s->to_group};
    if (s->kind != SHAPE_SPHERE) return;
    double scale2 = 0;
    for (int i = 0; i < 3; i++) {
        q->center[i] = s->to_group.m[i][3];
        scale2 += (double)s->to_group.m[i][0] * s->to_group.m[i][0];
    }
    q->radius = sqrt(scale2);
}

void quadric_bounds(const struct quadric *q, float low[3], float high[3])
{
    for (int i = 0; i < 3; i++) {
        double a, b, r;
        if (q->kind == SHAPE_SPHERE) {
            a = b = q->center[i];
            r = q->radius;
        } else { /* the extent of an ellipse M (cos a, sin a, 0): sqrt(m0^2 + m1^2) */
            double m0 = q->to_group.m[i][0], m1 = q->to_group.m[i][1];
            a = b = q->to_group.m[i][3];
            if (q->kind == SHAPE_CYLINDER) b += q->to_group.m[i][2];
            r = sqrt(m0 * m0 + m1 * m1);
        }
        low[i] = (float)(fmin(a, b) - r);
        high[i] = (float)(fmax(a, b) + r);
        float pad = 1e-6f * (fabsf(low[i]) + fabsf(high[i]));
        low[i] -= pad;
        high[i] += pad;
    }
}

/* From the point of the ray closest to the centre, so that far and large spheres stay exact. */
static bool sphere_hit(const struct quadric *q, const struct quadric_ray *r, double *t)
{
    const double *d = r->d;
    const double l[3] = {r->o[0] - q->center[0], r->o[1] - q->center[1], r->o[2] - q->center[2]};
    double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    double t_mid = -(l[0] * d[0] + l[1] * d[1] + l[2] * d[2]) / a;
    double o[3], o2 = 0;
    for (int i = 0; i < 3; i++) {
        o[i] = l[i] + t_mid * d[i];
        o2 += o[i] * o[i];
    }
    double discriminant = q->radius * q->radius - o2;
    if (!(discriminant >= 0)) return false;
    double half = sqrt(discriminant / a);
    double near = t_mid - half, far = t_mid + half;
    *t = near >= r->t_min ? near : far;
    return *t >= r->t_min && *t <= r->t_max;
}

/* The ray in the shape's own space; t stays what it is. */
static void to_local(const struct quadric *q, const struct quadric_ray *r, double o[3], double d[3])
{
    const float(*m)[4] = q->to_group.inv;
    for (int i = 0; i < 3; i++) {
        o[i] = m[i][0] * r->o[0] + m[i][1] * r->o[1] + m[i][2] * r->o[2] + (double)m[i][3];
        d[i] = m[i][0] * r->d[0] + m[i][1] * r->d[1] + m[i][2] * r->d[2];
    }
}

static bool disk_hit(const struct quadric *q, const struct quadric_ray *r, double *t)
{
    double o[3], d[3];
    to_local(q, r, o, d);
    if (d[2] == 0) return false;
    *t = -o[2] / d[2];
    double x = o[0] + *t * d[0], y = o[1] + *t * d[1];
    return *t >= r->t_min && *t <= r->t_max && x * x + y * y <= 1;
}

/* The wall only, from both sides; the ends are open. */
static bool cylinder_hit(const struct quadric *q, const struct quadric_ray *r, double *t)
{
    double o[3], d[3];
    to_local(q, r, o, d);
    double a = d[0] * d[0] + d[1] * d[1];
    if (!(a > 0)) return false; /* along the axis */
    double t_mid = -(o[0] * d[0] + o[1] * d[1]) / a;
    double x = o[0] + t_mid * d[0], y = o[1] + t_mid * d[1];
    double discriminant = 1 - (x * x + y * y);
    if (!(discriminant >= 0)) return false;
    double half = sqrt(discriminant / a);
    for (int side = -1; side <= 1; side += 2) {
        *t = t_mid + side * half;
        double z = o[2] + *t * d[2];
        if (*t >= r->t_min && *t <= r->t_max && z >= 0 && z <= 1) return true;
    }
    return false;
}

bool quadric_hit(const struct quadric *q, const struct quadric_ray *r, double *t)
{
    switch (q->kind) {
    case SHAPE_SPHERE:
        return sphere_hit(q, r, t);
    case SHAPE_DISK:
        return disk_hit(q, r, t);
    case SHAPE_CYLINDER:
        return cylinder_hit(q, r, t);
    case SHAPE_MESH:
        break;
    }
    return false;
}

void quadric_normal(const struct quadric *q, const struct quadric_ray *r, double t, float n[3])
{
    const float(*m)[4] = q->to_group.inv;
    double o[3], d[3], x = 0, y = 0, z = 1;
    if (q->kind == SHAPE_SPHERE) {
        for (int k = 0; k < 3; k++) n[k] = (float)(r->o[k] + t * r->d[k] - q->center[k]);
        return;
    }
    if (q->kind == SHAPE_CYLINDER) {
        to_local(q, r, o, d);
        x = o[0] + t * d[0];
        y = o[1] + t * d[1];
        z = 0;
    }
    for (int k = 0; k < 3; k++) n[k] = (float)(m[0][k] * x + m[1][k] * y + m[2][k] * z);
}
