// host SCENE PICTURE.png: a host in C11 with one command buffer a frame shows a scene in its own image, draws
// over it, and compares what it shows with the picture that is rendered offline.
#include "9_host.h"

enum { kSide = 96, kSquare = 16, kSamples = 32 };

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    Host host = MakeHost(kSide);
    RgScene* scene;
    RAYGRAPH(rg_scene_load(argv[1], NULL, &scene));
    RgSettings* settings;
    RAYGRAPH(rg_settings_create(&settings));
    RAYGRAPH(rg_settings_set(settings, "size", "96x96"));
    RAYGRAPH(rg_settings_set(settings, "spp", "32"));

    RgRenderer* renderer;
    RgGpuScene* gpu_scene;
    RgViewport* viewport;
    RgHostImage* image;
    RAYGRAPH(rg_renderer_create(host.raygraph, &renderer));
    RAYGRAPH(rg_gpu_scene_create(renderer, scene, &gpu_scene));
    const RgViewportDesc viewport_desc = {
        .struct_size = sizeof viewport_desc, .width = kSide, .height = kSide};
    RAYGRAPH(rg_viewport_create(gpu_scene, &viewport_desc, &viewport));
    RAYGRAPH(rg_viewport_set_settings(viewport, settings));
    const RgBudget budget = {.struct_size = sizeof budget, .max_samples = kSamples};
    RAYGRAPH(rg_viewport_set_budget(viewport, &budget));
    const RgHostImageDesc image_desc = {.struct_size = sizeof image_desc,
                                        .width = kSide,
                                        .height = kSide,
                                        .format = VK_FORMAT_R8G8B8A8_UNORM,
                                        .image = host.image,
                                        .layout_after = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    RAYGRAPH(rg_host_image_create(host.raygraph, &image_desc, &image));
    RgViewportProgress progress = {.struct_size = sizeof progress};
    while (progress.samples < kSamples) {
        BeginCommands(&host);
        RAYGRAPH(rg_frame_begin(renderer));
        RAYGRAPH(rg_viewport_show(viewport, image, NULL));
        RgToken token;
        RAYGRAPH(rg_frame_record(renderer, host.commands, &token));
        DrawSquare(&host, kSquare);
        ChangeLayout(&host, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        ReadImage(&host);
        Submit(&host);
        RAYGRAPH(rg_device_complete(host.raygraph, token));
        RAYGRAPH(rg_host_image_return(image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL));
        RAYGRAPH(rg_viewport_get_progress(viewport, &progress));
    }
    static uint8_t shown[kSide * kSide * 4];
    CopyTexels(&host, shown);

    RgPicture* picture;
    RgChannel offline = {.struct_size = sizeof offline};
    RAYGRAPH(rg_render(host.raygraph, scene, settings, NULL, NULL, &picture));
    RAYGRAPH(rg_picture_save(picture, NULL, argv[2]));
    RAYGRAPH(rg_picture_display(picture, NULL, &offline));
    int differing = 0;
    for (int i = 0; i < kSide * kSide * 4; ++i) {
        const bool is_square = i / 4 % kSide < kSquare && i / 4 / kSide < kSquare;
        const uint8_t blue[4] = {0, 0, 255, 255};
        const int expected = is_square ? blue[i % 4] : ((const uint8_t*)offline.data)[i];
        if (abs(shown[i] - expected) > 1) ++differing;
    }
    printf("%u samples, %d values differ from the picture rendered offline\n", progress.samples, differing);

    rg_picture_destroy(picture);
    rg_host_image_destroy(image);
    rg_viewport_destroy(viewport);
    rg_gpu_scene_destroy(gpu_scene);
    rg_renderer_destroy(renderer);
    rg_settings_destroy(settings);
    rg_scene_destroy(scene);
    DestroyHost(&host);
    return differing == 0 ? 0 : 1;
}
