// render SCENE PICTURE.png: renders a scene offline, through the C interface.
#include <raygraph.h>
#include <stdio.h>

static bool Show(void* user, const RgProgress* progress) {
    (void)user;
    fprintf(stderr, "\r%u of %u samples", progress->samples, progress->samples_wanted);
    return true;  // false ends the render with what there is
}

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    RgDevice* device = NULL;
    RgScene* scene = NULL;
    RgSettings* settings = NULL;
    RgPicture* picture = NULL;
    RgResult result = rg_device_create(NULL, &device);
    if (result == RG_OK) result = rg_scene_load(argv[1], NULL, &scene);
    if (result == RG_OK) result = rg_settings_create(&settings);
    if (result == RG_OK) result = rg_settings_set(settings, "size", "96x96");
    if (result == RG_OK) result = rg_settings_set(settings, "spp", "16");
    if (result == RG_OK) result = rg_render(device, scene, settings, Show, NULL, &picture);
    if (result == RG_OK) result = rg_picture_save(picture, device, argv[2]);
    fprintf(stderr, "\n%s", result == RG_OK ? "" : rg_last_error());
    rg_picture_destroy(picture);
    rg_settings_destroy(settings);
    rg_scene_destroy(scene);
    rg_device_destroy(device);
    return result;
}
