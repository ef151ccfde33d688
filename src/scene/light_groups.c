/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/light_groups.h"

#include <string.h>

#include "base/mem.h"

enum { MAX_NAME = LIGHT_GROUP_NAME };

/* ---- Names of emitters ----------------------------------------------------------------------- */

/* "lamp" of "lamp.scale": the path of an emitter's first parameter but for its last part. */
void emitter_name(struct str *text, const struct scene *s, uint32_t emitter)
{
    for (uint32_t i = 0; i < s->n_params; i++) {
        const struct param *p = &s->params[i];
        const char *dot = strrchr(p->path, '.');
        if (p->array != STATE_EMITTERS || p->index != emitter || !dot) continue;
        str_add(text, "%.*s", (int)(dot - p->path), p->path);
        return;
    }
    str_add(text, "emitter_%u", emitter);
}

/* The names of all emitters, in `text` and pointed to by names [n_emitters]. */
static lmn_status name_emitters(struct str *text, const struct scene *s, const char **names,
                                struct error *err)
{
    size_t *starts = mem_new((size_t)s->n_emitters + 1, sizeof *starts);
    for (uint32_t i = 0; starts && i < s->n_emitters; i++) {
        starts[i] = text->length;
        emitter_name(text, s, i);
        str_add_bytes(text, "", 1);
    }
    bool is_short = !starts || text->failed;
    for (uint32_t i = 0; !is_short && i < s->n_emitters; i++) names[i] = text->text + starts[i];
    mem_free(starts);
    return is_short ? fail_memory(err, "light groups") : LMN_OK;
}

/* Is `word` the emitter's name, or its shape's? */
static bool is_called(const char *name, const char *word)
{
    size_t n = strlen(word);
    return strncmp(name, word, n) == 0 && (name[n] == '\0' || strcmp(name + n, ".emitter") == 0);
}

/* ---- What the user says ---------------------------------------------------------------------- */

/* The next part of *text up to `end`, which is cut out; NULL at the end of the text. */
static char *cut(char **text, char end)
{
    char *part = *text, *at = part ? strchr(part, end) : NULL;
    *text = at ? at + 1 : NULL;
    if (at) *at = '\0';
    return part;
}

static lmn_status assign(const struct scene *s, const char *const *names, const char *group,
                         const char *word, const char **groups, struct error *err)
{
    uint32_t found = SCENE_NONE;
    for (uint32_t i = 0; i < s->n_emitters && found == SCENE_NONE; i++)
        if (is_called(names[i], word)) found = i;
    if (found == SCENE_NONE) {
        const char *closest = str_closest(word, names, s->n_emitters);
        return fail(err, LMN_ERR_ARGUMENT, "light group \"%s\": no emitter \"%s\"%s%s%s", group,
                    word, closest ? "; did you mean \"" : "", closest ? closest : "",
                    closest ? "\"?" : "");
    }
    if (groups[found] && strcmp(groups[found], group) != 0)
        return fail(err, LMN_ERR_ARGUMENT, "light group \"%s\": \"%s\" is in \"%s\" already", group,
                    word, groups[found]);
    groups[found] = group;
    return LMN_OK;
}

/* Fills in groups [n_emitters] from "a=x,y;b=z"; cuts `text` into pieces, which they point to. */
static lmn_status read_text(const struct scene *s, const char *const *names, char *text,
                            const char **groups, struct error *err)
{
    lmn_status status = LMN_OK;
    char *rest = text, *list;
    while ((list = cut(&rest, ';')) != NULL) {
        const char *group = cut(&list, '='), *word;
        if (!list || group[0] == '\0' || list[0] == '\0' || strlen(group) > MAX_NAME)
            return fail(err, LMN_ERR_ARGUMENT,
                        "light groups: \"%.60s\": expected NAME=EMITTER,EMITTER;NAME=...", group);
        while ((word = cut(&list, ',')) != NULL) TRY(assign(s, names, group, word, groups, err));
    }
done:
    return status;
}

/* ---- Groups ---------------------------------------------------------------------------------- */

/* Numbers the groups. An emitter by itself keeps its name, which no group may have. */
static lmn_status number(struct light_groups *g, const struct scene *s, const char *const *names,
                         const char *const *groups, struct error *err)
{
    for (uint32_t i = 0; i < s->n_emitters; i++) {
        uint32_t first = i; /* the first emitter of the group */
        for (uint32_t k = 0; k < i && first == i; k++) {
            const char *a = groups[i] ? groups[i] : names[i];
            const char *b = groups[k] ? groups[k] : names[k];
            if (strcmp(a, b) != 0) continue;
            if (!groups[i] || !groups[k])
                return fail(err, LMN_ERR_ARGUMENT,
                            "light group \"%s\": an emitter that is not in it has that name", a);
            first = k;
        }
        g->of[i] = first < i ? g->of[first] : g->n++;
        if (first == i) g->names[g->of[i]] = groups[i] ? groups[i] : names[i];
    }
    return LMN_OK;
}

/* Names that last as long as the groups: all in g->text. */
static lmn_status keep_names(struct light_groups *g, struct error *err)
{
    struct str text = {0};
    for (uint32_t i = 0; i < g->n; i++) {
        str_add(&text, "%s", g->names[i]);
        str_add_bytes(&text, "", 1);
    }
    if (text.failed) {
        str_release(&text);
        return fail_memory(err, "light groups");
    }
    const char *at = text.text;
    for (uint32_t i = 0; i < g->n; i++, at += strlen(at) + 1) g->names[i] = at;
    g->text = text;
    return LMN_OK;
}

lmn_status light_groups_init(struct light_groups *g, const struct scene *s, const char *text,
                             struct error *err)
{
    lmn_status status = LMN_OK;
    struct str own = {0};
    const size_t n = (size_t)s->n_emitters + 1;
    const char **names = mem_new(n, sizeof *names), **groups = mem_new(n, sizeof *groups);
    char *said = mem_strdup(text ? text : "");
    *g = (struct light_groups){.of = mem_new(n, sizeof *g->of),
                               .names = mem_new(n, sizeof *g->names)};
    if (!names || !groups || !said || !g->of || !g->names) {
        status = fail_memory(err, "light groups");
        goto done;
    }
    TRY(name_emitters(&own, s, names, err));
    if (said[0]) TRY(read_text(s, names, said, groups, err));
    for (uint32_t i = 0; s->light_groups && i < s->n_emitters; i++)
        if (!groups[i]) groups[i] = s->light_groups[i];
    TRY(number(g, s, names, groups, err));
    TRY(keep_names(g, err));
done:
    if (status != LMN_OK) light_groups_release(g);
    str_release(&own);
    mem_free(names);
    mem_free(groups);
    mem_free(said);
    return status;
}

void light_groups_release(struct light_groups *g)
{
    mem_free(g->of);
    mem_free(g->names);
    str_release(&g->text);
    *g = (struct light_groups){0};
}
