/* SPDX-License-Identifier: Apache-2.0 */
/* Public path tracing, and what pictures of a scene share. */
#include "api/handles.h"

#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "render/photon.h"
#include "scene/light_groups.h"

lmn_status scene_window(const lmn_scene *scene, const uint32_t size[2], const uint32_t crop[4],
                        struct window *out, struct error *err)
{
    const struct render_settings *s = &scene->scene->settings;
    const uint32_t width = size[0] ? size[0] : s->width, height = size[1] ? size[1] : s->height;
    if ((size[0] == 0) != (size[1] == 0))
        return fail(err, LMN_ERR_ARGUMENT, "size %ux%u: a side is 0", size[0], size[1]);
    if (width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE)
        return fail(err, LMN_ERR_ARGUMENT, "size %ux%u: a side can have %d pixels at most", width,
                    height, IMAGE_MAX_SIDE);
    *out = (struct window){
        .full_width = width, .full_height = height, .width = width, .height = height};
    if (crop[2] == 0 && crop[3] == 0) return LMN_OK;
    if (crop[2] == 0 || crop[3] == 0 || crop[0] >= width || crop[1] >= height ||
        crop[2] > width - crop[0] || crop[3] > height - crop[1])
        return fail(err, LMN_ERR_ARGUMENT, "crop %u,%u,%u,%u: not inside the picture of %ux%u",
                    crop[0], crop[1], crop[2], crop[3], width, height);
    out->x = crop[0];
    out->y = crop[1];
    out->width = crop[2];
    out->height = crop[3];
    return LMN_OK;
}

static void add_vector(struct str *to, const char *name, struct vec3 v)
{
    str_add(to, "%s %.9g,%.9g,%.9g ", name, (double)v.x, (double)v.y, (double)v.z);
}

lmn_status describe_image(struct image *image, const lmn_scene *scene, const float *u,
                          const struct pose *camera, uint64_t seed, uint32_t spp, struct error *err)
{
    lmn_status status = LMN_OK;
    const struct scene *s = scene->scene;
    struct str text = {0};
    TRY(image_set_attribute(image, "software", "lumenaut " LMN_VERSION, err));
    TRY(image_set_attribute(image, "scene", scene->path, err));
    str_add(&text, "%llu", (unsigned long long)seed);
    if (!text.failed) TRY(image_set_attribute(image, "seed", text.text, err));
    text.length = 0;
    str_add(&text, "%u", spp);
    if (!text.failed) TRY(image_set_attribute(image, "spp", text.text, err));
    text.length = 0;
    for (uint32_t i = 0; i < s->n_variables; i++)
        str_add(&text, "%s%s=%.9g", i ? " " : "", s->variables[i].name,
                variable_from_unit(&s->variables[i], u[i]));
    if (s->n_variables > 0 && !text.failed)
        TRY(image_set_attribute(image, "variables", text.text, err));
    text.length = 0;
    if (camera) {
        add_vector(&text, "origin", camera->origin);
        add_vector(&text, "target", camera->target);
        add_vector(&text, "up", camera->up);
        str_add(&text, "fov %.9g", (double)camera->fov);
        if (!text.failed) TRY(image_set_attribute(image, "camera", text.text, err));
    }
    if (text.failed) status = fail_memory(err, "an image");
done:
    str_release(&text);
    return status;
}

static lmn_status choose(const char *what, const char *word, const char *const *names, uint32_t n,
                         uint32_t *out, struct error *err)
{
    for (uint32_t i = 0; i < n; i++) {
        if (strcmp(word, names[i]) == 0) {
            *out = i;
            return LMN_OK;
        }
    }
    return fail(err, LMN_ERR_ARGUMENT, "%s \"%s\": %s%s%s or %s", what, word, n > 2 ? names[0] : "",
                n > 2 ? ", " : "", names[n - 2], names[n - 1]);
}

static lmn_status read_settings(const lmn_scene *scene, const lmn_trace_options *o,
                                struct trace_settings *t, struct error *err)
{
    static const char *const samplers[2] = {"independent", "sobol"};
    static const char *const weights[2] = {"power", "balance"};
    lmn_status status = LMN_OK;
    uint32_t choice = 0;
    trace_settings_init(t, scene->scene);
    t->splats = true;
    if (o->spp) t->spp = o->spp;
    t->first_sample = o->first_sample;
    if (o->has_max_depth) t->max_depth = o->max_depth;
    if (o->has_rr_depth) t->rr_depth = o->rr_depth;
    t->seed = o->seed;
    t->sampler = SAMPLER_SOBOL;
    if (o->sampler) {
        TRY(choose("sampler", o->sampler, samplers, 2, &choice, err));
        t->sampler = choice ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT;
    }
    if (o->mis) {
        TRY(choose("mis", o->mis, weights, 2, &choice, err));
        t->mis = choice ? MIS_BALANCE : MIS_POWER;
    }
    t->follows_delta = o->follow_delta;
    if (o->follow_delta && !o->buffers)
        status = fail(err, LMN_ERR_ARGUMENT, "follow_delta: only with buffers");
    if (o->first_sample % 2)
        status = fail(err, LMN_ERR_ARGUMENT, "first_sample %u: odd", o->first_sample);
    if (o->first_sample > UINT32_MAX - t->spp)
        status = fail(err, LMN_ERR_ARGUMENT, "first_sample %u: %u more samples are beyond the last",
                      o->first_sample, t->spp);
    if (t->max_depth < -1)
        status = fail(err, LMN_ERR_ARGUMENT, "max_depth %d: at least -1", t->max_depth);
    if (t->rr_depth < 1)
        status = fail(err, LMN_ERR_ARGUMENT, "rr_depth %d: at least 1", t->rr_depth);
done:
    return status;
}

static const char *const integrators[3] = {"auto", "path", "path+photons"};

/* What was asked for, else what the scene asks for; auto looks at the view. */
static lmn_status choose_integrator(const lmn_context *context, const lmn_scene *scene,
                                    const lmn_trace_options *o, struct trace_settings *t,
                                    bool *has_photons, struct error *err)
{
    lmn_status status = LMN_OK;
    uint32_t choice = scene->scene->settings.integrator;
    if (o->integrator) TRY(choose("integrator", o->integrator, integrators, 3, &choice, err));
    *has_photons = choice == INTEGRATOR_PHOTONS;
    if (choice == INTEGRATOR_AUTO)
        TRY(view_wants_photons(scene->cache->view, context->pool, t, has_photons, err));
    if ((o->half_buffers || *has_photons) && t->spp < UINT32_MAX) t->spp += t->spp % 2;
done:
    return status;
}

/* The parts of a traced picture, as planes of interleaved channels, and their names. */
struct planes {
    struct {
        const float *data;
        uint32_t n_channels;
    } * list;           /* [n_planes] */
    const char **names; /* [n_names], of channels */
    uint32_t n_planes, n_names;
    float *owned[6]; /* what is behind the planes */
    uint32_t n_owned;
    struct str text; /* the names of groups, one after another */
};

static lmn_status planes_init(struct planes *p, uint32_t n_groups, struct error *err)
{
    p->list = mem_new(5 + (size_t)n_groups, sizeof *p->list);
    p->names = mem_new(9 + BUFFER_CHANNELS + CHAIN_CHANNELS + 3 * (size_t)n_groups,
                       sizeof *p->names);
    return p->list && p->names ? LMN_OK : fail_memory(err, "the picture");
}

static void planes_release(struct planes *p)
{
    for (uint32_t k = 0; k < p->n_owned; k++) mem_free(p->owned[k]);
    mem_free(p->list);
    mem_free(p->names);
    str_release(&p->text);
}

/* Room for n_planes planes, one after another; *out is the first. Their names are added after. */
static lmn_status add_planes(struct planes *p, const struct window *w, uint32_t n_planes,
                             uint32_t n_channels, float **out, struct error *err)
{
    /* Sides are at most 2^15: no overflow. */
    const size_t n = (size_t)w->width * w->height * n_channels;
    float *data = mem_new(n_planes, n * sizeof *data);
    if (!data) return fail_memory(err, "the picture");
    p->owned[p->n_owned++] = data;
    for (uint32_t k = 0; k < n_planes; k++) {
        p->list[p->n_planes].data = data + k * n;
        p->list[p->n_planes++].n_channels = n_channels;
    }
    *out = data;
    return LMN_OK;
}

static lmn_status add_plane(struct planes *p, const struct window *w, uint32_t n_channels,
                            const char *const *names, float **out, struct error *err)
{
    for (uint32_t c = 0; c < n_channels; c++) p->names[p->n_names++] = names[c];
    return add_planes(p, w, 1, n_channels, out, err);
}

/* "lamp.R", "lamp.rest.R" or, when all light is one group, "rest.R" */
static void name_group_channel(struct str *text, const struct light_groups *g, uint32_t plane,
                               bool is_split, char channel)
{
    if (g->names) str_add(text, "%s.", g->names[plane % g->n]);
    if (is_split) str_add(text, "%s.", plane < g->n ? "rest" : "seen");
    str_add_bytes(text, &channel, 1);
    str_add_bytes(text, "", 1); /* the end of a name */
}

/* Split: first the rest of all groups, then what is seen along delta chains. */
static lmn_status add_groups(struct planes *p, const struct light_groups *g, bool is_split,
                             const struct window *w, struct trace_output *out, struct error *err)
{
    lmn_status status = LMN_OK;
    const uint32_t n = g->n * (is_split ? 2 : 1);
    size_t *starts = mem_new(3 * (size_t)n, sizeof *starts);
    TRY(add_planes(p, w, n, 3, &out->groups, err));
    out->n_groups = n;
    out->group_of = g->of;
    out->chain_group = is_split ? g->n : 0;
    for (uint32_t i = 0; starts && i < 3 * n; i++) {
        starts[i] = p->text.length;
        name_group_channel(&p->text, g, i / 3, is_split, "RGB"[i % 3]);
    }
    if (!starts || p->text.failed) status = fail_memory(err, "the picture");
    for (uint32_t i = 0; !status && i < 3 * n; i++)
        p->names[p->n_names++] = p->text.text + starts[i];
done:
    mem_free(starts);
    return status;
}

/* All light as one group without a name. */
static lmn_status one_group(struct light_groups *g, const struct scene *s, struct error *err)
{
    g->of = mem_new((size_t)s->n_emitters + 1, sizeof *g->of);
    g->n = 1;
    return g->of ? LMN_OK : fail_memory(err, "light groups");
}

static void interleave(const struct planes *p, struct image *image)
{
    const size_t n_pixels = (size_t)image->width * image->height;
    uint32_t first = 0;
    for (uint32_t k = 0; k < p->n_planes; k++) {
        const uint32_t n = p->list[k].n_channels;
        for (size_t i = 0; i < n_pixels; i++)
            memcpy(image->data + i * image->n_channels + first, p->list[k].data + i * n,
                   n * sizeof(float));
        first += n;
    }
}

lmn_status lmn_scene_trace(lmn_context *context, const lmn_scene *scene, const double *values,
                           const lmn_trace_options *options, lmn_image **out, double *render_s)
{
    static const char *const colour[3] = {"R", "G", "B"};
    static const char *const half_a[3] = {"a.R", "a.G", "a.B"};
    static const char *const half_b[3] = {"b.R", "b.G", "b.B"};
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    lmn_trace_options o;
    struct trace_settings settings;
    struct trace_output output = {0};
    struct window window;
    struct planes planes = {0};
    struct image image = {0};
    struct light_groups groups = {0};
    bool has_photons;
    *out = NULL;
    TRY(options_copy("lmn_trace_options", options, &o, sizeof o, err));
    TRY(scene_window(scene, (uint32_t[2]){o.width, o.height},
                     (uint32_t[4]){o.crop_x, o.crop_y, o.crop_width, o.crop_height}, &window, err));
    TRY(read_settings(scene, &o, &settings, err));
    TRY(scene_units(scene, values, scene->cache->u, err));
    if (o.camera) TRY(scene_pose(scene, o.camera, &scene->cache->pose, err));
    if (o.light_groups || o.light_group_names)
        TRY(light_groups_init(&groups, scene->scene, o.light_group_names, err));
    if (o.split_delta && groups.n == 0) TRY(one_group(&groups, scene->scene, err));
    TRY(planes_init(&planes, groups.n * (o.split_delta ? 2 : 1), err));
    TRY(add_plane(&planes, &window, 3, colour, &output.color, err));
    if (o.half_buffers) {
        TRY(add_plane(&planes, &window, 3, half_a, &output.half_a, err));
        TRY(add_plane(&planes, &window, 3, half_b, &output.half_b, err));
    }
    if (o.buffers)
        TRY(add_plane(&planes, &window, BUFFER_CHANNELS, buffer_channel_names, &output.buffers,
                      err));
    if (o.buffers && o.follow_delta)
        TRY(add_plane(&planes, &window, CHAIN_CHANNELS, chain_channel_names, &output.chain, err));
    if (groups.n) TRY(add_groups(&planes, &groups, o.split_delta, &window, &output, err));
    TRY(image_init(&image, window.width, window.height, planes.n_names, planes.names, err));
    TRY(scene_view(scene, err));
    view_set(scene->cache->view, scene->cache->u);
    if (o.camera) view_look_from(scene->cache->view, &scene->cache->pose);
    const double start_s = clock_wall_s();
    TRY(choose_integrator(context, scene, &o, &settings, &has_photons, err));
    TRY((has_photons ? view_trace_photons : view_trace_parallel)(
        scene->cache->view, context->pool, &settings, &window, &output, context->progress,
        context->progress_user, err));
    if (render_s) *render_s = clock_wall_s() - start_s;
    interleave(&planes, &image);
    TRY(describe_image(&image, scene, scene->cache->u, o.camera ? &scene->cache->pose : NULL,
                       settings.seed, settings.spp, err));
    TRY(image_set_attribute(&image, "integrator",
                            integrators[has_photons ? INTEGRATOR_PHOTONS : INTEGRATOR_PATH], err));
    TRY(image_handle(&image, out, err));
done:
    light_groups_release(&groups);
    planes_release(&planes);
    image_release(&image);
    return status;
}
