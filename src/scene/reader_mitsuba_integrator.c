/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "scene/reader_mitsuba_private.h"

/* The integrator. Methods differ in how they find light, not in what image they converge to: all
 * those that carry light along whole paths are read as `path`, with a note. */

enum role {
    ROLE_PATH,
    ROLE_DIRECT,
    ROLE_SAME_IMAGE,  /* another method for the same image */
    ROLE_PHOTONS,     /* the same, by photons */
    ROLE_VOLUME,      /* the same, where there are no media */
    ROLE_WRAPPER,     /* adds outputs or decides on samples around a nested one */
    ROLE_OTHER_IMAGE, /* known, not supported */
};

static const struct {
    const char *type;
    enum role role;
} plugins[] = {
    {"path", ROLE_PATH},
    {"direct", ROLE_DIRECT},
    {"aov", ROLE_WRAPPER},
    {"moment", ROLE_WRAPPER},
    {"adaptive", ROLE_WRAPPER}, /* 0.x */
    {"irrcache", ROLE_WRAPPER},
    {"multichannel", ROLE_WRAPPER},
    {"volpath", ROLE_VOLUME},
    {"volpathmis", ROLE_VOLUME},
    {"volpath_simple", ROLE_VOLUME}, /* 0.x */
    {"ptracer", ROLE_SAME_IMAGE},
    {"bdpt", ROLE_SAME_IMAGE},
    {"photonmapper", ROLE_PHOTONS},
    {"ppm", ROLE_PHOTONS},
    {"sppm", ROLE_PHOTONS},
    {"pssmlt", ROLE_SAME_IMAGE},
    {"mlt", ROLE_SAME_IMAGE},
    {"erpt", ROLE_SAME_IMAGE},
    {"vpl", ROLE_SAME_IMAGE},
    {"prb", ROLE_SAME_IMAGE},
    {"prb_basic", ROLE_SAME_IMAGE},
    {"prbvolpath", ROLE_VOLUME},
    {"direct_projective", ROLE_DIRECT},
    {"prb_projective", ROLE_SAME_IMAGE},
    {"depth", ROLE_OTHER_IMAGE},
    {"field", ROLE_OTHER_IMAGE},
    {"stokes", ROLE_OTHER_IMAGE},
    {"ao", ROLE_OTHER_IMAGE},
};
enum { N_PLUGINS = sizeof plugins / sizeof *plugins };

static lmn_status fail_integrator(struct reader *r, const struct xml_node *node, const char *type)
{
    const char *names[N_PLUGINS];
    for (size_t i = 0; i < N_PLUGINS; i++) names[i] = plugins[i].type;
    return fail_unknown(r, node, "unknown integrator", type, names, N_PLUGINS);
}

/* The nested integrator; of multichannel's several, the first that is a picture of the scene. */
static lmn_status load_nested(struct props *p)
{
    enum { MAX_DEPTH = 8 };
    lmn_status status = LMN_OK;
    struct reader *r = p->r;
    struct xml_node *child;
    bool has_one = false;
    TRY(props_object(p, EL_INTEGRATOR, &child));
    while (child) {
        const char *type = xml_attribute(child, "type");
        if (has_one || strcmp(type, "field") == 0) {
            note_ignored(r, child, "another integrator");
        } else {
            if (r->depth == MAX_DEPTH)
                return fail_node(r, child, "integrators are nested too deep");
            r->depth++;
            status = load_integrator(r, child);
            r->depth--;
            if (status != LMN_OK) return status;
            has_one = true;
        }
        TRY(props_object(p, EL_INTEGRATOR, &child));
    }
done:
    return status;
}

lmn_status load_integrator(struct reader *r, struct xml_node *node)
{
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    struct render_settings *s = &r->b->settings;
    size_t i = 0;
    while (i < N_PLUGINS && strcmp(p.type, plugins[i].type) != 0) i++;
    if (i == N_PLUGINS) return fail_integrator(r, node, p.type);
    switch (plugins[i].role) {
    case ROLE_OTHER_IMAGE:
        return fail_unsupported(r, node);
    case ROLE_WRAPPER:
        TRY(load_nested(&p));
        break;
    case ROLE_DIRECT:
        s->max_depth = 2; /* `direct` is `path` up to one bounce */
        break;
    case ROLE_PHOTONS:
        s->integrator = INTEGRATOR_PHOTONS; /* fall through */
    case ROLE_SAME_IMAGE:
    case ROLE_VOLUME: {
        char what[80];
        snprintf(what, sizeof what, "integrator \"%s\": taken as path%s", p.type,
                 plugins[i].role == ROLE_PHOTONS ? "+photons" : "");
        note_ignored(r, node, what);
    } /* fall through */
    case ROLE_PATH:
        TRY(props_integer(&p, "max_depth", -1, INT32_MAX, &s->max_depth));
        TRY(props_integer(&p, "rr_depth", 1, INT32_MAX, &s->rr_depth));
    }
    TRY(props_boolean(&p, "hide_emitters", &s->hide_emitters));
    if (plugins[i].role == ROLE_PATH) {
        /* Known ones only: a misspelled name should not pass. */
        static const char *const known[] = {
            "samples_per_pass", "block_size", "timeout", "strict_normals",
            "sample_num",       "delta",      "aovs",    "light_groups"};
        for (size_t k = 0; k < sizeof known / sizeof *known; k++) props_ignore(&p, known[k]);
    } else {
        props_ignore_rest(&p); /* settings of a method that is not used */
    }
    TRY(props_finish(&p, &object));
done:
    return status;
}
