/* SPDX-License-Identifier: Apache-2.0 */
#include "train/memory.h"

#include <string.h>

#include "base/mem.h"
#include "train/sight.h"

enum { MOST_SLOTS = 1 << 24 };

lmn_status memory_init(struct memory *m, const struct memory_shape *shape, uint32_t mib,
                       uint32_t least, struct error *err)
{
    const size_t n = shape->n_pixels, n_colors = n * shape->n_lights * 3;
    const size_t each = shape->n_variables + n * SIGHT_KEPT + 2 * n_colors + n + 1;
    const uint64_t room = ((uint64_t)mib << 20) / (each * sizeof(float));
    *m = (struct memory){.shape = *shape,
                         .capacity = room < MOST_SLOTS ? (uint32_t)room : MOST_SLOTS};
    if (m->capacity < least)
        return fail(err, LMN_ERR_ARGUMENT,
                    "training option memory_mib = %u holds no %u configurations", mib, least);
    const struct {
        float **at;
        size_t count;
    } blocks[] = {{&m->u, shape->n_variables}, {&m->kept, n * SIGHT_KEPT}, {&m->targets, n_colors},
                  {&m->halves, n_colors},      {&m->weights, n},           {&m->errors, 1}};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) {
        *blocks[i].at = mem_new(m->capacity * blocks[i].count, sizeof(float));
        if (!*blocks[i].at && blocks[i].count > 0) {
            memory_release(m);
            return fail_memory(err, "the memory of pixels");
        }
    }
    m->size = (uint64_t)m->capacity * each * sizeof(float);
    return LMN_OK;
}

void memory_release(struct memory *m)
{
    float *const blocks[] = {m->u, m->kept, m->targets, m->halves, m->weights, m->errors};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) mem_free(blocks[i]);
    *m = (struct memory){0};
}

void memory_tensors(struct memory *m, struct tensor *out)
{
    const uint64_t held = memory_n_held(m), n = m->shape.n_pixels, n_lights = m->shape.n_lights;
    const struct tensor list[MEMORY_TENSORS] = {
        {"memory.u", TENSOR_F32, 2, {held, m->shape.n_variables}, m->u},
        {"memory.pixels", TENSOR_F32, 3, {held, n, SIGHT_KEPT}, m->kept},
        {"memory.targets", TENSOR_F32, 4, {held, n, n_lights, 3}, m->targets},
        {"memory.halves", TENSOR_F32, 4, {held, n, n_lights, 3}, m->halves},
        {"memory.weights", TENSOR_F32, 2, {held, n}, m->weights},
        {"memory.errors", TENSOR_F32, 1, {held}, m->errors},
    };
    memcpy(out, list, sizeof list);
}
