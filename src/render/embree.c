/* SPDX-License-Identifier: Apache-2.0 */
#include "render/embree.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/cpu.h"
#include "base/mem.h"
#include "render/quadric.h"
#include "render/view.h"

struct accel {
    const struct scene *scene;
    RTCDevice device;
    RTCScene *groups;         /* [n_groups] */
    struct quadric *quadrics; /* [n_shapes], unused for meshes */
    char message[256];        /* of Embree's last error */
};

struct accel_top {
    const struct accel *accel;
    RTCScene scene;         /* what rays are cast into */
    RTCScene top;           /* NULL: `scene` is the first group's */
    RTCGeometry *instances; /* [n_instances] */
    bool *is_enabled;       /* [n_instances] */
    bool has_instances;
};

static void on_error(void *user, enum RTCError code, const char *text)
{
    struct accel *a = user;
    (void)code;
    snprintf(a->message, sizeof a->message, "%s", text ? text : "unknown error");
}

/* ---- Quadrics ------------------------------------------------------------------------------ */

static void on_bounds(const struct RTCBoundsFunctionArguments *args)
{
    float low[3], high[3];
    struct RTCBounds *b = args->bounds_o;
    quadric_bounds(args->geometryUserPtr, low, high);
    b->lower_x = low[0];
    b->lower_y = low[1];
    b->lower_z = low[2];
    b->upper_x = high[0];
    b->upper_y = high[1];
    b->upper_z = high[2];
}

/* Embree hands over packets of N rays as arrays of fields; C has no accessors of its own. */
enum ray_field { ORG_X, TNEAR = 3, DIR_X = 4, TFAR = 8, RAY_FIELDS = 12 };
enum hit_field { NG_X, HIT_U = 3, HIT_V, PRIM_ID, GEOM_ID, INST_ID };

static struct quadric_ray ray_get(const void *rays, unsigned n, unsigned i)
{
    const float *f = (const float *)rays + i;
    struct quadric_ray q = {.t_min = f[TNEAR * n], .t_max = f[TFAR * n]};
    for (unsigned k = 0; k < 3; k++) {
        q.o[k] = f[(ORG_X + k) * n];
        q.d[k] = f[(DIR_X + k) * n];
    }
    return q;
}

static void on_intersect(const struct RTCIntersectFunctionNArguments *args)
{
    const struct quadric *q = args->geometryUserPtr;
    const unsigned n = args->N;
    float *rays = (float *)args->rayhit;
    for (unsigned i = 0; i < n; i++) {
        if (args->valid[i] != -1) continue;
        struct quadric_ray r = ray_get(rays, n, i);
        double t;
        if (!quadric_hit(q, &r, &t)) continue;
        float *hit = rays + (size_t)RAY_FIELDS * n + i;
        uint32_t *ids = (uint32_t *)args->rayhit + (size_t)RAY_FIELDS * n + i;
        rays[TFAR * n + i] = (float)t;
        float normal[3];
        quadric_normal(q, &r, t, normal);
        for (unsigned k = 0; k < 3; k++) hit[(NG_X + k) * n] = normal[k];
        hit[HIT_U * n] = hit[HIT_V * n] = 0.0f;
        ids[PRIM_ID * n] = 0;
        ids[GEOM_ID * n] = args->geomID;
        ids[INST_ID * n] = args->context->instID[0];
    }
}

static void on_occluded(const struct RTCOccludedFunctionNArguments *args)
{
    const struct quadric *q = args->geometryUserPtr;
    const unsigned n = args->N;
    float *rays = (float *)args->ray;
    for (unsigned i = 0; i < n; i++) {
        if (args->valid[i] != -1) continue;
        struct quadric_ray r = ray_get(rays, n, i);
        double t;
        if (quadric_hit(q, &r, &t)) rays[TFAR * n + i] = -INFINITY;
    }
}

/* ---- Bottom levels --------------------------------------------------------------------------- */

static RTCGeometry mesh_geometry(RTCDevice device, const struct mesh *m)
{
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!g) return NULL;
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, m->positions, 0,
                               3 * sizeof(float), m->n_vertices);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m->indices, 0,
                               3 * sizeof(uint32_t), m->n_triangles);
    return g;
}

static RTCGeometry quadric_geometry(RTCDevice device, const struct shape *s, struct quadric *q)
{
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (!g) return NULL;
    quadric_init(q, s);
    rtcSetGeometryUserPrimitiveCount(g, 1);
    rtcSetGeometryUserData(g, q);
    rtcSetGeometryBoundsFunction(g, on_bounds, NULL);
    rtcSetGeometryIntersectFunction(g, on_intersect);
    rtcSetGeometryOccludedFunction(g, on_occluded);
    return g;
}

static lmn_status build_group(struct accel *a, uint32_t index, struct error *err)
{
    const struct group *group = &a->scene->groups[index];
    RTCScene s = a->groups[index] = rtcNewScene(a->device);
    if (!s) return fail_memory(err, "ray acceleration");
    rtcSetSceneBuildQuality(s, RTC_BUILD_QUALITY_HIGH);
    for (uint32_t i = 0; i < group->n_shapes; i++) {
        const struct shape *shape = &a->scene->shapes[group->first_shape + i];
        bool is_mesh = shape->kind == SHAPE_MESH;
        /* An empty mesh has no buffers to share; its number stays unused. */
        if (is_mesh && a->scene->meshes[shape->mesh].n_triangles == 0) continue;
        RTCGeometry g = is_mesh ? mesh_geometry(a->device, &a->scene->meshes[shape->mesh])
                                : quadric_geometry(a->device, shape,
                                                   &a->quadrics[group->first_shape + i]);
        if (!g) return fail_memory(err, "ray acceleration");
        rtcCommitGeometry(g);
        rtcAttachGeometryByID(s, g, i);
        rtcReleaseGeometry(g);
    }
    rtcCommitScene(s);
    if (a->message[0])
        return fail(err, LMN_ERR_MEMORY, "ray acceleration of \"%s\": %s", group->name, a->message);
    return LMN_OK;
}

lmn_status accel_new(const struct scene *scene, uint32_t cpu, struct accel **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct accel *a = mem_new(1, sizeof *a);
    *out = NULL;
    if (!a) return fail_memory(err, "ray acceleration");
    a->scene = scene;
    a->groups = mem_new(scene->n_groups, sizeof *a->groups);
    a->quadrics = mem_new(scene->n_shapes, sizeof *a->quadrics);
    /* Triangles in fours under an eight-wide tree: on veach-ajar a quarter faster than what Embree
     * chooses by itself. It needs AVX. */
    a->device = rtcNewDevice(cpu & CPU_AVX2 ? "threads=1,tri_accel=bvh8.triangle4" : "threads=1");
    if (!a->device) {
        status = fail(err, LMN_ERR_DEVICE, "cannot start Embree (error %d)",
                      (int)rtcGetDeviceError(NULL));
        goto done;
    }
    rtcSetDeviceErrorFunction(a->device, on_error, a);
    if ((!a->groups && scene->n_groups) || (!a->quadrics && scene->n_shapes)) {
        status = fail_memory(err, "ray acceleration");
        goto done;
    }
    for (uint32_t i = 0; i < scene->n_groups; i++) TRY(build_group(a, i, err));
    *out = a;
    a = NULL;
done:
    accel_free(a);
    return status;
}

void accel_free(struct accel *a)
{
    if (!a) return;
    for (uint32_t i = 0; a->groups && i < a->scene->n_groups; i++)
        if (a->groups[i]) rtcReleaseScene(a->groups[i]);
    if (a->device) rtcReleaseDevice(a->device);
    mem_free(a->groups);
    mem_free(a->quadrics);
    mem_free(a);
}

/* ---- Top level ------------------------------------------------------------------------------- */

lmn_status accel_top_new(const struct accel *a, struct accel_top **out, struct error *err)
{
    const struct scene *s = a->scene;
    lmn_status status = LMN_OK;
    struct accel_top *t = mem_new(1, sizeof *t);
    *out = NULL;
    if (!t) return fail_memory(err, "top level");
    t->accel = a;
    if (s->n_instances == 1) {
        t->scene = a->groups[s->defaults.instances[0].group];
        *out = t;
        return LMN_OK;
    }
    t->has_instances = true;
    t->instances = mem_new(s->n_instances, sizeof *t->instances);
    t->is_enabled = mem_new(s->n_instances, sizeof *t->is_enabled);
    t->scene = t->top = rtcNewScene(a->device);
    if ((!t->instances && s->n_instances) || (!t->is_enabled && s->n_instances) || !t->top) {
        status = fail_memory(err, "top level");
        goto done;
    }
    rtcSetSceneFlags(t->top, RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(t->top, RTC_BUILD_QUALITY_LOW);
    for (uint32_t i = 0; i < s->n_instances; i++) {
        RTCGeometry g = rtcNewGeometry(a->device, RTC_GEOMETRY_TYPE_INSTANCE);
        if (!g) {
            status = fail_memory(err, "top level");
            goto done;
        }
        t->instances[i] = g;
        t->is_enabled[i] = true;
        rtcSetGeometryInstancedScene(g, a->groups[s->defaults.instances[i].group]);
        rtcSetGeometryTimeStepCount(g, 1);
        rtcAttachGeometryByID(t->top, g, i);
        accel_top_set_instance(t, i, &s->defaults.instances[i].to_world,
                               s->defaults.instances[i].is_visible);
    }
    *out = t;
    t = NULL;
done:
    accel_top_free(t);
    return status;
}

void accel_top_free(struct accel_top *t)
{
    if (!t) return;
    for (uint32_t i = 0; t->instances && i < t->accel->scene->n_instances; i++)
        if (t->instances[i]) rtcReleaseGeometry(t->instances[i]);
    if (t->top) rtcReleaseScene(t->top);
    mem_free(t->instances);
    mem_free(t->is_enabled);
    mem_free(t);
}

void accel_top_set_instance(struct accel_top *t, uint32_t instance,
                            const struct transform *to_world, bool is_visible)
{
    if (!t->has_instances) return;
    RTCGeometry g = t->instances[instance];
    rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, to_world->m);
    if (is_visible != t->is_enabled[instance]) {
        if (is_visible)
            rtcEnableGeometry(g);
        else
            rtcDisableGeometry(g);
        t->is_enabled[instance] = is_visible;
    }
    rtcCommitGeometry(g);
}

void accel_top_commit(struct accel_top *t)
{
    if (t->top) rtcCommitScene(t->top);
}

/* ---- Rays ------------------------------------------------------------------------------------ */

void accel_intersect(const struct accel_top *t, const struct ray *r, struct hit *hit)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRayHit rh;
    rh.ray = (struct RTCRay){.org_x = r->o.x,
                             .org_y = r->o.y,
                             .org_z = r->o.z,
                             .tnear = r->t_min,
                             .dir_x = r->d.x,
                             .dir_y = r->d.y,
                             .dir_z = r->d.z,
                             .tfar = r->t_max,
                             .mask = UINT32_MAX};
    rh.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rh.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(t->scene, &context, &rh);
    hit->t = rh.ray.tfar;
    if (rh.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
        hit->shape = SCENE_NONE;
        return;
    }
    hit->u = rh.hit.u;
    hit->v = rh.hit.v;
    hit->ng = vec3(rh.hit.Ng_x, rh.hit.Ng_y, rh.hit.Ng_z);
    hit->shape = rh.hit.geomID;
    hit->primitive = rh.hit.primID;
    hit->instance = t->has_instances ? rh.hit.instID[0] : 0;
}

bool accel_occluded(const struct accel_top *t, const struct ray *r)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRay ray = {.org_x = r->o.x,
                         .org_y = r->o.y,
                         .org_z = r->o.z,
                         .tnear = r->t_min,
                         .dir_x = r->d.x,
                         .dir_y = r->d.y,
                         .dir_z = r->d.z,
                         .tfar = r->t_max,
                         .mask = UINT32_MAX};
    rtcOccluded1(t->scene, &context, &ray);
    return ray.tfar < 0.0f;
}

static struct ray ray_of_lane(const struct accel_rays *r, uint32_t i)
{
    return (struct ray){vec3(r->o[0][i], r->o[1][i], r->o[2][i]), 0.0f,
                        vec3(r->d[0][i], r->d[1][i], r->d[2][i]), r->t_max[i]};
}

/* Fills a packet; lanes from n on are not valid, but hold numbers that do no harm. */
static void packet_init(struct RTCRay16 *to, int *valid, const struct accel_rays *r,
                        const uint32_t *lanes, uint32_t n)
{
    uint32_t from[ACCEL_PACKET];
    for (uint32_t i = 0; i < ACCEL_PACKET; i++) from[i] = lanes[i < n ? i : 0];
    for (uint32_t i = 0; i < ACCEL_PACKET; i++) {
        uint32_t k = from[i];
        valid[i] = i < n ? -1 : 0;
        to->org_x[i] = r->o[0][k];
        to->org_y[i] = r->o[1][k];
        to->org_z[i] = r->o[2][k];
        to->tnear[i] = 0.0f;
        to->dir_x[i] = r->d[0][k];
        to->dir_y[i] = r->d[1][k];
        to->dir_z[i] = r->d[2][k];
        to->tfar[i] = r->t_max[k];
        to->time[i] = 0.0f;
        to->mask[i] = UINT32_MAX;
        to->id[i] = i;
        to->flags[i] = 0;
    }
}

/* Embree's flag for coherent rays, that is traversal by their frustum, is for primary rays alone,
 * where it saves more than half of the time. It pays for no others, and that for shadow rays never
 * comes back where some rays of a packet are occluded and some are not: Embree 3.13.5 takes only
 * those that are not off the list of rays to trace (test_path's area_light shows it). The search
 * for the closest hit takes all of them off. */
void accel_intersect_packet(const struct accel_top *t, const struct accel_rays *rays,
                            const uint32_t *lanes, uint32_t n, bool is_coherent, struct hit *hits)
{
    if (n < 4) { /* does not pay */
        for (uint32_t i = 0; i < n; i++) {
            struct ray r = ray_of_lane(rays, lanes[i]);
            accel_intersect(t, &r, &hits[lanes[i]]);
        }
        return;
    }
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (is_coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    struct RTCRayHit16 rh;
    _Alignas(64) int valid[ACCEL_PACKET];
    packet_init(&rh.ray, valid, rays, lanes, n);
    for (uint32_t i = 0; i < ACCEL_PACKET; i++)
        rh.hit.geomID[i] = rh.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect16(valid, t->scene, &context, &rh);
    for (uint32_t i = 0; i < n; i++) {
        struct hit *hit = &hits[lanes[i]];
        hit->t = rh.ray.tfar[i];
        if (rh.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
            hit->shape = SCENE_NONE;
            continue;
        }
        hit->u = rh.hit.u[i];
        hit->v = rh.hit.v[i];
        hit->ng = vec3(rh.hit.Ng_x[i], rh.hit.Ng_y[i], rh.hit.Ng_z[i]);
        hit->shape = rh.hit.geomID[i];
        hit->primitive = rh.hit.primID[i];
        hit->instance = t->has_instances ? rh.hit.instID[0][i] : 0;
    }
}

void accel_occluded_packet(const struct accel_top *t, const struct accel_rays *rays,
                           const uint32_t *lanes, uint32_t n, bool *is_occluded)
{
    if (n < 4) {
        for (uint32_t i = 0; i < n; i++) {
            struct ray r = ray_of_lane(rays, lanes[i]);
            is_occluded[lanes[i]] = accel_occluded(t, &r);
        }
        return;
    }
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRay16 packet;
    _Alignas(64) int valid[ACCEL_PACKET];
    packet_init(&packet, valid, rays, lanes, n);
    rtcOccluded16(valid, t->scene, &context, &packet);
    for (uint32_t i = 0; i < n; i++) is_occluded[lanes[i]] = packet.tfar[i] < 0.0f;
}

const char *embree_version(void)
{
    return RTC_VERSION_STRING;
}
