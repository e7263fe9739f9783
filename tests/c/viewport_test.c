// viewport_test SCENE: a viewport of a host in C: a scene is edited while it is shown, picked, replaced and
// dropped, and handles are destroyed in the wrong order.
#include "9_host.h"
#include "check.h"

#include <stdatomic.h>

enum { kSide = 32 };

typedef struct {
    Host host;
    RgRenderer* renderer;
    RgScene* scene;
    RgGpuScene* gpu_scene;
    RgViewport* viewport;
    RgHostImage* image;
    uint8_t texels[kSide * kSide * 4];
} View;

static RgSettings* Settings(const char* name, const char* text) {
    RgSettings* settings = NULL;
    CHECK_OK(rg_settings_create(&settings));
    CHECK_OK(rg_settings_set(settings, name, text));
    return settings;
}

// Shows a frame, and reads it.
static void Show(View* view) {
    RgToken token;
    CHECK_OK(rg_frame_begin(view->renderer));
    CHECK_OK(rg_viewport_show(view->viewport, view->image, NULL));
    CHECK_OK(rg_frame_execute(view->renderer, &token));
    CHECK_OK(rg_device_wait(view->host.raygraph, token));
    bool has_completed = false;
    CHECK_OK(rg_device_has_completed(view->host.raygraph, token, &has_completed));
    CHECK(has_completed);
    RgSemaphoreUse after = {NULL, 0};
    CHECK_OK(rg_device_after(view->host.raygraph, token, &after));
    uint64_t reached = 0;
    CHECK(after.semaphore != NULL &&
          vkGetSemaphoreCounterValue(view->host.device, after.semaphore, &reached) == VK_SUCCESS &&
          reached >= after.value);
    BeginCommands(&view->host);
    ReadImage(&view->host);
    Submit(&view->host);
    CopyTexels(&view->host, view->texels);
}

static int DifferingFrom(const View* view, const uint8_t* before) {
    int count = 0;
    for (int i = 0; i < kSide * kSide; ++i) count += memcmp(&view->texels[4 * i], before + 4 * i, 4) != 0;
    return count;
}

static void EditsAreSeen(View* view) {
    static uint8_t before[kSide * kSide * 4];
    Show(view);
    memcpy(before, view->texels, sizeof before);
    CHECK_OK(rg_gpu_scene_update(view->gpu_scene, view->scene));
    Show(view);
    CHECK(DifferingFrom(view, before) == 0);

    // The node of an instance
    uint32_t node = 0;
    CHECK_OK(rg_scene_find(view->scene, RG_NODE, "tall block", &node));
    double matrix[16], moved[16];
    CHECK_OK(rg_scene_get_transform(view->scene, node, matrix));
    memcpy(moved, matrix, sizeof moved);
    moved[12] += 0.15;
    CHECK_OK(rg_scene_set_transform(view->scene, node, moved));
    Show(view);
    CHECK(DifferingFrom(view, before) == 0);  // not before the update
    CHECK_OK(rg_gpu_scene_update(view->gpu_scene, view->scene));
    Show(view);
    CHECK(DifferingFrom(view, before) > 20);
    CHECK_OK(rg_scene_set_transform(view->scene, node, matrix));
    CHECK_OK(rg_gpu_scene_update(view->gpu_scene, view->scene));
    Show(view);
    CHECK(DifferingFrom(view, before) == 0);
    const float no = 0, yes = 1;
    CHECK_OK(rg_scene_set(view->scene, RG_NODE, node, "visible", &no, 1));
    CHECK_OK(rg_gpu_scene_update(view->gpu_scene, view->scene));
    Show(view);
    CHECK(DifferingFrom(view, before) > 20);
    CHECK_OK(rg_scene_set(view->scene, RG_NODE, node, "visible", &yes, 1));

    // A material
    uint32_t material = 0;
    float color[4], green[4] = {0, 1, 0, 1};
    CHECK_OK(rg_scene_find(view->scene, RG_MATERIAL, "white", &material));
    CHECK_OK(rg_scene_get(view->scene, RG_MATERIAL, material, "baseColorFactor", color, 4));
    CHECK_OK(rg_scene_set(view->scene, RG_MATERIAL, material, "baseColorFactor", green, 4));
    CHECK_OK(rg_gpu_scene_update(view->gpu_scene, view->scene));
    Show(view);
    CHECK(DifferingFrom(view, before) > 100);
    CHECK_OK(rg_scene_set(view->scene, RG_MATERIAL, material, "baseColorFactor", color, 4));
    CHECK_OK(rg_gpu_scene_update(view->gpu_scene, view->scene));
    Show(view);
    CHECK(DifferingFrom(view, before) == 0);

    // Instances without the scene
    uint32_t instance = 0;
    CHECK_OK(rg_scene_find(view->scene, RG_INSTANCE, "tall block", &instance));
    CHECK_OK(rg_scene_get_world_transform(view->scene, node, matrix));
    memcpy(moved, matrix, sizeof moved);
    moved[12] += 0.15;
    CHECK_OK(rg_gpu_scene_set_transforms(view->gpu_scene, &instance, moved, 1));
    Show(view);
    CHECK(DifferingFrom(view, before) > 20);
    CHECK_OK(rg_gpu_scene_set_transforms(view->gpu_scene, &instance, matrix, 1));
    instance = 1000;
    CHECK_FAILS(rg_gpu_scene_set_transforms(view->gpu_scene, &instance, matrix, 1), RG_ERROR_USAGE, "1000");

    // New objects, and another scene, need to be set
    CHECK_OK(rg_scene_add_material(view->scene, "new", &material));
    CHECK_FAILS(rg_gpu_scene_update(view->gpu_scene, view->scene), RG_ERROR_USAGE, "rg_gpu_scene_set");
    CHECK_OK(rg_gpu_scene_set(view->gpu_scene, view->scene));
    CHECK_OK(rg_gpu_scene_update(view->gpu_scene, view->scene));
    Show(view);
    CHECK(DifferingFrom(view, before) == 0);
    RgScene* empty = NULL;
    CHECK_OK(rg_scene_create("empty", &empty));
    CHECK_OK(rg_gpu_scene_set(view->gpu_scene, empty));
    Show(view);
    CHECK(DifferingFrom(view, before) > 500);
    CHECK_OK(rg_gpu_scene_set(view->gpu_scene, view->scene));
    rg_scene_destroy(empty);
}

static void CameraViewAndSettingsAreSeen(View* view) {
    static uint8_t before[kSide * kSide * 4];
    Show(view);
    memcpy(before, view->texels, sizeof before);
    RgSettings* settings = Settings("exposure", "2");
    CHECK_OK(rg_viewport_set_settings(view->viewport, settings));
    Show(view);
    CHECK(DifferingFrom(view, before) > 500);
    CHECK_OK(rg_settings_set(settings, "exposure", NULL));
    CHECK_OK(rg_viewport_set_settings(view->viewport, settings));
    Show(view);
    CHECK(DifferingFrom(view, before) == 0);
    CHECK_OK(rg_viewport_set_view(view->viewport, RG_VIEW_RASTER));
    Show(view);
    CHECK(DifferingFrom(view, before) > 100);
    CHECK_FAILS(rg_viewport_set_view(view->viewport, 7), RG_ERROR_USAGE, "7 is no view");
    CHECK_OK(rg_viewport_set_view(view->viewport, RG_VIEW_PATH_TRACED));

    RgCamera camera = {
        .struct_size = sizeof camera, .eye = {0.5, 0.5, 3.0}, .target = {0.5, 0.5, 0.0}, .y_fov = 0.3f};
    CHECK_OK(rg_viewport_set_camera(view->viewport, &camera));
    Show(view);
    CHECK(DifferingFrom(view, before) > 100);
    camera.y_fov = -1.0f;
    CHECK_FAILS(rg_viewport_set_camera(view->viewport, &camera), RG_ERROR_USAGE, "negative");
    CHECK_OK(rg_settings_set(settings, "camera", "none such"));
    CHECK_FAILS(rg_viewport_set_settings(view->viewport, settings), RG_ERROR_USAGE, "camera: ");
    CHECK_OK(rg_settings_set(settings, "camera", "0"));
    CHECK_OK(rg_viewport_set_settings(view->viewport, settings));
    Show(view);
    CHECK(DifferingFrom(view, before) == 0);
    rg_settings_destroy(settings);
}

static void PixelsArePicked(View* view) {
    RgPick *pick = NULL, *lost = NULL;
    RgPickResult result = {.struct_size = sizeof result};
    bool is_ready = true;
    CHECK_FAILS(rg_viewport_pick(view->viewport, kSide, 0, &pick), RG_ERROR_USAGE, "32");
    CHECK_OK(rg_viewport_pick(view->viewport, kSide / 2, kSide / 2, &pick));
    CHECK_OK(rg_pick_poll(pick, &is_ready, &result));
    CHECK(!is_ready);
    Show(view);
    CHECK_OK(rg_pick_poll(pick, &is_ready, &result));
    uint32_t count = 0;
    CHECK_OK(rg_scene_count(view->scene, RG_INSTANCE, &count));
    CHECK(is_ready && result.is_hit && result.instance < count && result.depth > 0.0f);
    rg_pick_destroy(pick);
    CHECK_OK(rg_viewport_pick(view->viewport, 0, 0, &lost));
    rg_pick_destroy(lost);
}

static void MistakesInFramesAreErrors(View* view) {
    RgToken token = {.queue = 7};
    bool would_block = true;
    CHECK_FAILS(rg_frame_execute(view->renderer, &token), RG_ERROR_USAGE, "BeginFrame");
    CHECK(token.queue == 7);
    CHECK_FAILS(rg_viewport_show(view->viewport, view->image, NULL), RG_ERROR_USAGE, "frame");
    CHECK_OK(rg_frame_begin(view->renderer));
    CHECK_FAILS(rg_frame_record(view->renderer, NULL, &token), RG_ERROR_USAGE, "commands is NULL");
    CHECK_OK(rg_viewport_set_size(view->viewport, 8, 8));
    CHECK_FAILS(rg_viewport_show(view->viewport, view->image, NULL), RG_ERROR_USAGE, "32");
    CHECK_OK(rg_frame_drop(view->renderer));
    CHECK_OK(rg_frame_would_block(view->renderer, &would_block));
    CHECK(!would_block);
    CHECK_OK(rg_viewport_set_size(view->viewport, 0, 8));
    CHECK_OK(rg_frame_begin(view->renderer));
    CHECK_OK(rg_viewport_show(view->viewport, view->image, NULL));
    CHECK_OK(rg_frame_execute(view->renderer, &token));
    CHECK_OK(rg_viewport_set_size(view->viewport, kSide, kSide));
    RgHostImage* image = NULL;
    RgHostImageDesc desc = {
        .struct_size = sizeof desc, .width = kSide, .height = kSide, .image = view->host.image};
    CHECK_FAILS(rg_host_image_create(view->host.raygraph, &desc, &image), RG_ERROR_USAGE, "undefined");
    // An image whose handle is gone before its frame is submitted
    desc.format = VK_FORMAT_R8G8B8A8_UNORM;
    desc.layout_after = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    CHECK_OK(rg_host_image_create(view->host.raygraph, &desc, &image));
    CHECK_OK(rg_frame_begin(view->renderer));
    CHECK_OK(rg_viewport_show(view->viewport, image, NULL));
    rg_host_image_destroy(image);
    CHECK_OK(rg_frame_execute(view->renderer, &token));
    Show(view);
}

// --- An allocator of the host's ---

// Gives every resource a piece of its own allocation, at an offset, as an allocator of blocks does.
typedef struct {
    const Host* host;
    atomic_int live, total, wrong;
    int limit;  // allocations that may exist at once
} HostMemory;

static int32_t AllocateBlock(void* user, const VkMemoryRequirements* needed, const RgMemoryRequest* request,
                             RgMemory* memory) {
    HostMemory* of = user;
    if (request->struct_size != sizeof *request || memory->struct_size != sizeof *memory || !request->name[0])
        ++of->wrong;
    if (of->live >= of->limit) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    const bool is_mapped = request->kind != RG_MEMORY_DEVICE;
    const VkMemoryPropertyFlags wanted =
        is_mapped ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT : 0;
    VkPhysicalDeviceMemoryProperties heaps;
    vkGetPhysicalDeviceMemoryProperties(of->host->gpu, &heaps);
    while (!(needed->memoryTypeBits >> memory->memory_type & 1u) ||
           (heaps.memoryTypes[memory->memory_type].propertyFlags & wanted) != wanted)
        ++memory->memory_type;
    memory->offset = needed->alignment * request->alignment;  // a multiple of both
    memory->size = needed->size;
    const VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                             .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                       .pNext = &flags,
                                       .allocationSize = memory->offset + memory->size,
                                       .memoryTypeIndex = memory->memory_type};
    VkResult result = vkAllocateMemory(of->host->device, &info, NULL, &memory->memory);
    if (result == VK_SUCCESS && is_mapped)
        result =
            vkMapMemory(of->host->device, memory->memory, memory->offset, memory->size, 0, &memory->mapped);
    if (result != VK_SUCCESS) return result;
    memory->handle = user;
    ++of->live;
    ++of->total;
    return VK_SUCCESS;
}

static int32_t CreateHostBuffer(void* user, const VkBufferCreateInfo* info, const RgMemoryRequest* request,
                                VkBuffer* buffer, RgMemory* memory) {
    const VkDevice device = ((HostMemory*)user)->host->device;
    VkResult result = vkCreateBuffer(device, info, NULL, buffer);
    if (result != VK_SUCCESS) return result;
    VkMemoryRequirements needed;
    vkGetBufferMemoryRequirements(device, *buffer, &needed);
    result = AllocateBlock(user, &needed, request, memory);
    if (result != VK_SUCCESS) {
        vkDestroyBuffer(device, *buffer, NULL);
        return result;
    }
    return vkBindBufferMemory(device, *buffer, memory->memory, memory->offset);
}

static int32_t CreateHostImage(void* user, const VkImageCreateInfo* info, const RgMemoryRequest* request,
                               VkImage* image, RgMemory* memory) {
    const VkDevice device = ((HostMemory*)user)->host->device;
    VkResult result = vkCreateImage(device, info, NULL, image);
    if (result != VK_SUCCESS) return result;
    VkMemoryRequirements needed;
    vkGetImageMemoryRequirements(device, *image, &needed);
    result = AllocateBlock(user, &needed, request, memory);
    if (result != VK_SUCCESS) {
        vkDestroyImage(device, *image, NULL);
        return result;
    }
    return vkBindImageMemory(device, *image, memory->memory, memory->offset);
}

static void FreeHostMemory(void* user, const RgMemory* memory) {
    HostMemory* of = user;
    if (memory->handle != user || memory->size == 0) ++of->wrong;
    vkFreeMemory(of->host->device, memory->memory, NULL);
    --of->live;
}

static RgDevice* AdoptWith(const Host* host, const RgMemoryAllocator* allocator) {
    RgRequirements* requirements = NULL;
    CHECK_OK(rg_requirements_create(vkGetInstanceProcAddr, host->instance, host->gpu, &requirements));
    RgDeviceSetup setup = {.struct_size = sizeof setup};
    CHECK_OK(rg_requirements_get(requirements, &setup));
    const RgAdoptDesc adopt = {.struct_size = sizeof adopt,
                               .queue_family = setup.queue_family,
                               .loader = vkGetInstanceProcAddr,
                               .instance = host->instance,
                               .physical_device = host->gpu,
                               .device = host->device,
                               .queue = host->queue,
                               .extensions = setup.extensions,
                               .extension_count = setup.extension_count,
                               .optional_features = setup.optional_features,
                               .allocator = allocator};
    RgDevice* device = NULL;
    if (allocator->free == NULL)
        CHECK_FAILS(rg_device_adopt(&adopt, &device), RG_ERROR_USAGE, "lacks one of its four functions");
    else
        CHECK_OK(rg_device_adopt(&adopt, &device));
    rg_requirements_destroy(requirements);
    return device;
}

static void MemoryIsThatOfTheHost(View* view) {
    HostMemory memory = {.host = &view->host, .limit = 1 << 20};
    RgMemoryAllocator allocator = {.struct_size = sizeof allocator, .user = &memory};
    CHECK(AdoptWith(&view->host, &allocator) == NULL);
    allocator.create_buffer = CreateHostBuffer;
    allocator.create_image = CreateHostImage;
    allocator.allocate = AllocateBlock;
    allocator.free = FreeHostMemory;
    RgDevice* device = AdoptWith(&view->host, &allocator);
    memset(&allocator, 0, sizeof allocator);  // it was copied

    RgSettings* settings = Settings("size", "16x12");
    CHECK_OK(rg_settings_set(settings, "spp", "2"));
    RgPicture* pictures[2] = {NULL, NULL};
    CHECK_OK(rg_render(view->host.raygraph, view->scene, settings, NULL, NULL, &pictures[0]));
    CHECK(memory.total == 0);
    CHECK_OK(rg_render(device, view->scene, settings, NULL, NULL, &pictures[1]));
    CHECK(memory.total > 20);
    RgChannel colors[2] = {{.struct_size = sizeof(RgChannel)}, {.struct_size = sizeof(RgChannel)}};
    for (int i = 0; i < 2; ++i) CHECK_OK(rg_picture_get_channel(pictures[i], "color", &colors[i]));
    CHECK(memcmp(colors[0].data, colors[1].data, 16 * 12 * 16) == 0);

    memory.limit = memory.live + 5;
    RgPicture* none = NULL;
    CHECK_FAILS(rg_render(device, view->scene, settings, NULL, NULL, &none), RG_ERROR_OUT_OF_MEMORY, "");
    CHECK(none == NULL && rg_last_vk_result() == VK_ERROR_OUT_OF_DEVICE_MEMORY);
    memory.limit = 1 << 20;
    CHECK_OK(rg_render(device, view->scene, settings, NULL, NULL, &none));
    rg_device_destroy(device);
    CHECK(memory.live == 0 && memory.wrong == 0);
    rg_picture_destroy(none);
    rg_picture_destroy(pictures[0]);
    rg_picture_destroy(pictures[1]);
    rg_settings_destroy(settings);
}

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    static View view;
    view.host = MakeHost(kSide);
    CHECK_OK(rg_scene_load(argv[1], NULL, &view.scene));
    CHECK_OK(rg_renderer_create(view.host.raygraph, &view.renderer));
    CHECK_OK(rg_gpu_scene_create(view.renderer, view.scene, &view.gpu_scene));
    const RgViewportDesc viewport = {.struct_size = sizeof viewport, .width = kSide, .height = kSide};
    CHECK_OK(rg_viewport_create(view.gpu_scene, &viewport, &view.viewport));
    // A frame of an unchanged scene has the picture of the one before
    const RgBudget budget = {.struct_size = sizeof budget, .max_samples = 1};
    CHECK_OK(rg_viewport_set_budget(view.viewport, &budget));
    const RgHostImageDesc image = {.struct_size = sizeof image,
                                   .width = kSide,
                                   .height = kSide,
                                   .format = VK_FORMAT_R8G8B8A8_UNORM,
                                   .image = view.host.image,
                                   .layout_after = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
    CHECK_OK(rg_host_image_create(view.host.raygraph, &image, &view.image));
    EditsAreSeen(&view);
    CameraViewAndSettingsAreSeen(&view);
    PixelsArePicked(&view);
    MistakesInFramesAreErrors(&view);
    MemoryIsThatOfTheHost(&view);
    // Each keeps what it was made with
    rg_scene_destroy(view.scene);
    rg_renderer_destroy(view.renderer);
    rg_gpu_scene_destroy(view.gpu_scene);
    rg_viewport_destroy(view.viewport);
    rg_host_image_destroy(view.image);
    DestroyHost(&view.host);
    if (g_failures == 0) puts("all checks passed");
    return g_failures == 0 ? 0 : 1;
}
