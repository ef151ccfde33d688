/* SPDX-License-Identifier: Apache-2.0 */
#include "training.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Seconds after which late time has faded to a third. */
#define FADES_S 3.0

/* Between messages, and between the first points. */
#define TELLS_EVERY_S 0.5
#define FIRST_EVERY_S 0.25

bool training_init(struct training *t, lmn_trainer *trainer, uint32_t n_variables)
{
    lmn_train_options options;
    lmn_trainer_get_options(trainer, &options);
    *t = (struct training){.trainer = trainer,
                           .n_variables = n_variables,
                           .has_chains = options.method == LMN_METHOD_FAITHFUL,
                           .every_s = FIRST_EVERY_S,
                           .last_clock_s = hall_clock_s()};
    t->states = calloc((size_t)TOLD_STATES * n_variables + 1, sizeof *t->states);
    return t->states != NULL;
}

void training_release(struct training *t)
{
    free(t->states);
    *t = (struct training){0};
}

/* Every second point goes when there is no room, and later ones come half as often. */
static void add_point(struct training *t, double seconds)
{
    if (t->n_points == CURVE_POINTS) {
        for (uint32_t i = 0; i < CURVE_POINTS / 2; i++)
            memcpy(t->points[i], t->points[2 * i + 1], sizeof t->points[i]);
        t->n_points /= 2;
        t->every_s *= 2;
    }
    t->points[t->n_points][0] = seconds;
    t->points[t->n_points++][1] = t->loss_sum / t->n_losses;
    t->loss_sum = 0;
    t->n_losses = 0;
    t->next_s = seconds + t->every_s;
}

void training_note(struct training *t, const lmn_train_stats *stats, double view_s)
{
    const double now = hall_clock_s(), passed_s = now - t->last_clock_s;
    const double fading = exp(-passed_s / FADES_S);
    t->view_s = fading * t->view_s + view_s;
    t->all_s = fading * t->all_s + passed_s;
    t->steps = fading * t->steps + (double)(stats->step - t->last_step);
    t->last_clock_s = now;
    if (stats->step > t->last_step && isfinite(stats->loss)) {
        t->loss_sum += stats->loss;
        t->n_losses++;
    }
    if (t->last_step == 0) t->steps = 0; /* what a resumed training had made before */
    t->last_step = stats->step;
    if (t->n_losses > 0 && stats->cpu_s >= t->next_s) add_point(t, stats->cpu_s);
}

double training_view_share(const struct training *t)
{
    return t->all_s > 0 ? fmin(t->view_s / t->all_s, 1.0) : 0.0;
}

bool training_is_due(struct training *t)
{
    const double now = hall_clock_s();
    if (now - t->told_clock_s < TELLS_EVERY_S) return false;
    t->told_clock_s = now;
    return true;
}

char *training_text(struct training *t, const lmn_train_stats *stats, bool is_running,
                    bool is_whole)
{
    const struct training_state state = {
        .is_running = is_running,
        .step = stats->step,
        .n_configurations = stats->n_traced,
        .loss = stats->loss,
        .seconds = stats->cpu_s,
        .steps_per_s = is_running && t->all_s > 0 ? t->steps / t->all_s : 0.0,
        .view_share = training_view_share(t),
        .acceptance = t->has_chains ? stats->acceptance : (double)NAN,
        .reuse = t->has_chains ? stats->reuse_probability : (double)NAN,
        .n_points = t->n_points,
        .points = (const double(*)[2])t->points,
        .n_states = lmn_trainer_get_states(t->trainer, TOLD_STATES, t->states),
        .n_variables = t->n_variables,
        .states = t->states};
    return message_training(&state, is_whole);
}
