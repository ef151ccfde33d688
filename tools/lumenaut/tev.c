/* SPDX-License-Identifier: Apache-2.0 */
#include "tev.h"

#include <errno.h>
#include <netdb.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* Kinds of packets (IpcPacket::EType in its Ipc.h). */
enum { CREATE_IMAGE = 4, UPDATE_IMAGE = 6 };

enum { PART = 1 << 18 }; /* numbers of pixels in a packet */

/* A packet: its length in bytes, its kind, and so on, little-endian as every machine of ours. */
struct packet {
    char *bytes; /* owned; NULL: no memory */
    size_t size, capacity;
};

static void add(struct packet *p, const void *data, size_t size)
{
    if (!p->bytes || p->size + size > p->capacity) {
        const size_t capacity = 2 * (p->size + size) + 256;
        char *longer = realloc(p->bytes, capacity);
        if (!longer) free(p->bytes);
        p->bytes = longer;
        p->capacity = longer ? capacity : 0;
    }
    if (p->bytes) memcpy(p->bytes + p->size, data, size);
    p->size += size;
}

static void add_byte(struct packet *p, uint8_t x)
{
    add(p, &x, sizeof x);
}

static void add_int(struct packet *p, uint32_t x)
{
    add(p, &x, sizeof x);
}

static void add_text(struct packet *p, const char *text)
{
    add(p, text, strlen(text) + 1);
}

static void begin(struct packet *p, uint8_t kind, bool has_focus, const char *name)
{
    *p = (struct packet){0};
    add_int(p, 0);
    add_byte(p, kind);
    add_byte(p, has_focus);
    add_text(p, name);
}

/* Sends it and lets go of it. False with errno. */
static bool send_packet(int socket, struct packet *p)
{
    const uint32_t length = (uint32_t)p->size;
    bool is_sent = p->bytes != NULL;
    if (!is_sent) errno = ENOMEM;
    if (is_sent) memcpy(p->bytes, &length, sizeof length);
    for (size_t done = 0; is_sent && done < p->size;) {
        const ssize_t n = send(socket, p->bytes + done, p->size - done, MSG_NOSIGNAL);
        if (n > 0) done += (size_t)n;
        if (n < 0 && errno != EINTR) is_sent = false;
    }
    free(p->bytes);
    return is_sent;
}

/* "host:port", "host", ":port": to host, and where the port is. */
static const char *split(const char *address, char host[256])
{
    const char *colon = strrchr(address, ':');
    snprintf(host, 256, "%.*s", colon ? (int)(colon - address) : 255, address);
    if (!host[0]) snprintf(host, 256, "127.0.0.1");
    return colon ? colon + 1 : "14158";
}

int tev_open(struct tev *t, struct app *app, const char *address)
{
    char host[256];
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    struct addrinfo *list = NULL;
    *t = (struct tev){.socket = -1, .address = address};
    if (!address) return EXIT_OK;
    const char *port = split(address, host);
    const int failure = getaddrinfo(host, port, &hints, &list);
    if (failure != 0)
        return app_error(app, EXIT_USAGE, "--tev %s: %s", address, gai_strerror(failure));
    for (const struct addrinfo *a = list; a && t->socket < 0; a = a->ai_next) {
        t->socket = socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol);
        if (t->socket >= 0 && connect(t->socket, a->ai_addr, a->ai_addrlen) != 0) {
            const int why = errno;
            tev_close(t);
            errno = why;
        }
    }
    freeaddrinfo(list);
    if (t->socket >= 0) return EXIT_OK;
    return app_error(app, EXIT_FAILED, "--tev: no tev at %s, port %s: %s", host, port,
                     strerror(errno));
}

void tev_close(struct tev *t)
{
    if (t->socket >= 0) close(t->socket);
    t->socket = -1;
}

static void add_channels(struct packet *p, const lmn_image *image)
{
    const uint32_t n = lmn_image_n_channels(image);
    add_int(p, n);
    for (uint32_t c = 0; c < n; c++) add_text(p, lmn_image_channel_name(image, c));
}

static bool create(struct tev *t, const char *name, const lmn_image *image)
{
    struct packet p;
    t->width = lmn_image_width(image);
    t->height = lmn_image_height(image);
    t->n_channels = lmn_image_n_channels(image);
    begin(&p, CREATE_IMAGE, true, name);
    add_int(&p, t->width);
    add_int(&p, t->height);
    add_channels(&p, image);
    return send_packet(t->socket, &p);
}

/* Some rows. */
static bool update(const struct tev *t, const char *name, lmn_image *image, uint32_t row,
                   uint32_t n_rows)
{
    const size_t row_size = (size_t)t->width * t->n_channels;
    struct packet p;
    begin(&p, UPDATE_IMAGE, false, name);
    add_channels(&p, image);
    add_int(&p, 0);
    add_int(&p, row);
    add_int(&p, t->width);
    add_int(&p, n_rows);
    /* Where each channel begins, and how far its numbers are from each other. */
    for (int64_t c = 0; c < t->n_channels; c++) add(&p, &c, sizeof c);
    const int64_t stride = t->n_channels;
    for (uint32_t c = 0; c < t->n_channels; c++) add(&p, &stride, sizeof stride);
    add(&p, lmn_image_data(image) + row * row_size, n_rows * row_size * sizeof(float));
    return send_packet(t->socket, &p);
}

void tev_show(struct tev *t, struct app *app, const char *name, lmn_image *image)
{
    const uint32_t height = lmn_image_height(image), n = lmn_image_n_channels(image);
    if (t->socket < 0) return;
    const bool is_same = t->width == lmn_image_width(image) && t->height == height &&
                         t->n_channels == n;
    bool is_sent = is_same || create(t, name, image);
    uint32_t step = PART / (t->width * n);
    if (step < 1) step = 1;
    for (uint32_t row = 0; is_sent && row < height; row += step)
        is_sent = update(t, name, image, row, height - row < step ? height - row : step);
    if (is_sent) return;
    app_say(app, "note: tev has gone: %s", strerror(errno));
    tev_close(t);
}
