/* SPDX-License-Identifier: Apache-2.0 */
/* The sheet of bench learn: what the networks show at their end, beside references. */
#include "learn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { UNIFORM_ROWS = 3, HARD_ROWS = 5, TEXT = 2048 };

/* Everything to draw; images [n_rows][n_columns]: the reference, the methods' pictures, the
 * methods' error maps. */
struct sheet {
    const struct learn_results *results;
    const struct learn_scene *scene;
    uint32_t n_rows, n_columns;
    lmn_image **images; /* owned but the references */
    double *exposures;
    char (*captions)[TEXT];
    lmn_metrics *metrics; /* [n_rows][n_methods] */
};

/* Row r is of which set, and which configuration of it. */
static const struct learn_set *set_of(const struct sheet *s, uint32_t row, uint32_t *index)
{
    const struct learn_set *sets = s->scene->tests.sets;
    const uint32_t n = sets[LEARN_UNIFORM].n < UNIFORM_ROWS ? sets[LEARN_UNIFORM].n : UNIFORM_ROWS;
    *index = row < n ? row : row - n;
    return row < n ? &sets[LEARN_UNIFORM] : &sets[LEARN_HARD];
}

static bool sheet_init(struct sheet *s)
{
    const struct learn_set *sets = s->scene->tests.sets;
    const uint32_t n_methods = s->results->n_methods;
    s->n_rows = sets[LEARN_UNIFORM].n < UNIFORM_ROWS ? sets[LEARN_UNIFORM].n : UNIFORM_ROWS;
    s->n_rows += sets[LEARN_HARD].n < HARD_ROWS ? sets[LEARN_HARD].n : HARD_ROWS;
    s->n_columns = 1 + 2 * n_methods;
    s->images = calloc((size_t)s->n_rows * s->n_columns, sizeof *s->images);
    s->exposures = calloc(s->n_rows, sizeof *s->exposures);
    s->captions = calloc(s->n_rows, sizeof *s->captions);
    s->metrics = calloc((size_t)s->n_rows * n_methods, sizeof *s->metrics);
    for (uint32_t r = 0; s->images && s->exposures && r < s->n_rows; r++) {
        uint32_t index;
        const struct learn_set *set = set_of(s, r, &index);
        s->images[(size_t)r * s->n_columns] = set->references[index];
        s->exposures[r] = 1.0; /* until a comparison says better */
    }
    return s->images && s->exposures && s->captions && s->metrics;
}

static void sheet_release(struct sheet *s)
{
    for (uint32_t r = 0; s->images && r < s->n_rows; r++)
        for (uint32_t c = 1; c < s->n_columns; c++) lmn_image_free(s->images[r * s->n_columns + c]);
    free(s->images);
    free(s->exposures);
    free(s->captions);
    free(s->metrics);
}

static void model_path(const struct sheet *s, uint32_t method, char path[LEARN_PATH])
{
    learn_path(path, "%s/%s-%s-1.lmn", s->results->args->out, s->scene->name,
               s->results->methods[method].file);
}

static bool has_failed(const struct sheet *s, uint32_t method)
{
    return s->scene->curves[(size_t)method * s->results->args->seeds].failure != NULL;
}

/* Black columns for a training that came apart. */
static lmn_status leave_out(struct sheet *s, uint32_t method)
{
    const struct learn_tests *tests = &s->scene->tests;
    const uint32_t n_methods = s->results->n_methods;
    lmn_status status = LMN_OK;
    for (uint32_t r = 0; r < s->n_rows; r++) {
        lmn_image **picture = s->images + (size_t)r * s->n_columns + 1 + method;
        s->metrics[r * n_methods + method] = (lmn_metrics){.mape = INFINITY, .flip = INFINITY};
        for (uint32_t k = 0; k < 2 && status == LMN_OK; k++)
            status = lmn_image_new(s->results->app->context, tests->width, tests->height, 3, NULL,
                                   picture + k * n_methods);
    }
    return status;
}

/* Renders a column of pictures and one of maps by the model of the first seed. */
static lmn_status render_method(struct sheet *s, uint32_t method)
{
    lmn_context *context = s->results->app->context;
    const struct learn_tests *tests = &s->scene->tests;
    const lmn_render_options o = {
        .struct_size = sizeof o, .width = tests->width, .height = tests->height};
    char path[LEARN_PATH];
    lmn_model *model = NULL;
    model_path(s, method, path);
    lmn_status status = lmn_model_load(context, s->scene->scene, path, 0, &model);
    for (uint32_t r = 0; r < s->n_rows && status == LMN_OK; r++) {
        uint32_t index;
        const struct learn_set *set = set_of(s, r, &index);
        lmn_image **row = s->images + (size_t)r * s->n_columns;
        lmn_image **picture = row + 1 + method, **map = picture + s->results->n_methods;
        lmn_metrics *m = &s->metrics[r * s->results->n_methods + method];
        status = lmn_model_render(context, model, set->values + (size_t)index * tests->n_variables,
                                  &o, picture, NULL);
        if (status == LMN_OK) status = lmn_image_compare(context, *picture, row[0], m, map);
        if (status == LMN_OK) s->exposures[r] = m->exposure;
    }
    lmn_model_free(model);
    return status;
}

/* "hard 1  MAPE: faithful 0.1 improved 0.05  ..." and the values of the variables. */
static void write_caption(struct sheet *s, uint32_t r)
{
    static const struct {
        const char *name;
        size_t offset;
    } shown[] = {{"MAPE", offsetof(lmn_metrics, mape)}, {"FLIP", offsetof(lmn_metrics, flip)}};
    const struct learn_results *results = s->results;
    uint32_t index;
    const struct learn_set *set = set_of(s, r, &index);
    FILE *f = fmemopen(s->captions[r], TEXT, "w"); /* what does not fit is left out */
    if (!f) return;
    fprintf(f, "%s %u", learn_set_names[set - s->scene->tests.sets], index + 1);
    for (size_t k = 0; k < COUNT_OF(shown); k++) {
        fprintf(f, "  %s:", shown[k].name);
        for (uint32_t m = 0; m < results->n_methods; m++) {
            double value;
            memcpy(&value, (const char *)&s->metrics[r * results->n_methods + m] + shown[k].offset,
                   sizeof value);
            fprintf(f, " %s %.4f", results->methods[m].label, value);
        }
    }
    for (uint32_t i = 0; i < s->scene->tests.n_variables; i++) {
        lmn_variable_info v;
        if (lmn_scene_get_variable(s->scene->scene, i, &v) != LMN_OK) continue;
        fprintf(f, "%s%s %.3g", i ? "  " : "\n", v.name,
                set->values[(size_t)index * s->scene->tests.n_variables + i]);
    }
    fclose(f);
    s->captions[r][TEXT - 1] = '\0';
}

static lmn_status draw(const struct sheet *s, lmn_image **out)
{
    const char *headings[1 + 2 * LEARN_MAX_METHODS], *captions[UNIFORM_ROWS + HARD_ROWS];
    char maps[LEARN_MAX_METHODS][LEARN_NAME + 8];
    const uint32_t n_methods = s->results->n_methods;
    headings[0] = "path traced";
    for (uint32_t m = 0; m < n_methods; m++) {
        headings[1 + m] = s->results->methods[m].label;
        snprintf(maps[m], sizeof maps[m], "FLIP %s", s->results->methods[m].label);
        headings[1 + n_methods + m] = maps[m];
    }
    for (uint32_t r = 0; r < s->n_rows; r++) captions[r] = s->captions[r];
    const lmn_sheet sheet = {.struct_size = sizeof sheet,
                             .n_rows = s->n_rows,
                             .n_columns = s->n_columns,
                             .n_pictures = 1 + n_methods,
                             .images = (const lmn_image *const *)s->images,
                             .headings = headings,
                             .captions = captions,
                             .exposures = s->exposures};
    return lmn_image_sheet(s->results->app->context, &sheet, out);
}

int learn_sheet_save(const struct learn_results *r, const struct learn_scene *scene)
{
    struct sheet s = {.results = r, .scene = scene};
    lmn_image *out = NULL;
    char path[LEARN_PATH];
    lmn_status status = LMN_OK;
    for (uint32_t m = 0; m < r->n_methods; m++) {
        model_path(&s, m, path);
        if (access(path, R_OK) == 0 || has_failed(&s, m)) continue;
        app_say(r->app, "%s is no longer there: no sheet", path);
        return EXIT_OK;
    }
    int code = sheet_init(&s) ? EXIT_OK : app_error(r->app, EXIT_FAILED, "out of memory");
    r->app->is_silent = true;
    for (uint32_t m = 0; code == EXIT_OK && status == LMN_OK && m < r->n_methods; m++) {
        status = has_failed(&s, m) ? leave_out(&s, m) : render_method(&s, m);
    }
    r->app->is_silent = false;
    for (uint32_t row = 0; code == EXIT_OK && status == LMN_OK && row < s.n_rows; row++)
        write_caption(&s, row);
    if (code == EXIT_OK && status == LMN_OK) status = draw(&s, &out);
    learn_path(path, "%s/%s-sheet.png", r->args->out, scene->name);
    if (code == EXIT_OK && status == LMN_OK)
        status = lmn_image_save(r->app->context, out, path, "png", 1.0);
    if (status != LMN_OK) code = app_failed(r->app, status, BLAME_WORK);
    lmn_image_free(out);
    sheet_release(&s);
    return code;
}
