/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/variables.h"

/* A build without variables: every scene has one configuration. */

lmn_status variables_declare(struct builder *b, const char *variables_path, struct error *err)
{
    (void)b;
    (void)variables_path;
    (void)err;
    return LMN_OK;
}

lmn_status variables_resolve(const struct builder *b, struct scene *s, struct error *err)
{
    (void)b;
    (void)s;
    (void)err;
    return LMN_OK;
}
