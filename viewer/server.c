/* SPDX-License-Identifier: Apache-2.0 */
#include "server.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <libwebsockets.h>

#include "assets.h"
#include "encode.h"

_Static_assert((int)PARCEL_ROOM >= LWS_PRE, "room for the library before each message");

enum {
    CHUNK = 16384,         /* of a file, at a time */
    ERRORS_MAX = 20,       /* bad messages of a session */
    MESSAGES_PER_S = 2000, /* of a session */
    PATIENCE_S = 30,       /* for an acknowledgement */
    PATIENCE_LOOKED_AT_S = 2,
    PORTS_TRIED = 20,
    LOOK_AROUND_MS = 200 /* whether to stop */
};

#define PROTOCOL_NAME "lumenaut-1"

/* What a browser may do with the page: nothing from elsewhere, no frame around it. */
#define POLICY                                                                      \
    "default-src 'self'; img-src 'self' blob: data:; connect-src 'self'; base-uri " \
    "'none'; form-action 'none'; frame-ancestors 'none'"

/* A connection; the library's memory, zeroed. */
struct seat {
    const struct asset *asset; /* being sent */
    size_t sent;
    struct session *session; /* of a WebSocket */
    char *message;           /* received so far, owned */
    size_t message_size;
    uint32_t n_errors, n_messages;
    double second_began_s;
};

struct server {
    const struct viewer_options *options;
    struct message_rules rules;
    struct hall *hall;
    char *hello;
    struct lws_context *context;
    uint16_t port;
    lws_sorted_usec_list_t tick;
};

static struct server *server_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

/* ---- Who may come in ------------------------------------------------------------------------- */

/* A name without its port. */
static void cut_port(char *host)
{
    char *end = host[0] == '[' ? strchr(host, ']') : strchr(host, ':');
    if (end && host[0] == '[') end++;
    if (end) *end = '\0';
}

/* With a token it is the token that counts: a machine has many names, and proxies have others. */
static bool is_host_ours(const struct server *s, struct lws *wsi)
{
    static const char *const names[] = {"localhost", "127.0.0.1", "[::1]"};
    char host[256];
    if (lws_hdr_copy(wsi, host, sizeof host, WSI_TOKEN_HOST) <= 0) return false;
    if (s->options->token) return true;
    cut_port(host);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcasecmp(host, names[i]) == 0) return true;
    return strcasecmp(host, s->options->bind) == 0;
}

/* Programs send no Origin; browsers do, and pages cannot change it. */
static bool is_origin_ours(struct lws *wsi)
{
    char origin[300], host[256];
    const int n = lws_hdr_copy(wsi, origin, sizeof origin, WSI_TOKEN_ORIGIN);
    if (n == 0) return true;
    if (n < 0 || lws_hdr_copy(wsi, host, sizeof host, WSI_TOKEN_HOST) <= 0) return false;
    const char *name = strstr(origin, "://");
    return name && strcasecmp(name + 3, host) == 0;
}

/* Takes the same time wherever the texts differ. */
static bool is_token_right(const struct server *s, struct lws *wsi)
{
    char given[256] = "";
    unsigned difference = 0;
    const char *token = s->options->token;
    if (!token) return true;
    const char *value = lws_get_urlarg_by_name(wsi, "token=", given, sizeof given);
    if (!value || strlen(value) != strlen(token)) return false;
    for (size_t i = 0; token[i]; i++) difference |= (unsigned)(token[i] ^ value[i]);
    return difference == 0;
}

static bool may_connect(const struct server *s, struct lws *wsi)
{
    char path[64];
    const int n = lws_hdr_copy(wsi, path, sizeof path, WSI_TOKEN_GET_URI);
    return n > 0 && strcmp(path, "/socket") == 0 && is_host_ours(s, wsi) && is_origin_ours(wsi) &&
           is_token_right(s, wsi);
}

/* ---- Files ----------------------------------------------------------------------------------- */

static int answer(struct lws *wsi, unsigned code)
{
    lws_return_http_status(wsi, code, NULL);
    return -1;
}

static bool add_header(struct lws *wsi, const char *name, const char *value, unsigned char **p,
                       unsigned char *end)
{
    return lws_add_http_header_by_name(wsi, (const unsigned char *)name,
                                       (const unsigned char *)value, (int)strlen(value), p,
                                       end) == 0;
}

static int begin_file(struct server *s, struct lws *wsi, struct seat *seat, const char *path)
{
    unsigned char buffer[LWS_PRE + 2048], *const start = buffer + LWS_PRE, *p = start;
    unsigned char *const end = buffer + sizeof buffer - 1;
    if (!is_host_ours(s, wsi)) return answer(wsi, HTTP_STATUS_FORBIDDEN);
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0)
        return answer(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED);
    seat->asset = NULL;
    seat->sent = 0;
    for (size_t i = 0; i < n_assets && !seat->asset; i++)
        if (strcmp(assets[i].path, path) == 0) seat->asset = &assets[i];
    if (!seat->asset) return answer(wsi, HTTP_STATUS_NOT_FOUND);
    if (lws_add_http_common_headers(wsi, HTTP_STATUS_OK, seat->asset->type, seat->asset->size, &p,
                                    end) != 0 ||
        !add_header(wsi, "content-security-policy:", POLICY, &p, end) ||
        !add_header(wsi, "x-content-type-options:", "nosniff", &p, end) ||
        !add_header(wsi, "referrer-policy:", "no-referrer", &p, end) ||
        !add_header(wsi, "cache-control:", "no-cache", &p, end) ||
        lws_finalize_write_http_header(wsi, start, &p, end) != 0)
        return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

static int go_on_file(struct lws *wsi, struct seat *seat)
{
    unsigned char buffer[LWS_PRE + CHUNK];
    if (!seat->asset) return -1;
    const size_t rest = seat->asset->size - seat->sent, n = rest < CHUNK ? rest : CHUNK;
    memcpy(buffer + LWS_PRE, seat->asset->bytes + seat->sent, n);
    if (lws_write(wsi, buffer + LWS_PRE, n, n == rest ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0)
        return -1;
    seat->sent += n;
    if (n == rest) return lws_http_transaction_completed(wsi) ? -1 : 0;
    lws_callback_on_writable(wsi);
    return 0;
}

static int on_http(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in,
                   size_t size)
{
    struct server *s = server_of(wsi);
    (void)size;
    switch (reason) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: /* a WebSocket of no subprotocol, or another */
        return answer(wsi, HTTP_STATUS_FORBIDDEN);
    case LWS_CALLBACK_HTTP:
        return begin_file(s, wsi, user, in);
    case LWS_CALLBACK_HTTP_WRITEABLE:
        return go_on_file(wsi, user);
    default:
        return 0;
    }
}

/* ---- Sockets --------------------------------------------------------------------------------- */

static int close_for(struct lws *wsi, enum lws_close_status status, const char *why)
{
    lws_close_reason(wsi, status, (unsigned char *)why, strlen(why));
    return -1;
}

static int begin_session(struct server *s, struct lws *wsi, struct seat *seat)
{
    seat->session = hall_enter(s->hall);
    if (!seat->session)
        return close_for(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, "too many pages watch");
    hall_send_text(s->hall, seat->session, strdup(s->hello));
    lws_callback_on_writable(wsi);
    lws_set_timer_usecs(wsi, PATIENCE_LOOKED_AT_S * LWS_USEC_PER_SEC);
    return 0;
}

static int send_next(struct server *s, struct lws *wsi, struct seat *seat)
{
    struct outgoing out;
    int n = 0;
    if (!seat->session || !hall_next_outgoing(s->hall, seat->session, &out)) return 0;
    if (out.text) {
        const size_t size = strlen(out.text);
        unsigned char *buffer = malloc(LWS_PRE + size);
        if (buffer) {
            memcpy(buffer + LWS_PRE, out.text, size);
            n = lws_write(wsi, buffer + LWS_PRE, size, LWS_WRITE_TEXT);
        }
        free(buffer);
        free(out.text);
    } else {
        n = lws_write(wsi, out.parcel.memory + PARCEL_ROOM, out.parcel.size, LWS_WRITE_BINARY);
        free(out.parcel.memory);
    }
    if (n < 0) return -1;
    lws_callback_on_writable(wsi); /* there may be more */
    return 0;
}

static int refuse(struct server *s, struct lws *wsi, struct seat *seat, const char *why)
{
    if (++seat->n_errors > ERRORS_MAX)
        return close_for(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, "too many bad messages");
    hall_send_text(s->hall, seat->session, message_error(why));
    return 0;
}

static int take_message(struct server *s, struct lws *wsi, struct seat *seat)
{
    char why[MESSAGE_WHY];
    struct message m;
    struct session *session = seat->session;
    if (!message_read(seat->message, seat->message_size, &s->rules, &m, why))
        return refuse(s, wsi, seat, why);
    switch (m.kind) {
    case MESSAGE_STATE:
        if (session->has_wish && m.wish.version <= session->wish.version) {
            free(m.wish.values);
            return refuse(s, wsi, seat, "\"version\" must rise");
        }
        hall_set_wish(s->hall, session, &m.wish);
        break;
    case MESSAGE_ACK:
        hall_acknowledge(s->hall, session, m.frame);
        lws_callback_on_writable(wsi);
        break;
    case MESSAGE_PIXEL:
        hall_ask_pixel(s->hall, session, m.id, m.x, m.y);
        break;
    case MESSAGE_TRAIN:
        hall_order(s->hall, m.action);
        break;
    case MESSAGE_CAPTURE:
        hall_ask_capture(s->hall, session, m.id, m.layer, m.format);
        break;
    }
    return 0;
}

/* Pieces of messages, until one is whole. */
static int receive(struct server *s, struct lws *wsi, struct seat *seat, const void *in,
                   size_t size)
{
    const double now = hall_clock_s();
    if (!seat->session) return -1;
    if (seat->message_size + size > MESSAGE_MAX)
        return close_for(wsi, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, "a message is too long");
    if (size > 0) {
        char *longer = realloc(seat->message, seat->message_size + size);
        if (!longer) return -1;
        seat->message = longer;
        memcpy(seat->message + seat->message_size, in, size);
        seat->message_size += size;
    }
    if (lws_remaining_packet_payload(wsi) > 0 || !lws_is_final_fragment(wsi)) return 0;
    if (now - seat->second_began_s >= 1.0) {
        seat->second_began_s = now;
        seat->n_messages = 0;
    }
    if (++seat->n_messages > MESSAGES_PER_S)
        return close_for(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, "too many messages");
    const int result = lws_frame_is_binary(wsi) ? refuse(s, wsi, seat, "messages must be text")
                                                : take_message(s, wsi, seat);
    seat->message_size = 0;
    return result;
}

static const struct lws_protocols protocols[3];

static int on_socket(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in,
                     size_t size)
{
    struct server *s = server_of(wsi);
    struct seat *seat = user;
    switch (reason) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return may_connect(s, wsi) ? 0 : answer(wsi, HTTP_STATUS_FORBIDDEN);
    case LWS_CALLBACK_ESTABLISHED:
        return begin_session(s, wsi, seat);
    case LWS_CALLBACK_RECEIVE:
        return receive(s, wsi, seat, in, size);
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return send_next(s, wsi, seat);
    case LWS_CALLBACK_TIMER:
        if (seat->session && hall_waits_s(s->hall, seat->session) > PATIENCE_S) return -1;
        lws_set_timer_usecs(wsi, PATIENCE_LOOKED_AT_S * LWS_USEC_PER_SEC);
        return 0;
    case LWS_CALLBACK_CLOSED:
        if (seat->session) hall_leave(s->hall, seat->session);
        free(seat->message);
        *seat = (struct seat){0};
        return 0;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED: /* server_wake() */
        lws_callback_on_writable_all_protocol(s->context, &protocols[1]);
        return 0;
    default:
        return 0;
    }
}

static const struct lws_protocols protocols[3] = {
    {"http", on_http, sizeof(struct seat), 0, 0, NULL, 0},
    {PROTOCOL_NAME, on_socket, sizeof(struct seat), 4096, 0, NULL, 0},
    {NULL, NULL, 0, 0, 0, NULL, 0},
};

/* ---- The server ------------------------------------------------------------------------------ */

/* Half-open connections are noticed. */
static const lws_retry_bo_t keep_alive = {.secs_since_valid_ping = 20,
                                          .secs_since_valid_hangup = 40};

/* Whether a port can be bound: the library loses some memory where it cannot. */
static bool is_free(const char *address, uint16_t port)
{
    const int on = 1, fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(port)};
    if (fd < 0) return false;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on); /* as the library does */
    const bool is_bound = inet_pton(AF_INET, address, &to.sin_addr) == 1 &&
                          bind(fd, (const struct sockaddr *)&to, sizeof to) == 0 &&
                          listen(fd, 1) == 0;
    close(fd);
    return is_bound;
}

static bool listen_at(struct server *s, uint16_t port)
{
    if (!is_free(s->options->bind, port)) return false;
    const struct lws_context_creation_info info = {
        .port = port,
        .iface = s->options->bind,
        .protocols = protocols,
        .options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_DISABLE_IPV6 |
                   LWS_SERVER_OPTION_VALIDATE_UTF8,
        .gid = (gid_t)-1,
        .uid = (uid_t)-1,
        .timeout_secs = 10,
        .retry_and_idle_policy = &keep_alive,
        .max_http_header_data = 4096,
        .user = s,
        .vhost_name = "viewer",
    };
    s->context = lws_create_context(&info);
    s->port = port;
    return s->context != NULL;
}

bool server_new(const struct viewer_options *options, const struct message_rules *rules,
                const char *hello, struct hall *hall, struct server **out, char why[VIEWER_WHY])
{
    struct server *s = calloc(1, sizeof *s);
    bool is_open = false;
    *out = NULL;
    if (s) s->hello = strdup(hello);
    if (!s || !s->hello) {
        server_free(s);
        snprintf(why, VIEWER_WHY, "out of memory");
        return false;
    }
    s->options = options;
    s->rules = *rules;
    s->hall = hall;
    lws_set_log_level(0, NULL);
    const uint16_t first = options->port ? options->port : VIEWER_PORT;
    for (int i = 0; i < (options->port ? 1 : PORTS_TRIED) && !is_open; i++)
        is_open = listen_at(s, (uint16_t)(first + i));
    if (!is_open) {
        if (options->port)
            snprintf(why, VIEWER_WHY, "cannot listen at %s, port %u: it is taken, or not ours",
                     options->bind, options->port);
        else
            snprintf(
                why, VIEWER_WHY,
                "cannot listen at %s, ports %d to %d: no address of this machine, or all taken",
                options->bind, VIEWER_PORT, VIEWER_PORT + PORTS_TRIED - 1);
        server_free(s);
        return false;
    }
    hall->wake_server = server_wake;
    hall->server = s;
    *out = s;
    return true;
}

void server_free(struct server *s)
{
    if (!s) return;
    if (s->hall) s->hall->wake_server = NULL;
    if (s->context) lws_context_destroy(s->context);
    free(s->hello);
    free(s);
}

uint16_t server_port(const struct server *s)
{
    return s->port;
}

void server_wake(void *server)
{
    const struct server *s = server;
    lws_cancel_service(s->context);
}

/* lws_service() sleeps until something happens: this does. */
static void on_tick(lws_sorted_usec_list_t *tick)
{
    struct server *s = lws_container_of(tick, struct server, tick);
    lws_sul_schedule(s->context, 0, tick, on_tick, LOOK_AROUND_MS * LWS_US_PER_MS);
}

bool server_run(struct server *s, bool (*must_stop)(void *user), void *user)
{
    on_tick(&s->tick);
    while (!must_stop(user))
        if (lws_service(s->context, 0) < 0) return false;
    return true;
}
