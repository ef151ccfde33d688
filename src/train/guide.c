/* SPDX-License-Identifier: Apache-2.0 */
#include "train/guide.h"

#include <math.h>

#include "base/mem.h"
#include "render/camera.h"

/* Half the side of the square around a photon where pixels go, by the picture's longer side: what
 * so few photons can tell. */
#define NEAR 0.015f

/* With fewer photons there is hardly a caustic. */
enum { LEAST = 4 };

lmn_status guide_init(struct guide *g, uint32_t n_photons, struct error *err)
{
    *g = (struct guide){0};
    lmn_status status = photon_map_new(n_photons, &g->map, err);
    if (status != LMN_OK) return status;
    g->x = mem_new(n_photons, sizeof *g->x);
    g->y = mem_new(n_photons, sizeof *g->y);
    return g->x && g->y ? LMN_OK : fail_memory(err, "photons");
}

void guide_release(struct guide *g)
{
    photon_map_free(g->map);
    mem_free(g->x);
    mem_free(g->y);
    *g = (struct guide){0};
}

uint64_t guide_memory_size(const struct guide *g)
{
    return photon_map_memory(g->map) + 2 * sizeof(float) * (uint64_t)g->map->n_emitted;
}

static bool is_inside(float x, float y, uint32_t width, uint32_t height)
{
    return x >= 0.0f && y >= 0.0f && x < (float)width && y < (float)height;
}

/* Where photons lie in the picture. Whether something stands before them is not asked. */
static uint32_t find_photons(struct guide *g, const struct view *v, uint32_t width, uint32_t height)
{
    const struct photon_map *m = g->map;
    struct camera camera;
    uint32_t n = 0;
    camera_init(&camera, &view_state(v)->sensor, width, height);
    for (uint32_t i = 0; i < m->n_emitted; i++) {
        const struct photon *a = &m->landed[i];
        if (a->n_casters > 0 && camera_project(&camera, a->p, &g->x[n], &g->y[n]))
            n += is_inside(g->x[n], g->y[n], width, height);
    }
    return n;
}

/* The most of them in the square around one. */
static uint32_t most_together(const struct guide *g, uint32_t n, float near)
{
    uint32_t most = 0;
    for (uint32_t i = 0; i < n; i++) {
        uint32_t count = 0;
        for (uint32_t k = 0; k < n; k++)
            count += fabsf(g->x[i] - g->x[k]) < near && fabsf(g->y[i] - g->y[k]) < near;
        most = count > most ? count : most;
    }
    return most;
}

void guide_pixels(struct guide *g, const struct view *v, const struct trace_settings *t,
                  uint32_t width, uint32_t height, struct rng *r, struct pixel_at *pixels,
                  uint32_t n)
{
    photon_map_trace(g->map, v, NULL, t, 0);
    const uint32_t n_found = find_photons(g, v, width, height);
    if (n_found < LEAST) return;
    const float near = NEAR * (float)(width > height ? width : height);
    /* By how much the densest square would be denser if all pixels went to photons. */
    const float density = (float)most_together(g, n_found, near) / (float)n_found * (float)width *
                          (float)height / (4.0f * near * near);
    const float share = fminf(GUIDE_SHARE, GUIDE_MOST / density);
    for (uint32_t i = 0; i < n; i++) {
        if (rng_float(r) >= share) continue;
        const uint32_t k = rng_below(r, n_found);
        const float x = g->x[k] + near * (2.0f * rng_float(r) - 1.0f),
                    y = g->y[k] + near * (2.0f * rng_float(r) - 1.0f);
        if (is_inside(x, y, width, height)) pixels[i] = (struct pixel_at){(uint32_t)x, (uint32_t)y};
    }
}
