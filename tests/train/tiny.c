/* SPDX-License-Identifier: Apache-2.0 */
#include "tiny.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/cpu.h"
#include "base/file.h"
#include "base/mem.h"
#include "base/str.h"
#include "train/options.h"

static const char scene_xml[] =
    "<scene version=\"3.0.0\">\n"
    "  <integrator type=\"path\"><integer name=\"max_depth\" value=\"3\"/></integrator>\n"
    "  <sensor type=\"perspective\">\n"
    "    <float name=\"fov\" value=\"60\"/>\n"
    "    <transform name=\"to_world\">\n"
    "      <lookat origin=\"0, 1, 3\" target=\"0, 0.6, 0\" up=\"0, 1, 0\"/>\n"
    "    </transform>\n"
    "    <sampler type=\"independent\"><integer name=\"sample_count\" value=\"4\"/></sampler>\n"
    "    <film type=\"hdrfilm\">\n"
    "      <integer name=\"width\" value=\"48\"/><integer name=\"height\" value=\"32\"/>\n"
    "      <rfilter type=\"tent\"/>\n"
    "    </film>\n"
    "  </sensor>\n"
    "  <bsdf type=\"diffuse\" id=\"wall\">\n"
    "    <rgb name=\"reflectance\" value=\"0.6, 0.3, 0.2\"/>\n"
    "  </bsdf>\n"
    "  <bsdf type=\"roughconductor\" id=\"metal\"><float name=\"alpha\" value=\"0.3\"/></bsdf>\n"
    "  <shape type=\"rectangle\" id=\"back\">\n"
    "    <transform name=\"to_world\"><scale value=\"2\"/>"
    "<translate x=\"0\" y=\"1\" z=\"-1\"/></transform>\n"
    "    <ref id=\"wall\"/>\n"
    "  </shape>\n"
    "  <shape type=\"rectangle\" id=\"floor\">\n"
    "    <transform name=\"to_world\"><rotate x=\"1\" angle=\"-90\"/><scale value=\"2\"/>"
    "</transform>\n"
    "    <bsdf type=\"diffuse\"/>\n"
    "  </shape>\n"
    "  <shape type=\"sphere\" id=\"ball\">\n"
    "    <point name=\"center\" x=\"0\" y=\"0.5\" z=\"0\"/><float name=\"radius\" value=\"0.5\"/>\n"
    "    <ref id=\"metal\"/>\n"
    "  </shape>\n"
    "  <shape type=\"rectangle\" id=\"lamp\">\n"
    "    <transform name=\"to_world\"><rotate x=\"1\" angle=\"90\"/><scale value=\"0.5\"/>"
    "<translate x=\"0\" y=\"2.5\" z=\"0.5\"/></transform>\n"
    "    <bsdf type=\"diffuse\"/>\n"
    "    <emitter type=\"area\"><rgb name=\"radiance\" value=\"8, 7, 6\"/></emitter>\n"
    "  </shape>\n"
    "</scene>\n";

static const char variables_json[] =
    "{\"variables\": [\n"
    "  {\"name\": \"alpha\", \"kind\": \"float\", \"targets\": \"metal.alpha\",\n"
    "   \"range\": [0.1, 0.5], \"default\": 0.3},\n"
    "  {\"name\": \"ball\", \"kind\": \"translate\", \"targets\": \"ball\",\n"
    "   \"direction\": [1, 0, 0], \"range\": [-0.7, 0.7], \"default\": 0},\n"
    "  {\"name\": \"shown\", \"kind\": \"visible\", \"targets\": \"ball\", \"default\": true}\n"
    "]}\n";

static void need(lmn_status status, const struct error *err)
{
    if (status == LMN_OK) return;
    fprintf(stderr, "%s\n", err->text);
    abort();
}

static void write_text(const char *path, const char *text)
{
    FILE *f = fopen(path, "wb");
    if (!f || fputs(text, f) < 0 || fclose(f) != 0) abort();
}

static void load(struct tiny *t)
{
    struct error err = {0};
    const struct scene_load_options options = {0};
    need(scene_load(t->scene_path, &options, &t->scene, &err), &err);
    need(world_new(t->scene, cpu_detect(), &t->world, &err), &err);
    t->place.scene = t->scene;
    t->place.world = t->world;
}

void tiny_edit(struct tiny *t, const char *old, const char *new)
{
    const char *const paths[2] = {t->scene_path, t->variables_path};
    bool is_found = false;
    world_free(t->world);
    scene_free(t->scene);
    for (int i = 0; i < 2; i++) {
        size_t size;
        char *text = tiny_read(paths[i], &size), *at = strstr(text, old);
        struct str edited = {0};
        is_found |= at != NULL;
        if (at) {
            str_add_bytes(&edited, text, (size_t)(at - text));
            str_add(&edited, "%s%s", new, at + strlen(old));
            if (edited.failed) abort();
            write_text(paths[i], edited.text);
        }
        str_release(&edited);
        mem_free(text);
    }
    if (!is_found) abort();
    load(t);
}

void tiny_init(struct tiny *t, uint32_t n_threads)
{
    *t = (struct tiny){.folder = "/tmp/lmn-train-XXXXXX"};
    if (!mkdtemp(t->folder)) abort();
    snprintf(t->scene_path, sizeof t->scene_path, "%s/scene.xml", t->folder);
    snprintf(t->variables_path, sizeof t->variables_path, "%s/scene.variables.json", t->folder);
    write_text(t->scene_path, scene_xml);
    write_text(t->variables_path, variables_json);
    t->place = (struct workplace){.cpu = cpu_detect(), .scene_path = "scenes/tiny.xml"};
    load(t);
    tiny_set_threads(t, n_threads);
}

struct tiny tiny;

int tiny_setup(void **state)
{
    (void)state;
    tiny_init(&tiny, 2);
    return 0;
}

int tiny_teardown(void **state)
{
    (void)state;
    tiny_release(&tiny);
    return 0;
}

void tiny_set_threads(struct tiny *t, uint32_t n_threads)
{
    pool_free(t->pool);
    t->pool = pool_new(n_threads);
    if (!t->pool) abort();
    t->place.pool = t->pool;
}

void tiny_release(struct tiny *t)
{
    pool_free(t->pool);
    world_free(t->world);
    scene_free(t->scene);
    DIR *d = opendir(t->folder);
    for (struct dirent *e; d && (e = readdir(d));)
        if (e->d_name[0] != '.') unlink(tiny_path(t, e->d_name));
    if (d) closedir(d);
    rmdir(t->folder);
    *t = (struct tiny){0};
}

const char *tiny_path(const struct tiny *t, const char *name)
{
    static char paths[4][512];
    static unsigned next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", t->folder, name);
    return path;
}

lmn_train_options tiny_options(void)
{
    lmn_train_options o;
    options_init(&o);
    o.seed = 11;
    o.width = 16;
    o.depth = 1;
    o.learning_rate = 2e-3;
    o.n_chains = 4;
    o.reuse_warmup = 5;
    o.reuse_batch = 4;
    o.reuse_bias = 1; /* p_s near 0.73: both kinds of steps in a short run */
    o.replay_capacity = 50;
    o.patch_size = 16;
    o.resolution_start = 32;
    o.resolution_max = 48;
    o.resolution_every = 10;
    return o;
}

char *tiny_read(const char *path, size_t *size)
{
    struct error err = {0};
    char *bytes = NULL;
    need(file_read(path, 1u << 30, &bytes, size, &err), &err);
    return bytes;
}
