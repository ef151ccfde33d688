/* SPDX-License-Identifier: Apache-2.0 */
#include "encode.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <turbojpeg.h>

enum { QUALITY_MOVING = 80, QUALITY_RESTING = 93 };

/* Memory for room, header and size bytes after it. */
static struct parcel new_parcel(const struct picture_header *header, size_t size)
{
    struct parcel p = {.size = HALL_HEADER + size, .frame = header->frame};
    p.memory = malloc(PARCEL_ROOM + HALL_HEADER + size);
    if (p.memory) picture_header_write(header, p.memory + PARCEL_ROOM);
    return p;
}

struct parcel encode_jpeg(const struct picture_header *header, const uint8_t *rgb, bool is_moving)
{
    struct parcel parcel = {0};
    unsigned char *bytes = NULL;
    unsigned long size = 0;
    tjhandle jpeg = tjInitCompress();
    if (jpeg && tjCompress2(jpeg, rgb, (int)header->width, 0, (int)header->height, TJPF_RGB, &bytes,
                            &size, is_moving ? TJSAMP_420 : TJSAMP_444,
                            is_moving ? QUALITY_MOVING : QUALITY_RESTING, TJFLAG_FASTDCT) == 0) {
        parcel = new_parcel(header, size);
        if (parcel.memory) memcpy(parcel.memory + PARCEL_ROOM + HALL_HEADER, bytes, size);
    }
    tjFree(bytes);
    if (jpeg) tjDestroy(jpeg);
    return parcel;
}

/* The file's bytes, after the header. */
static struct parcel read_file(const char *path, const struct picture_header *header)
{
    struct parcel p = {0};
    FILE *f = fopen(path, "rb");
    if (!f) return p;
    if (fseek(f, 0, SEEK_END) == 0) {
        const long size = ftell(f);
        rewind(f);
        if (size > 0) p = new_parcel(header, (size_t)size);
        if (p.memory &&
            fread(p.memory + PARCEL_ROOM + HALL_HEADER, 1, (size_t)size, f) != (size_t)size) {
            free(p.memory);
            p = (struct parcel){0};
        }
    }
    fclose(f);
    return p;
}

struct parcel encode_file(lmn_context *context, const lmn_image *image, double exposure,
                          enum capture_format format, const struct picture_header *header)
{
    const char *const root = getenv("TMPDIR"), *const name = format == CAPTURE_PNG ? "png" : "exr";
    char folder[512], path[528];
    struct parcel p = {0};
    const int n = snprintf(folder, sizeof folder, "%s/lumenaut-XXXXXX",
                           root && *root ? root : "/tmp");
    if (n < 0 || (size_t)n >= sizeof folder || !mkdtemp(folder)) return p;
    snprintf(path, sizeof path, "%s/a.%s", folder, name);
    if (lmn_image_save(context, image, path, name, exposure) == LMN_OK) p = read_file(path, header);
    unlink(path);
    rmdir(folder);
    return p;
}
