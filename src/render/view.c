/* SPDX-License-Identifier: Apache-2.0 */
#include "render/view.h"

#include <string.h>

#include "base/mem.h"
#include "render/buffers.h"
#include "render/light.h"
#include "render/world.h"
#include "scene/bounds.h"
#include "scene/pose.h"

lmn_status view_new(const struct world *w, struct view **out, struct error *err)
{
    const struct scene *s = w->scene;
    lmn_status status = LMN_OK;
    struct view *v = mem_new(1, sizeof *v);
    *out = NULL;
    if (!v) return fail_memory(err, "view");
    v->world = w;
    TRY(scene_state_init(s, &v->state, err));
    TRY(accel_top_new(w->accel, &v->top, err));
    v->materials = mem_new(s->n_bsdfs, sizeof *v->materials);
    v->ready = mem_new(2 * (size_t)s->n_bsdfs, sizeof *v->ready);
    v->looks = mem_new(s->n_bsdfs, sizeof *v->looks);
    v->shapes = mem_new(s->n_shapes, sizeof *v->shapes);
    v->instances = mem_new(s->n_instances, sizeof *v->instances);
    v->committed = mem_new(s->n_instances, sizeof *v->committed);
    v->lights = mem_new(w->n_lights_max, sizeof *v->lights);
    v->light_cdf = mem_new((size_t)w->n_lights_max + 1, sizeof *v->light_cdf);
    v->skies = mem_new(w->n_skies, sizeof *v->skies);
    uint32_t n_coats = material_count_coats(v->state.bsdfs, s->n_bsdfs);
    v->coats = mem_new(n_coats, sizeof *v->coats);
    if ((!v->coats && n_coats) || ((!v->materials || !v->ready) && s->n_bsdfs) ||
        (!v->looks && s->n_bsdfs) || (!v->shapes && s->n_shapes) ||
        (!v->instances && s->n_instances) || (!v->committed && s->n_instances) ||
        (!v->lights && w->n_lights_max) || !v->light_cdf || (!v->skies && w->n_skies)) {
        status = fail_memory(err, "view");
        goto done;
    }
    for (uint32_t i = 0; i < w->n_skies; i++) {
        if (sky_init(&v->skies[i])) continue;
        status = fail_memory(err, "view");
        goto done;
    }
    v->textures = (struct texture_set){
        .textures = v->state.textures,
        .bitmaps = s->bitmaps,
        .decode = w->decode,
    };
    if (!light_table_alloc(&v->table, v)) {
        status = fail_memory(err, "view");
        goto done;
    }
    view_refresh(v, true);
    *out = v;
    v = NULL;
done:
    view_free(v);
    return status;
}

void view_free(struct view *v)
{
    if (!v) return;
    accel_top_free(v->top);
    scene_state_release(&v->state);
    mem_free(v->materials);
    mem_free(v->ready);
    mem_free(v->looks);
    mem_free(v->shapes);
    mem_free(v->instances);
    mem_free(v->committed);
    mem_free(v->lights);
    mem_free(v->light_cdf);
    mem_free(v->coats);
    for (uint32_t i = 0; v->skies && i < v->world->n_skies; i++) sky_release(&v->skies[i]);
    mem_free(v->skies);
    light_table_release(&v->table);
    mem_free(v);
}

void view_set(struct view *v, const float *u)
{
    v->state.sensor = v->world->scene->defaults.sensor; /* it may have been moved by hand */
    scene_apply(v->world->scene, u, &v->state);
    view_refresh(v, false);
}

void view_look_from(struct view *v, const struct pose *p)
{
    pose_apply(p, &v->state.sensor);
}

const struct scene *view_scene(const struct view *v)
{
    return v->world->scene;
}

const struct scene_state *view_state(const struct view *v)
{
    return &v->state;
}

/* The factor by which a map scales all lengths; 0 when directions differ. */
static float uniform_scale(const struct transform *t)
{
    const float(*m)[4] = t->m;
    double g[3][3], most = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            g[i][j] = 0;
            for (int k = 0; k < 3; k++) g[i][j] += (double)m[k][i] * m[k][j];
        }
    for (int i = 0; i < 3; i++) most = fmax(most, g[i][i]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (fabs(g[i][j] - (i == j ? g[0][0] : 0.0)) > 1e-5 * most) return 0.0f;
    return (float)sqrt(g[0][0]);
}

static bool is_identity(const struct transform *t)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            if (t->m[i][j] != (i == j ? 1.0f : 0.0f)) return false;
    return true;
}

static void refresh_instance(struct view *v, uint32_t index)
{
    const struct scene *s = v->world->scene;
    const struct instance *i = &v->state.instances[index];
    const float(*m)[4] = i->to_world.m;
    float det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    v->instances[index] = (struct view_instance){
        .shapes = v->world->shapes + s->groups[i->group].first_shape,
        .views = v->shapes + s->groups[i->group].first_shape,
        .to_world = &i->to_world,
        .is_identity = is_identity(&i->to_world),
        .determinant = det,
        .scale = uniform_scale(&i->to_world),
    };
    accel_top_set_instance(v->top, index, &i->to_world, i->is_visible);
    v->committed[index] = *i;
}

static bool has_changed(const struct instance *a, const struct instance *b)
{
    return a->is_visible != b->is_visible ||
           memcmp(a->to_world.m, b->to_world.m, sizeof a->to_world.m) != 0;
}

/* Boxes around the lights that rays can hit, a little larger than these. */
static void refresh_boxes(struct view *v)
{
    v->n_boxes = 0;
    if (v->first_environment < v->n_lights) v->n_boxes = VIEW_NO_BOXES;
    for (uint32_t i = 0; i < v->n_lights && v->n_boxes != VIEW_NO_BOXES; i++) {
        const struct light *l = &v->lights[i];
        if (l->kind != EMITTER_AREA) continue;
        if (v->n_boxes == VIEW_BOXES) {
            v->n_boxes = VIEW_NO_BOXES;
            break;
        }
        struct bounds b = bounds_transform(&l->shape->bounds, v->instances[l->instance].to_world);
        struct vec3 size = vec3_sub(b.max, b.min);
        float most = max_float(vec3_max(b.max), -min_float(b.min.x, min_float(b.min.y, b.min.z)));
        struct vec3 pad = vec3_splat(1e-4f * (vec3_max(size) + most));
        v->boxes[v->n_boxes++] = (struct bounds){vec3_sub(b.min, pad), vec3_add(b.max, pad)};
    }
}

/* A sky and its sun, where they shine at all. */
static void add_sky(struct view *v, struct sky *sky, uint32_t emitter)
{
    const struct emitter *e = &v->state.emitters[emitter];
    sky_refresh(sky, e);
    struct light l = {.kind = EMITTER_SKY, .emitter = emitter, .sky = sky};
    if (e->sky_scale > 0.0f) v->lights[v->n_lights++] = l;
    l.kind = EMITTER_SUN;
    if (e->sun_scale > 0.0f && !vec3_is_zero(sky->sun)) v->lights[v->n_lights++] = l;
}

/* Shapes first, in order of instances; then points and the like; environments last. */
static void refresh_lights(struct view *v)
{
    const struct scene *s = v->world->scene;
    v->n_lights = 0;
    for (uint32_t i = 0; i < s->n_instances; i++) {
        const struct instance *instance = &v->state.instances[i];
        uint32_t n = v->world->group_n_lights[instance->group];
        v->instances[i].first_light = v->n_lights;
        if (n == 0 || !instance->is_visible) continue;
        const struct group *g = &s->groups[instance->group];
        for (uint32_t j = 0; j < g->n_shapes; j++) {
            const struct world_shape *shape = &v->instances[i].shapes[j];
            if (shape->emitter == SCENE_NONE) continue;
            v->lights[v->n_lights++] = (struct light){
                .kind = v->state.emitters[shape->emitter].kind,
                .emitter = shape->emitter,
                .instance = i,
                .shape = shape};
        }
    }
    struct sky *sky = v->skies;
    for (int pass = 0; pass < 2; pass++) {
        if (pass == 1) v->first_environment = v->n_lights;
        for (uint32_t i = 0; i < s->n_emitters; i++) {
            enum emitter_kind kind = v->state.emitters[i].kind;
            if (emitter_is_surface(kind) || emitter_is_environment(kind) != (pass == 1)) continue;
            if (kind == EMITTER_SKY) {
                add_sky(v, sky++, i);
                continue;
            }
            struct light *l = &v->lights[v->n_lights++];
            *l = (struct light){.kind = kind, .emitter = i};
            if (pass == 0) light_init_delta(l, v);
        }
    }
}

static void refresh_shape(struct view *v, uint32_t index)
{
    const struct world_shape *shape = &v->world->shapes[index];
    const struct material *m = &v->materials[v->state.shape_bsdfs[index]];
    const bool shines = shape->emitter != SCENE_NONE;
    v->shapes[index] = (struct view_shape){
        .shape = shape,
        .indices = shape->indices,
        .normals = shape->normals,
        .uvs = m->has_uv || shines ? shape->uvs : NULL,
        .picture = m->picture != SCENE_NONE ? &v->textures.textures[m->picture] : NULL,
        .reflectance = m->reflectance,
        .side = shape->is_flipped ? -1.0f : 1.0f,
        .is_simple = shape->kind == SHAPE_MESH && !m->has_direction && !m->has_tangents,
        .is_twosided = m->is_plain && m->is_twosided,
        .is_textured = m->texture != SCENE_NONE,
        .is_special = shines || !m->is_plain,
    };
}

void view_refresh(struct view *v, bool is_first)
{
    const struct scene *s = v->world->scene;
    bool has_moved = is_first;
    for (uint32_t i = 0; i < s->n_instances; i++) {
        if (!is_first && !has_changed(&v->state.instances[i], &v->committed[i])) continue;
        refresh_instance(v, i);
        has_moved = true;
    }
    if (has_moved) {
        accel_top_commit(v->top);
        few_init(&v->few, v);
    }
    refresh_lights(v);
    refresh_boxes(v);
    light_guide_init(&v->guide, v);
    light_table_init(&v->table, v, has_moved);
    material_init(v->materials, v->state.bsdfs, s->n_bsdfs, &v->textures, v->coats, v->ready);
    for (uint32_t i = 0; i < s->n_shapes; i++) refresh_shape(v, i);
    few_look_init(&v->few, v);
    buffers_init_looks(v->looks, v->materials, s->n_bsdfs, &v->textures);
}
