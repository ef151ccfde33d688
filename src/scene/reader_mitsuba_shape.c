/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "base/file.h"
#include "scene/mesh.h"
#include "scene/reader_mitsuba_private.h"

/* One function per shape: fills kind, mesh, to_world; may set *stem, what a shape without an id is
 * called. Defaults are Mitsuba 3's. */
typedef lmn_status shape_fn(struct props *p, struct builder_shape *s, const char **stem);

static const struct vec3 half = {0.5f, 0.5f, 0.5f}, black = {0, 0, 0};

/* ---- Meshes ------------------------------------------------------------------------------- */

static lmn_status add_mesh(struct props *p, const struct mesh *m, struct builder_shape *s)
{
    s->kind = SHAPE_MESH;
    return builder_add_mesh(p->r->b, m, &s->mesh, p->r->err);
}

/* "Mesh015" of "meshes/Mesh015.obj". */
static lmn_status stem_of(struct reader *r, const char *path, const char **out)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    char *copy = arena_strdup(&r->arena, name);
    if (!copy) return fail_memory(r->err, path);
    char *dot = strrchr(copy, '.');
    if (dot && dot != copy) *dot = '\0';
    *out = copy;
    return LMN_OK;
}

typedef lmn_status mesh_load_fn(const char *path, const char *text, size_t size,
                                const struct mesh_options *options, struct arena *arena,
                                struct mesh *out, struct error *err);

enum { MAX_MESH_FILE = 1 << 30 };

/* The bytes of a mesh file, which stay the reader's. */
static lmn_status read_bytes(struct reader *r, const char *path)
{
    lmn_status status = LMN_OK;
    if (r->mesh_text && strcmp(path, r->mesh_path) == 0) return LMN_OK;
    mem_free(r->mesh_text);
    r->mesh_text = NULL;
    TRY(file_read(path, MAX_MESH_FILE, &r->mesh_text, &r->mesh_size, r->err));
    r->mesh_path = path;
    builder_hash(r->b, r->mesh_text, r->mesh_size);
done:
    return status;
}

static lmn_status read_mesh_file(struct props *p, struct builder_shape *s, const char **stem,
                                 struct mesh_options options, mesh_load_fn *load)
{
    lmn_status status = LMN_OK;
    struct reader *r = p->r;
    const char *name = NULL, *path;
    struct mesh m;
    options.to_world = s->to_world;
    TRY(props_string(p, "filename", &name));
    if (!name) return fail_node(r, p->node, "%s needs a \"filename\"", p->type);
    TRY(props_boolean(p, "face_normals", &options.has_face_normals));
    TRY(props_boolean(p, "flip_tex_coords", &options.has_flipped_v));
    if (p->node->is_legacy) {
        static const char *const ignored[] = {"max_smooth_angle", "collapse", "load_materials",
                                              "srgb"};
        for (size_t i = 0; i < sizeof ignored / sizeof *ignored; i++) props_ignore(p, ignored[i]);
    }
    TRY(find_file(r, p->node, name, &path));
    TRY(read_bytes(r, path));
    TRY(load(path, r->mesh_text, r->mesh_size, &options, r->b->arena, &m, r->err));
    TRY(stem_of(r, path, stem));
    TRY(add_mesh(p, &m, s));
done:
    return status;
}

static lmn_status read_obj(struct props *p, struct builder_shape *s, const char **stem)
{
    return read_mesh_file(p, s, stem, (struct mesh_options){.has_flipped_v = true}, obj_load);
}

static lmn_status read_ply(struct props *p, struct builder_shape *s, const char **stem)
{
    return read_mesh_file(p, s, stem, (struct mesh_options){0}, ply_load);
}

static lmn_status read_serialized(struct props *p, struct builder_shape *s, const char **stem)
{
    int32_t index = 0;
    lmn_status status = props_integer(p, "shape_index", 0, INT32_MAX, &index);
    if (status != LMN_OK) return status;
    builder_hash(p->r->b, &index, sizeof index);
    struct mesh_options options = {.shape_index = (uint32_t)index};
    return read_mesh_file(p, s, stem, options, serialized_load);
}

static lmn_status read_rectangle(struct props *p, struct builder_shape *s, const char **stem)
{
    struct mesh m;
    lmn_status status = mesh_rectangle(&s->to_world, p->r->b->arena, &m, p->r->err);
    (void)stem;
    return status == LMN_OK ? add_mesh(p, &m, s) : status;
}

static lmn_status read_cube(struct props *p, struct builder_shape *s, const char **stem)
{
    struct mesh m;
    lmn_status status = mesh_cube(&s->to_world, p->r->b->arena, &m, p->r->err);
    (void)stem;
    return status == LMN_OK ? add_mesh(p, &m, s) : status;
}

/* ---- Spheres, disks, cylinders
 * -------------------------------------------------------------------- */

/* Rotation, uniform scale and perhaps a mirror: the columns are orthogonal and of one length. */
static bool is_similarity(const struct transform *t)
{
    struct vec3 c[3];
    for (int j = 0; j < 3; j++) c[j] = vec3(t->m[0][j], t->m[1][j], t->m[2][j]);
    float s = vec3_dot(c[0], c[0]), tolerance = 1e-3f * s;
    return fabsf(vec3_dot(c[1], c[1]) - s) <= tolerance &&
           fabsf(vec3_dot(c[2], c[2]) - s) <= tolerance &&
           fabsf(vec3_dot(c[0], c[1])) <= tolerance && fabsf(vec3_dot(c[0], c[2])) <= tolerance &&
           fabsf(vec3_dot(c[1], c[2])) <= tolerance;
}

static lmn_status read_sphere(struct props *p, struct builder_shape *s, const char **stem)
{
    lmn_status status = LMN_OK;
    struct vec3 centre = vec3(0, 0, 0);
    float radius = 1.0f;
    (void)stem;
    TRY(props_point(p, "center", &centre));
    TRY(props_positive(p, "radius", &radius));
    if (!is_similarity(&s->to_world))
        return fail_node(p->r, p->node, "a sphere that is scaled non-uniformly is not supported");
    struct transform move = transform_translate(centre);
    struct transform grow = transform_scale(vec3_splat(radius));
    grow = transform_mul(&move, &grow);
    s->kind = SHAPE_SPHERE;
    s->to_world = transform_mul(&s->to_world, &grow);
    /* A mirrored sphere is turned inside out, as Mitsuba has it. */
    if (transform_flips(&s->to_world)) s->flip_normals = !s->flip_normals;
    for (int i = 0; i < 12; i++) {
        if (!isfinite(s->to_world.m[i / 4][i % 4]) || !isfinite(s->to_world.inv[i / 4][i % 4]))
            return fail_node(p->r, p->node, "the sphere's radius is out of range");
    }
done:
    return status;
}

static lmn_status read_disk(struct props *p, struct builder_shape *s, const char **stem)
{
    (void)p;
    (void)stem;
    s->kind = SHAPE_DISK;
    return LMN_OK;
}

/* Columns at right angles, x and y of one length: circles about z stay circles. */
static bool keeps_round(const struct transform *t)
{
    struct vec3 c[3];
    for (int j = 0; j < 3; j++) c[j] = vec3(t->m[0][j], t->m[1][j], t->m[2][j]);
    float x = vec3_length(c[0]), y = vec3_length(c[1]), z = vec3_length(c[2]);
    return fabsf(x - y) <= 1e-3f * x && fabsf(vec3_dot(c[0], c[1])) <= 1e-3f * x * y &&
           fabsf(vec3_dot(c[0], c[2])) <= 1e-3f * x * z &&
           fabsf(vec3_dot(c[1], c[2])) <= 1e-3f * y * z;
}

static lmn_status read_cylinder(struct props *p, struct builder_shape *s, const char **stem)
{
    lmn_status status = LMN_OK;
    struct vec3 p0 = vec3(0, 0, 0), p1 = vec3(0, 0, 1);
    float radius = 1.0f;
    (void)stem;
    TRY(props_point(p, "p0", &p0));
    TRY(props_point(p, "p1", &p1));
    TRY(props_positive(p, "radius", &radius));
    struct vec3 axis = vec3_sub(p1, p0);
    float length = vec3_length(axis);
    if (!(length > 0.0f) || !isfinite(length))
        return fail_node(p->r, p->node, "the cylinder's ends \"p0\" and \"p1\" are equal");
    struct frame f = frame_from_normal(vec3_scale(axis, 1.0f / length));
    double m[16] = {f.s.x, f.t.x, f.n.x, p0.x, f.s.y, f.t.y, f.n.y, p0.y,
                    f.s.z, f.t.z, f.n.z, p0.z, 0,     0,     0,     1};
    struct transform place, grow = transform_scale(vec3(radius, radius, length));
    if (!transform_from_matrix(m, &place))
        return fail_node(p->r, p->node, "the cylinder is out of range");
    place = transform_mul(&place, &grow);
    s->kind = SHAPE_CYLINDER;
    s->to_world = transform_mul(&s->to_world, &place);
    for (int i = 0; i < 12; i++) {
        if (!(fabsf(s->to_world.m[i / 4][i % 4]) < 1e18f) ||
            !isfinite(s->to_world.inv[i / 4][i % 4]))
            return fail_node(p->r, p->node, "the cylinder is out of range");
    }
    if (!keeps_round(&s->to_world))
        return fail_node(p->r, p->node, "a cylinder that is no longer round is not supported");
done:
    return status;
}

/* ---- Table -------------------------------------------------------------------------------- */

static const struct {
    const char *type;
    shape_fn *read; /* NULL: known, not supported yet */
} plugins[] = {
    {"obj", read_obj},
    {"ply", read_ply},
    {"rectangle", read_rectangle},
    {"cube", read_cube},
    {"sphere", read_sphere},
    {"disk", read_disk},
    {"cylinder", read_cylinder},
    {"serialized", read_serialized},
    {"hair", NULL},
    {"bsplinecurve", NULL},
    {"linearcurve", NULL},
    {"sdfgrid", NULL},
    {"ellipsoids", NULL},
    {"ellipsoidsmesh", NULL},
    {"blender", NULL},
    {"heightfield", NULL},
    {"merge", NULL},
};
enum { N_PLUGINS = sizeof plugins / sizeof *plugins };

/* ---- Groups and instances ----------------------------------------------------------------- */

static lmn_status load_group(struct reader *r, struct xml_node *node, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    uint32_t shape, n = 0;
    for (struct xml_node *c = node->first_child; c; c = c->next) {
        if (c->element != EL_SHAPE) continue;
        const char *type = xml_attribute(c, "type");
        if (strcmp(type, "shapegroup") == 0 || strcmp(type, "instance") == 0)
            return fail_node(r, c, "a shapegroup cannot hold a %s", type);
        c->is_used = true;
        n++;
    }
    if (n == 0) return fail_node(r, node, "the shapegroup is empty");
    TRY(props_finish(&p, &object));
    TRY(builder_add_group(r->b, &object, index, r->err));
    node->kind = BUILDER_GROUP;
    for (struct xml_node *c = node->first_child; c; c = c->next) {
        if (c->element != EL_SHAPE) continue;
        if (c->load_state != LOAD_NOT_YET) return fail_node(r, c, "the shape is in use elsewhere");
        c->load_state = LOAD_NOW;
        TRY(load_shape(r, c, *index, &shape));
        c->index = shape;
        c->load_state = LOAD_DONE;
    }
done:
    return status;
}

static lmn_status load_instance(struct reader *r, struct xml_node *node, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_instance in = {.to_world = transform_identity()};
    struct xml_node *group;
    TRY(props_transform(&p, "to_world", &in.to_world));
    TRY(props_object(&p, EL_SHAPE, &group));
    if (!group || strcmp(xml_attribute(group, "type"), "shapegroup") != 0)
        return fail_node(r, node, "an instance needs a <ref> to a shapegroup");
    TRY(load_object(r, group));
    in.group = group->index;
    TRY(props_finish(&p, &in.object));
    node->kind = BUILDER_INSTANCE;
    TRY(builder_add_instance(r->b, &in, index, r->err));
done:
    return status;
}

/* ---- Shapes ------------------------------------------------------------------------------- */

/* The shape's material and light, nested or by reference. A light without a material reflects
 * nothing, another shape is grey. */
static lmn_status read_surface(struct props *p, struct builder_shape *s)
{
    lmn_status status = LMN_OK;
    struct reader *r = p->r;
    struct xml_node *node;
    s->bsdf = s->emitter = SCENE_NONE;
    TRY(props_object(p, EL_EMITTER, &node));
    if (node) {
        TRY(load_object(r, node));
        s->emitter = node->index;
    }
    TRY(props_object(p, EL_BSDF, &node));
    if (node) {
        TRY(load_object(r, node));
        s->bsdf = node->index;
    } else {
        struct builder_object object = {.place = p->node->place};
        struct bsdf f = bsdf_blank(BSDF_DIFFUSE);
        struct vec3 value = s->emitter == SCENE_NONE ? half : black;
        TRY(builder_add_constant(r->b, object.place, value, &f.reflectance, r->err));
        TRY(builder_add_bsdf(r->b, &object, &f, &s->bsdf, r->err));
    }
done:
    return status;
}

static const struct mesh_attribute *find_attribute(const struct mesh *m, uint64_t key)
{
    for (uint32_t i = 0; m && i < m->n_attributes; i++) {
        if (m->attributes[i].key == key) return &m->attributes[i];
    }
    return NULL;
}

/* All mesh attributes that the material asks for must be there. */
static lmn_status check_attributes(struct reader *r, const struct xml_node *node,
                                   const struct builder_shape *s, uint32_t bsdf, int depth)
{
    enum { MAX_DEPTH = 12 }; /* builder_finish() refuses deeper nesting */
    lmn_status status = LMN_OK;
    const struct bsdf *f = &r->b->bsdfs[bsdf].bsdf;
    const struct mesh *m = s->kind == SHAPE_MESH ? &r->b->meshes[s->mesh] : NULL;
    for (int i = 0; i < BSDF_TEXTURES; i++) {
        uint32_t t = bsdf_texture(f, i);
        if (t == SCENE_NONE || r->b->textures[t].texture.kind != TEXTURE_MESH_ATTRIBUTE) continue;
        if (find_attribute(m, r->b->textures[t].texture.attribute)) continue;
        return fail_node(r, node,
                         "the shape has no mesh attribute that its material asks for at line %u",
                         (unsigned)r->b->textures[t].object.place.line);
    }
    for (int i = 0; i < bsdf_n_children(f->kind) && depth < MAX_DEPTH; i++) {
        if (f->child[i] != SCENE_NONE) TRY(check_attributes(r, node, s, f->child[i], depth + 1));
    }
done:
    return status;
}

lmn_status load_shape(struct reader *r, struct xml_node *node, uint32_t group, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_shape s = {.mesh = SCENE_NONE, .to_world = transform_identity(), .group = group};
    const char *names[N_PLUGINS + 2], *stem = p.type;
    shape_fn *read = NULL;
    if (strcmp(p.type, "shapegroup") == 0) return load_group(r, node, index);
    if (strcmp(p.type, "instance") == 0) return load_instance(r, node, index);
    for (size_t i = 0; i < N_PLUGINS; i++) {
        names[i] = plugins[i].type;
        if (strcmp(p.type, plugins[i].type) != 0) continue;
        read = plugins[i].read;
        if (!read) return fail_unsupported(r, node);
    }
    names[N_PLUGINS] = "shapegroup";
    names[N_PLUGINS + 1] = "instance";
    if (!read) return fail_unknown(r, node, "unknown shape", p.type, names, N_PLUGINS + 2);
    TRY(props_transform(&p, "to_world", &s.to_world));
    TRY(props_boolean(&p, "flip_normals", &s.flip_normals));
    TRY(read(&p, &s, &stem));
    TRY(read_surface(&p, &s));
    if (r->has_mesh_attributes) TRY(check_attributes(r, node, &s, s.bsdf, 0));
    props_ignore(&p, "silhouette_sampling_weight");
    TRY(props_finish(&p, &s.object));
    node->kind = BUILDER_SHAPE;
    TRY(builder_add_shape(r->b, &s, stem, index, r->err));
done:
    return status;
}
