/* SPDX-License-Identifier: Apache-2.0 */
/* fuzz_messages [SECONDS [SEED]]: messages of the viewer's pages, spoilt at random. What is read
 * must be sound; under the sanitizers nothing else must happen. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "messages.h"

enum { N_VARIABLES = 3, MOST = 70000 };

static const char *const seeds[] = {
    "{\"type\":\"state\",\"version\":7,\"values\":[0.5,-1,1e3],\"camera\":{\"origin\":[1,2,3],"
    "\"target\":[0,0,0],\"up\":[0,1,0],\"fov\":40},\"layers\":[\"neural\",\"traced\",\"error\","
    "\"depth\"],\"width\":900,\"height\":600,\"exposure\":1.5,\"tone\":\"aces\",\"moving\":true,"
    "\"rate\":12,\"least\":0.25}",
    "{\"type\":\"state\",\"version\":4294967295,\"values\":[0,0,0],\"camera\":null,\"layers\":"
    "[\"albedo\"],\"width\":16,\"height\":4096,\"exposure\":1e-9,\"tone\":\"srgb\",\"moving\":"
    "false,"
    "\"rate\":60,\"least\":1}",
    "{\"type\":\"ack\",\"frame\":12}",
    "{\"type\":\"pixel\",\"id\":1,\"x\":100,\"y\":4095}",
    "{\"type\":\"capture\",\"id\":0,\"layer\":\"traced\",\"format\":\"exr\"}",
    "{\"type\":\"train\",\"action\":\"pause\"}",
    "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
    "{\"type\":\"\\ud800\\u0000\\uffff\"}",
};

static const char *const words[] = {"null",     "true",       "-1",    "1e999", "0.5",  "\"\"",
                                    "[]",       "{}",         "\"x\"", "9e9",   "\\u0", "\xff",
                                    "\"fov\":", "4294967296", ",",     ":"};

static uint64_t state;

/* xorshift64* */
static uint32_t draw(uint32_t n)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (uint32_t)((state * 0x2545f4914f6cdd1dull) >> 33) % n;
}

static size_t splice(char *text, size_t size, size_t at, const char *what, size_t n)
{
    if (size + n > MOST) return size;
    memmove(text + at + n, text + at, size - at);
    memcpy(text + at, what, n);
    return size + n;
}

static size_t spoil(char *text, size_t size)
{
    for (uint32_t k = 1 + draw(4); k > 0; k--) {
        const size_t at = size > 0 ? draw((uint32_t)size) : 0, rest = size - at;
        const char *word = words[draw(sizeof words / sizeof *words)];
        const size_t length = rest < 40 ? rest : draw(40);
        switch (draw(6)) {
        case 0:
            if (size > 0) text[at] = (char)draw(256);
            break;
        case 1: /* a piece is lost */
            memmove(text + at, text + at + length, rest - length);
            size -= length;
            break;
        case 2: /* a piece comes twice */
            size = splice(text, size, at, text + at, length);
            break;
        case 3:
            size = splice(text, size, at, word, strlen(word));
            break;
        case 4: /* cut short */
            if (draw(4) == 0) size = at;
            break;
        default: /* very deep, or very long */
            if (draw(200) == 0)
                for (int i = 0; i < 3000; i++) size = splice(text, size, at, "[", 1);
        }
    }
    return size;
}

static void demand(bool is_so, const char *what, const char *text, size_t size)
{
    if (is_so) return;
    fprintf(stderr, "%s: %.*s\n", what, (int)size, text);
    exit(1);
}

/* What a message that was read promises. */
static void check(const struct message *m, const char *text, size_t size)
{
    const struct wish *w = &m->wish;
    if (m->kind != MESSAGE_STATE) {
        demand(!w->values && m->x < HALL_SIDE_MAX && m->y < HALL_SIDE_MAX, "kind", text, size);
        return;
    }
    demand(w->values != NULL && w->version > 0, "values", text, size);
    for (int i = 0; i < N_VARIABLES; i++) demand(isfinite(w->values[i]), "value", text, size);
    demand(w->n_layers >= 1 && w->n_layers <= LAYERS, "layers", text, size);
    demand(w->width >= HALL_SIDE_MIN && w->width <= HALL_SIDE_MAX, "width", text, size);
    demand(w->height >= HALL_SIDE_MIN && w->height <= HALL_SIDE_MAX, "height", text, size);
    demand(w->exposure > 0 && isfinite(w->exposure) && w->tone <= 1, "exposure", text, size);
    demand(w->rate >= 1 && w->rate <= 60 && w->least >= 0.1 && w->least <= 1, "rate", text, size);
    for (int i = 0; i < 3; i++) demand(isfinite(w->camera.origin[i]), "camera", text, size);
}

int main(int argc, char **argv)
{
    static char text[MOST + 64];
    const struct message_rules rules = {N_VARIABLES, true, false, true, true};
    const double seconds = argc > 1 ? atof(argv[1]) : 2.0, start = hall_clock_s();
    uint64_t n = 0, n_read = 0;
    state = 88172645463325252ull + (argc > 2 ? strtoull(argv[2], NULL, 10) : 0);
    while (hall_clock_s() - start < seconds) {
        const char *seed = seeds[draw(sizeof seeds / sizeof *seeds)];
        char why[MESSAGE_WHY] = "";
        struct message m;
        size_t size = strlen(seed);
        memcpy(text, seed, size);
        if (n >= sizeof seeds / sizeof *seeds) size = spoil(text, size);
        if (message_read(text, size, &rules, &m, why)) {
            check(&m, text, size);
            n_read++;
        } else {
            demand(*why && strlen(why) < MESSAGE_WHY && !m.wish.values, "no reason", text, size);
        }
        free(m.wish.values);
        n++;
    }
    printf("%llu messages, %llu of them sound\n", (unsigned long long)n,
           (unsigned long long)n_read);
    return n_read > 0 && n_read < n ? 0 : 1;
}
