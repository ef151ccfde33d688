/* SPDX-License-Identifier: Apache-2.0 */
/* Latitude-longitude environments with Mitsuba's conventions: +y is up, the picture's centre column
 * lies along +z turned by pi; u grows with atan2(x, -z), v from +y down to -y. Texel centres in a
 * row are half a texel in from the seam; the first and last rows are the poles. */
#include "base/mem.h"
#include "render/light.h"

void envmap_release(struct world_envmap *e)
{
    mem_free(e->rgb);
    distribution2d_release(&e->cells);
    *e = (struct world_envmap){0};
}

static struct vec3 node(const struct world_envmap *e, uint32_t x, uint32_t y)
{
    const float *p = e->rgb + 3 * ((size_t)y * e->width + x);
    return vec3(p[0], p[1], p[2]);
}

bool envmap_alloc(struct world_envmap *e, uint32_t width, uint32_t height, float span)
{
    *e = (struct world_envmap){.width = width, .height = height, .span = span};
    e->rgb = mem_new((size_t)width * height, 3 * sizeof(float));
    if (e->rgb && distribution2d_alloc(&e->cells, width, height - 1)) return true;
    envmap_release(e);
    return false;
}

void envmap_weigh(struct world_envmap *e, float *weights)
{
    uint32_t width = e->width, n_rows = e->height - 1;
    double total = 0;
    for (uint32_t y = 0; y < n_rows; y++) {
        float area = cosf(e->span * (float)y / (float)n_rows) -
                     cosf(e->span * (float)(y + 1) / (float)n_rows);
        for (uint32_t x = 0; x < width; x++) {
            uint32_t right = x + 1 < width ? x + 1 : 0;
            struct vec3 sum = vec3_add(vec3_add(node(e, x, y), node(e, right, y)),
                                       vec3_add(node(e, x, y + 1), node(e, right, y + 1)));
            weights[(size_t)y * width + x] = vec3_luminance(sum) * area;
            total += (double)(vec3_luminance(sum) * area);
        }
    }
    e->mean = (float)(total / (8.0 * width)); /* of four nodes, of 2 in cos theta */
    distribution2d_set(&e->cells, weights);
}

bool envmap_init(struct world_envmap *e, const struct bitmap *b, const float decode[256])
{
    uint32_t width = b->width, height = b->height < 2 ? 2 : b->height;
    float *weights = mem_new((size_t)width * (height - 1), sizeof(float));
    if (!weights || !envmap_alloc(e, width, height, MATH_PI)) {
        mem_free(weights);
        return false;
    }
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            struct vec3 c = bitmap_texel(b, decode, x, y < b->height ? y : b->height - 1);
            /* Negative and broken texels would make densities that are none. */
            float *p = e->rgb + 3 * ((size_t)y * width + x);
            p[0] = c.x >= 0.0f && isfinite(c.x) ? c.x : 0.0f;
            p[1] = c.y >= 0.0f && isfinite(c.y) ? c.y : 0.0f;
            p[2] = c.z >= 0.0f && isfinite(c.z) ? c.z : 0.0f;
        }
    }
    envmap_weigh(e, weights);
    mem_free(weights);
    return true;
}

/* The place of direction d in the grid of cells, in [0,1]^2; below half a map y is beyond. */
static struct vec2 grid_place(const struct world_envmap *e, struct vec3 d)
{
    float u = atan2f(d.x, -d.z) * (0.5f * MATH_INV_PI) - 0.5f / (float)e->width;
    float v = acosf(min_float(max_float(d.y, -1.0f), 1.0f)) / e->span;
    u -= floor_float(u);
    return (struct vec2){u, v};
}

void envmap_nodes(const struct world_envmap *e, uint32_t x, uint32_t y, struct vec3 nodes[4])
{
    uint32_t right = x + 1 < e->width ? x + 1 : 0;
    nodes[0] = node(e, x, y);
    nodes[1] = node(e, right, y);
    nodes[2] = node(e, x, y + 1);
    nodes[3] = node(e, right, y + 1);
}

struct vec3 envmap_eval(const struct world_envmap *e, struct vec3 d)
{
    struct vec2 g = grid_place(e, d);
    if (g.y > 1.0f + 1e-6f) return vec3_splat(0.0f);
    float x = g.x * (float)e->width, y = g.y * (float)(e->height - 1);
    uint32_t x0 = (uint32_t)x, y0 = (uint32_t)y;
    if (x0 >= e->width) x0 = e->width - 1;
    if (y0 >= e->height - 1) y0 = e->height - 2;
    struct vec3 nodes[4];
    envmap_nodes(e, x0, y0, nodes);
    float wx = x - (float)x0, wy = y - (float)y0;
    struct vec3 top = vec3_madd(vec3_scale(nodes[0], 1.0f - wx), nodes[1], wx);
    struct vec3 bottom = vec3_madd(vec3_scale(nodes[2], 1.0f - wx), nodes[3], wx);
    return vec3_madd(vec3_scale(top, 1.0f - wy), bottom, wy);
}

float envmap_pdf(const struct world_envmap *e, struct vec3 d)
{
    struct vec2 g = grid_place(e, d);
    float y = g.y > 1.0f && g.y <= 1.0f + 1e-6f ? 1.0f : g.y; /* acos of pi, rounded up */
    return distribution2d_pdf(&e->cells, g.x, y) * envmap_density(e, sqrtf(d.x * d.x + d.z * d.z));
}
