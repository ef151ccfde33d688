/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_SERVER_H
#define VIEWER_SERVER_H

#include "hall.h"
#include "messages.h"
#include "viewer.h"

/*
 * The socket's side: pages and their sessions. One thread; what it sends was made elsewhere.
 *
 * Whoever can reach the port may be anybody's web page in a browser of this machine: so a Host must
 * be one of this machine's names (else a foreign name could be made to point here), an Origin must
 * be of that Host, and addresses that others can reach want a token.
 */
struct server;

/* hello: the text that every session begins with; the server keeps its own copy. */
bool server_new(const struct viewer_options *options, const struct message_rules *rules,
                const char *hello, struct hall *hall, struct server **out, char why[VIEWER_WHY]);
void server_free(struct server *s);

/* The port that is open. */
uint16_t server_port(const struct server *s);

bool server_run(struct server *s, bool (*must_stop)(void *user), void *user);

/* From any thread: something is ready for a session. */
void server_wake(void *server);

#endif
