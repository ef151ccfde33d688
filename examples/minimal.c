/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Loads a scene, traces one random configuration of it and saves the picture:
 *
 *     cc minimal.c $(pkg-config --cflags --libs lumenaut) -o minimal
 *     ./minimal scene.xml picture.png
 */
#include <stdio.h>
#include <stdlib.h>

#include <lumenaut/lumenaut.h>

int main(int argc, char **argv)
{
    if (argc != 3) {
        fprintf(stderr, "usage: minimal SCENE.xml PICTURE.png|exr\n");
        return EXIT_FAILURE;
    }
    char message[256];
    lmn_context *context = NULL;
    if (lmn_context_new(NULL, &context, message, sizeof message) != LMN_OK) {
        fprintf(stderr, "%s\n", message);
        return EXIT_FAILURE;
    }

    int status = EXIT_FAILURE;
    lmn_scene *scene = NULL;
    lmn_image *image = NULL;
    double *values = NULL;
    double seconds = 0;
    lmn_scene_info info;
    lmn_trace_options options = {
        .struct_size = sizeof options, .width = 64, .height = 64, .spp = 16, .seed = 1};

    if (lmn_scene_load(context, argv[1], NULL, &scene) != LMN_OK) goto done;
    lmn_scene_get_info(scene, &info);
    values = calloc(info.n_variables + 1, sizeof *values);
    if (!values) goto done;
    lmn_scene_random_values(scene, 1, 0, values);
    if (lmn_scene_trace(context, scene, values, &options, &image, &seconds) != LMN_OK) goto done;
    if (lmn_image_save(context, image, argv[2], NULL, 1.0) != LMN_OK) goto done;
    printf("%s: %u variables, %.3f s\n", argv[2], info.n_variables, seconds);
    status = EXIT_SUCCESS;
done:
    if (status != EXIT_SUCCESS) fprintf(stderr, "%s\n", lmn_context_message(context));
    free(values);
    lmn_image_free(image);
    lmn_scene_free(scene);
    lmn_context_free(context);
    return status;
}
