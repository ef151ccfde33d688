/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_ENCODE_H
#define VIEWER_ENCODE_H

#include "hall.h"
#include "messages.h"

/* Room before a parcel's bytes: what libwebsockets may write there (LWS_PRE), rounded up. */
enum { PARCEL_ROOM = 64 };

/* A picture as JPEG behind its header: 4:2:0 while moving, else 4:4:4. rgb [height][width][3].
 * An empty parcel: no memory. */
struct parcel encode_jpeg(const struct picture_header *header, const uint8_t *rgb, bool is_moving);

/* An image as a PNG or EXR file, behind its header. On failure the parcel is empty and the context
 * or errno knows why. */
struct parcel encode_file(lmn_context *context, const lmn_image *image, double exposure,
                          enum capture_format format, const struct picture_header *header);

#endif
