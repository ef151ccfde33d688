/* SPDX-License-Identifier: Apache-2.0 */
#include "math/transform.h"

#include <string.h>

struct transform transform_identity(void)
{
    struct transform t = {0};
    for (int i = 0; i < 3; i++) t.m[i][i] = t.inv[i][i] = 1.0f;
    return t;
}

struct transform transform_translate(struct vec3 offset)
{
    struct transform t = transform_identity();
    const float d[3] = {offset.x, offset.y, offset.z};
    for (int i = 0; i < 3; i++) {
        t.m[i][3] = d[i];
        t.inv[i][3] = -d[i];
    }
    return t;
}

struct transform transform_scale(struct vec3 factor)
{
    struct transform t = {0};
    const float f[3] = {factor.x, factor.y, factor.z};
    for (int i = 0; i < 3; i++) {
        t.m[i][i] = f[i];
        t.inv[i][i] = 1.0f / f[i];
    }
    return t;
}

struct transform transform_rotate(struct vec3 axis, float degrees)
{
    /* Rodrigues; in double so that 90 degrees gives clean zeros. */
    double length = sqrt((double)vec3_dot(axis, axis));
    double a[3] = {axis.x / length, axis.y / length, axis.z / length};
    double angle = (double)degrees * 3.14159265358979323846 / 180.0;
    double c = cos(angle), s = sin(angle);
    const double cross[3][3] = {{0, -a[2], a[1]}, {a[2], 0, -a[0]}, {-a[1], a[0], 0}};
    struct transform t = {0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            t.m[i][j] = (float)((i == j ? c : 0.0) + (1 - c) * a[i] * a[j] + s * cross[i][j]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) t.inv[i][j] = t.m[j][i];
    return t;
}

struct transform transform_look_at(struct vec3 origin, struct vec3 target, struct vec3 up)
{
    struct vec3 dir = vec3_normalize(vec3_sub(target, origin));
    struct vec3 left = vec3_normalize(vec3_cross(up, dir));
    struct vec3 new_up = vec3_cross(dir, left);
    const struct vec3 columns[4] = {left, new_up, dir, origin};
    struct transform t;
    for (int j = 0; j < 4; j++) {
        t.m[0][j] = columns[j].x;
        t.m[1][j] = columns[j].y;
        t.m[2][j] = columns[j].z;
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) t.inv[i][j] = t.m[j][i];
        t.inv[i][3] = -vec3_dot(columns[i], origin);
    }
    return t;
}

bool transform_from_matrix(const double m[16], struct transform *out)
{
    const double a = m[0], b = m[1], c = m[2], d = m[4], e = m[5], f = m[6], g = m[8], h = m[9],
                 i = m[10];
    const double cofactor[3][3] = {
        {e * i - f * h, c * h - b * i, b * f - c * e},
        {f * g - d * i, a * i - c * g, c * d - a * f},
        {d * h - e * g, b * g - a * h, a * e - b * d},
    };
    double det = a * cofactor[0][0] + b * cofactor[1][0] + c * cofactor[2][0];
    double scale = 0;
    for (int r = 0; r < 12; r++)
        if (r % 4 != 3) scale = fmax(scale, fabs(m[r]));
    if (!isfinite(det) || !(fabs(det) > 1e-18 * scale * scale * scale)) return false;
    for (int r = 0; r < 3; r++) {
        double translated = 0;
        for (int s = 0; s < 4; s++) out->m[r][s] = (float)m[4 * r + s];
        for (int s = 0; s < 3; s++) {
            double v = cofactor[r][s] / det;
            out->inv[r][s] = (float)v;
            translated -= v * m[4 * s + 3];
        }
        out->inv[r][3] = (float)translated;
    }
    return true;
}

static void multiply(const float a[3][4], const float b[3][4], float out[3][4])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            double sum = j == 3 ? a[i][3] : 0.0;
            for (int k = 0; k < 3; k++) sum += (double)a[i][k] * b[k][j];
            out[i][j] = (float)sum;
        }
    }
}

struct transform transform_mul(const struct transform *a, const struct transform *b)
{
    struct transform t;
    multiply(a->m, b->m, t.m);
    multiply(b->inv, a->inv, t.inv);
    return t;
}

bool transform_flips(const struct transform *t)
{
    const float(*m)[4] = t->m;
    float det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    return det < 0.0f;
}
