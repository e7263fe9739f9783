// interface_test SCENE FOLDER: the C interface without a window: errors, scenes, settings, pictures, and what
// judges them. Files are written to the folder.
#include "check.h"

#include <math.h>
#include <stdlib.h>

static RgSettings* SmallSettings(void) {
    RgSettings* settings = NULL;
    CHECK_OK(rg_settings_create(&settings));
    CHECK_OK(rg_settings_set(settings, "size", "24x18"));
    CHECK_OK(rg_settings_set(settings, "spp", "4"));
    return settings;
}

static RgChannel Channel(const RgPicture* picture, const char* name) {
    RgChannel channel = {.struct_size = sizeof channel};
    CHECK_OK(rg_picture_get_channel(picture, name, &channel));
    return channel;
}

static const float* Pixel(const RgChannel* channel, uint32_t x, uint32_t y) {
    return (const float*)((const char*)channel->data + (y * channel->width + x) * channel->pixel_stride);
}

static RgPicture* Render(RgDevice* device, RgScene* scene, const RgSettings* settings) {
    RgPicture* picture = NULL;
    CHECK_OK(rg_render(device, scene, settings, NULL, NULL, &picture));
    return picture;
}

// --- Errors ---

static void WrongUseIsAnError(RgDevice* device, const char* scene_file) {
    RgScene* scene = NULL;
    RgSettings* settings = NULL;
    uint32_t index = 7;
    CHECK_FAILS(rg_scene_load(NULL, NULL, &scene), RG_ERROR_USAGE, "rg_scene_load: path is NULL");
    CHECK_FAILS(rg_scene_load(scene_file, NULL, NULL), RG_ERROR_USAGE, "scene is NULL");
    CHECK_FAILS(rg_scene_load("no such.gltf", NULL, &scene), RG_ERROR_BAD_INPUT, "no such.gltf");
    CHECK(scene == NULL);
    CHECK_FAILS(rg_scene_count(NULL, RG_NODE, &index), RG_ERROR_USAGE, "rg_scene_count: scene is NULL");
    CHECK_FAILS(rg_render(device, NULL, NULL, NULL, NULL, NULL), RG_ERROR_USAGE, "scene is NULL");
    CHECK_FAILS(rg_render(NULL, NULL, NULL, NULL, NULL, NULL), RG_ERROR_USAGE, "device is NULL");
    CHECK_FAILS(rg_settings_set(NULL, "spp", "1"), RG_ERROR_USAGE, "settings is NULL");
    CHECK_FAILS(rg_frame_begin(NULL), RG_ERROR_USAGE, "renderer is NULL");
    CHECK_FAILS(rg_device_create(&(RgDeviceDesc){.struct_size = sizeof(RgDeviceDesc), .select = "none such"},
                                 &device),
                RG_ERROR_NO_DEVICE, "none such");
    CHECK_FAILS(rg_device_complete(device, (RgToken){.queue = 3, .value = 1}), RG_ERROR_USAGE,
                "token.queue is 3");
    CHECK_FAILS(rg_device_complete(device, (RgToken){.value = 1000000}), RG_ERROR_USAGE, "1000000");
    rg_scene_destroy(NULL);
    rg_device_destroy(NULL);
    rg_picture_destroy(NULL);
    rg_text_free(NULL);

    CHECK_OK(rg_settings_create(&settings));
    CHECK_FAILS(rg_settings_set(settings, "max_depth", "1"), RG_ERROR_USAGE, "max-depth");
    CHECK_FAILS(rg_settings_set(settings, "max-depth", "many"), RG_ERROR_USAGE, "max-depth: \"many\"");
    CHECK_FAILS(rg_settings_set(settings, "aov", "albedo,albino"), RG_ERROR_USAGE, "aov: \"albino\"");
    CHECK_FAILS(rg_settings_set(settings, "denoise", "magic"), RG_ERROR_USAGE, "denoise: \"magic\"");
    CHECK_FAILS(rg_settings_set(settings, "spp", "0"), RG_ERROR_USAGE, "spp: \"0\"");
    CHECK_FAILS(rg_settings_set(settings, "tonemap", "dark"), RG_ERROR_USAGE, "tonemap: \"dark\"");
    CHECK_FAILS(rg_settings_set(settings, "variant", "red"), RG_ERROR_USAGE, "is no setting");
    rg_settings_destroy(settings);
}

static void StructsMayBeOlderOrNewer(RgDevice* device) {
    RgDeviceInfo info = {.struct_size = 0};
    CHECK_FAILS(rg_device_get_info(device, &info), RG_ERROR_USAGE, "struct_size");
    // An older one ends before `kind`.
    memset(&info, 0xAB, sizeof info);
    info.struct_size = offsetof(RgDeviceInfo, kind);
    const char* const before = info.kind;
    CHECK_OK(rg_device_get_info(device, &info));
    CHECK(info.name != NULL && info.kind == before && info.struct_size == offsetof(RgDeviceInfo, kind));

    struct {
        RgLoadDesc desc;
        uint64_t later;
    } newer = {.desc.struct_size = sizeof newer};
    RgScene* scene = NULL;
    CHECK_FAILS(rg_scene_load("no such.gltf", &newer.desc, &scene), RG_ERROR_BAD_INPUT, "no such.gltf");
    newer.later = 1;
    CHECK_FAILS(rg_scene_load("no such.gltf", &newer.desc, &scene), RG_ERROR_USAGE, "does not know");
}

// --- Scenes of files ---

static void FileIsRenderedAsByTheProgram(RgDevice* device, const char* file, const char* folder) {
    RgScene* scene = NULL;
    CHECK_OK(rg_scene_load(file, NULL, &scene));
    RgSettings* settings = SmallSettings();
    CHECK_OK(rg_settings_set(settings, "aov", "albedo,depth,instance"));
    const char* text = NULL;
    CHECK_OK(rg_settings_get(settings, "size", &text));
    CHECK(strcmp(text, "24x18") == 0);
    CHECK_OK(rg_settings_get(settings, "seed", &text));
    CHECK(strcmp(text, "0") == 0);

    RgPicture* picture = Render(device, scene, settings);
    RgPictureInfo info = {.struct_size = sizeof info};
    CHECK_OK(rg_picture_get_info(picture, &info));
    CHECK(info.width == 24 && info.height == 18 && info.samples == 4 && !info.was_stopped);
    CHECK(info.relative_error > 0.0 && info.seconds > 0.0);
    const RgChannel color = Channel(picture, "color"), depth = Channel(picture, "depth"),
                    instance = Channel(picture, "instance");
    CHECK(color.number == RG_FLOAT32 && color.channels == 4 && color.pixel_stride == 16);
    CHECK(depth.channels == 1 && instance.number == RG_UINT32);
    CHECK(Pixel(&color, 12, 9)[1] > 0.0f && Pixel(&color, 12, 9)[3] == 1.0f);
    CHECK(Pixel(&depth, 12, 9)[0] > 0.0f);
    bool has_albedo = false;
    for (uint32_t i = 0; rg_picture_channel_name(picture, i) != NULL; ++i)
        has_albedo = has_albedo || strcmp(rg_picture_channel_name(picture, i), "albedo") == 0;
    CHECK(has_albedo);
    RgChannel channel = {.struct_size = sizeof channel};
    CHECK_FAILS(rg_picture_get_channel(picture, "motion", &channel), RG_ERROR_USAGE, "color, variance");

    char path[4096];
    snprintf(path, sizeof path, "%s/picture.exr", folder);
    CHECK_OK(rg_picture_save(picture, NULL, path));
    CHECK_FAILS(rg_picture_save(picture, NULL, "picture.bmp"), RG_ERROR_USAGE, "picture.bmp");
    CHECK_FAILS(rg_picture_save(picture, NULL, "no such folder/a.exr"), RG_ERROR_IO, "no such folder");
    RgPicture* read = NULL;
    CHECK_OK(rg_picture_read(path, &read));
    const RgChannel again = Channel(read, "color");
    CHECK(memcmp(again.data, color.data, 24 * 18 * 16) == 0);
    CHECK_FAILS(rg_picture_display(read, NULL, &channel), RG_ERROR_USAGE, "device is NULL");
    CHECK_OK(rg_picture_display(read, device, &channel));
    RgChannel shown = {.struct_size = sizeof shown};
    CHECK_OK(rg_picture_display(picture, NULL, &shown));
    CHECK(shown.number == RG_UINT8 && memcmp(shown.data, channel.data, 24 * 18 * 4) == 0);
    rg_picture_destroy(read);
    rg_picture_destroy(picture);
    rg_settings_destroy(settings);
    rg_scene_destroy(scene);
}

typedef struct {
    uint32_t calls, samples;
} Seen;
static bool StopAtThree(void* user, const RgProgress* progress) {
    Seen* seen = user;
    ++seen->calls;
    seen->samples = progress->samples;
    return progress->samples < 3;
}

static void ProgressMayStop(RgDevice* device, const char* file) {
    RgScene* scene = NULL;
    CHECK_OK(rg_scene_load(file, NULL, &scene));
    RgSettings* settings = SmallSettings();
    CHECK_OK(rg_settings_set(settings, "spp", "1000"));
    Seen seen = {0, 0};
    RgPicture* picture = NULL;
    CHECK_OK(rg_render(device, scene, settings, StopAtThree, &seen, &picture));
    RgPictureInfo info = {.struct_size = sizeof info};
    CHECK_OK(rg_picture_get_info(picture, &info));
    CHECK(info.was_stopped && info.samples >= 3 && info.samples < 1000);
    CHECK(seen.calls > 0 && seen.samples <= info.samples);
    rg_picture_destroy(picture);
    rg_settings_destroy(settings);
    rg_scene_destroy(scene);
}

static bool StopWithoutSample(void* user, const RgProgress* progress) {
    *(Seen*)user = (Seen){((Seen*)user)->calls + 1, progress->samples};
    return false;
}

// A mesh of a million triangles takes a while to be put on the device.
static void ProgressMayStopBeforeThereIsASample(RgDevice* device) {
    enum { kSide = 700 };
    RgScene* scene = NULL;
    CHECK_OK(rg_scene_create("large", &scene));
    float* positions = malloc(sizeof(float) * 3 * kSide * kSide);
    uint32_t* indices = malloc(sizeof(uint32_t) * 6 * kSide * kSide);
    RgMeshDesc mesh = {.struct_size = sizeof mesh,
                       .vertex_count = kSide * kSide,
                       .positions = positions,
                       .indices = indices};
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const uint32_t at = y * kSide + x;
            positions[3 * at] = (float)x;
            positions[3 * at + 1] = (float)((x * x + y * y) % 17);
            positions[3 * at + 2] = (float)y;
            if (x + 1 == kSide || y + 1 == kSide) continue;
            const uint32_t corners[6] = {at, at + 1, at + kSide, at + 1, at + kSide + 1, at + kSide};
            memcpy(indices + mesh.index_count, corners, sizeof corners);
            mesh.index_count += 6;
        }
    uint32_t node = 0, added = 0, instance = 0;
    CHECK_OK(rg_scene_add_material(scene, "gray", &mesh.material));
    CHECK_OK(rg_scene_add_mesh(scene, &mesh, &added));
    CHECK_OK(rg_scene_add_node(scene, "place", RG_NONE, NULL, &node));
    CHECK_OK(rg_scene_add_instance(scene, node, added, &instance));
    RgSettings* settings = SmallSettings();
    Seen seen = {0, 7};
    RgPicture* picture = NULL;
    CHECK_FAILS(rg_render(device, scene, settings, StopWithoutSample, &seen, &picture), RG_ERROR_STOPPED,
                "before there was a result");
    CHECK(picture == NULL && seen.calls == 1 && seen.samples == 0);
    // What is left behind disturbs no other call, nor the end of the device
    RgDevice* other = NULL;
    CHECK_OK(rg_device_create(NULL, &other));
    CHECK_FAILS(rg_render(other, scene, settings, StopWithoutSample, &seen, &picture), RG_ERROR_STOPPED, "");
    rg_device_destroy(other);
    picture = Render(device, scene, settings);
    rg_picture_destroy(picture);
    rg_settings_destroy(settings);
    rg_scene_destroy(scene);
    free(positions);
    free(indices);
}

// --- Scenes of arrays ---

static const double kIdentity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

// A square of 2 m around the origin that faces +z and shines, in a scene of its own.
typedef struct {
    RgScene* scene;
    uint32_t material, mesh, node, instance;
} Square;

static Square MakeSquare(void) {
    Square square = {.scene = NULL};
    CHECK_OK(rg_scene_create("square", &square.scene));
    CHECK_OK(rg_scene_add_material(square.scene, "paint", &square.material));
    // Interleaved: position, texture coordinate.
    const float vertices[4][5] = {{-1, -1, 0, 0, 1}, {1, -1, 0, 1, 1}, {1, 1, 0, 1, 0}, {-1, 1, 0, 0, 0}};
    const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    const RgMeshDesc desc = {.struct_size = sizeof desc,
                             .material = square.material,
                             .name = "square",
                             .vertex_count = 4,
                             .index_count = 6,
                             .positions = vertices[0],
                             .uvs = &vertices[0][3],
                             .position_stride = sizeof vertices[0],
                             .uv_stride = sizeof vertices[0],
                             .indices = indices,
                             .index_size = 2};
    CHECK_OK(rg_scene_add_mesh(square.scene, &desc, &square.mesh));
    CHECK_OK(rg_scene_add_node(square.scene, "place", RG_NONE, NULL, &square.node));
    CHECK_OK(rg_scene_add_instance(square.scene, square.node, square.mesh, &square.instance));
    const float red[3] = {1, 0, 0};
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, square.material, "emissiveFactor", red, 3));
    const float black[4] = {0, 0, 0, 1};
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, square.material, "baseColorFactor", black, 4));
    return square;
}

static RgSettings* SquareSettings(void) {
    RgSettings* settings = NULL;
    CHECK_OK(rg_settings_create(&settings));
    CHECK_OK(rg_settings_set(settings, "size", "9x9"));
    CHECK_OK(rg_settings_set(settings, "spp", "1"));
    CHECK_OK(rg_settings_set(settings, "camera", "0 0 4 0 0 0 0 1 0 40"));
    CHECK_OK(rg_settings_set(settings, "background", "0,0,0.5"));
    CHECK_OK(rg_settings_set(settings, "max-depth", "0"));
    return settings;
}

static void ArraysAreSeenAndEdited(RgDevice* device) {
    Square square = MakeSquare();
    RgSettings* settings = SquareSettings();
    RgPicture* picture = Render(device, square.scene, settings);
    RgChannel color = Channel(picture, "color");
    CHECK(Pixel(&color, 4, 4)[0] == 1.0f && Pixel(&color, 4, 4)[2] == 0.0f);
    CHECK(Pixel(&color, 0, 0)[0] == 0.0f && Pixel(&color, 0, 0)[2] == 0.5f);
    rg_picture_destroy(picture);

    // A texture, whose upper left quarter is green
    const uint8_t texels[2][2][3] = {{{0, 255, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}};
    const RgPixels pixels = {
        .struct_size = sizeof pixels, .width = 2, .height = 2, .channels = 3, .data = texels};
    const float white[3] = {1, 1, 1};
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, square.material, "emissiveFactor", white, 3));
    CHECK_OK(rg_scene_set_texture(square.scene, square.material, "emissiveTexture", &pixels));
    picture = Render(device, square.scene, settings);
    color = Channel(picture, "color");
    CHECK(Pixel(&color, 2, 2)[1] > 0.5f && Pixel(&color, 6, 6)[1] < 0.1f && Pixel(&color, 2, 2)[0] < 0.1f);
    rg_picture_destroy(picture);
    CHECK_OK(rg_scene_set_texture(square.scene, square.material, "emissiveTexture", NULL));

    // Moved out of the view, below a parent
    uint32_t parent = 0, child = 0, other = 0;
    double matrix[16], world[16];
    memcpy(matrix, kIdentity, sizeof matrix);
    matrix[13] = 1000.0000001;
    CHECK_OK(rg_scene_set_transform(square.scene, square.node, matrix));
    CHECK_OK(rg_scene_get_transform(square.scene, square.node, world));
    CHECK(fabs(world[13] - matrix[13]) < 1e-9 && world[12] == 0.0 && world[15] == 1.0);
    picture = Render(device, square.scene, settings);
    color = Channel(picture, "color");
    CHECK(Pixel(&color, 4, 4)[2] == 0.5f);
    rg_picture_destroy(picture);
    CHECK_OK(rg_scene_add_node(square.scene, "parent", RG_NONE, matrix, &parent));
    matrix[13] = -1000.0;
    CHECK_OK(rg_scene_add_node(square.scene, "child", parent, matrix, &child));
    CHECK_OK(rg_scene_get_world_transform(square.scene, child, world));
    CHECK(fabs(world[13]) < 1e-6);
    CHECK_OK(rg_scene_add_instance(square.scene, child, square.mesh, &other));
    picture = Render(device, square.scene, settings);
    color = Channel(picture, "color");
    CHECK(Pixel(&color, 4, 4)[0] == 1.0f);
    rg_picture_destroy(picture);
    const float no = 0;
    CHECK_OK(rg_scene_set(square.scene, RG_NODE, parent, "visible", &no, 1));
    picture = Render(device, square.scene, settings);
    color = Channel(picture, "color");
    CHECK(Pixel(&color, 4, 4)[0] == 0.0f);
    rg_picture_destroy(picture);

    uint32_t count = 0, found = 0;
    const char* name = NULL;
    CHECK_OK(rg_scene_count(square.scene, RG_INSTANCE, &count));
    CHECK(count == 2 && other == 1);
    CHECK_OK(rg_scene_find(square.scene, RG_NODE, "child", &found));
    CHECK(found == child);
    CHECK_OK(rg_scene_get_name(square.scene, RG_INSTANCE, other, &name));
    CHECK(strcmp(name, "child") == 0);
    CHECK_FAILS(rg_scene_find(square.scene, RG_MESH, "cube", &found), RG_ERROR_USAGE, "no mesh is called");
    rg_settings_destroy(settings);
    rg_scene_destroy(square.scene);
}

static void LightsCamerasAndMapsAreSeen(RgDevice* device) {
    Square square = MakeSquare();
    const float black[3] = {0, 0, 0}, white[4] = {1, 1, 1, 1};
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, square.material, "emissiveFactor", black, 3));
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, square.material, "baseColorFactor", white, 4));
    const float rough = 1, matte = 0;
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, square.material, "roughnessFactor", &rough, 1));
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, square.material, "metallicFactor", &matte, 1));
    uint32_t node = 0, light = 0, camera = 0;
    double matrix[16];
    memcpy(matrix, kIdentity, sizeof matrix);
    matrix[14] = 2.0;
    CHECK_OK(rg_scene_add_node(square.scene, "above", RG_NONE, matrix, &node));
    CHECK_OK(rg_scene_add_light(square.scene, node, RG_LIGHT_POINT, "lamp", &light));
    CHECK_OK(rg_scene_add_camera(square.scene, node, "eye", &camera));
    float intensity = 4, y_fov = 0.2f, value = 0;
    CHECK_OK(rg_scene_set(square.scene, RG_LIGHT, light, "intensity", &intensity, 1));
    CHECK_OK(rg_scene_set(square.scene, RG_CAMERA, camera, "yFov", &y_fov, 1));
    CHECK_OK(rg_scene_get(square.scene, RG_CAMERA, camera, "yFov", &value, 1));
    CHECK(value == y_fov);
    RgSettings* settings = SquareSettings();
    CHECK_OK(rg_settings_set(settings, "camera", "eye"));
    CHECK_OK(rg_settings_set(settings, "background", NULL));
    CHECK_OK(rg_settings_set(settings, "max-depth", "1"));
    RgPicture* picture = Render(device, square.scene, settings);
    RgChannel color = Channel(picture, "color");
    const float lit = Pixel(&color, 4, 4)[1];  // about 4 cd / (pi (2 m)^2)
    CHECK(lit > 0.25f && lit < 0.4f);
    rg_picture_destroy(picture);
    intensity = 8;
    CHECK_OK(rg_scene_set(square.scene, RG_LIGHT, light, "intensity", &intensity, 1));
    picture = Render(device, square.scene, settings);
    color = Channel(picture, "color");
    CHECK(fabsf(Pixel(&color, 4, 4)[1] - 2 * lit) < 1e-3f);
    rg_picture_destroy(picture);

    float map[2 * 4 * 3];
    for (int i = 0; i < 2 * 4 * 3; ++i) map[i] = 3.0f;
    const RgPixels pixels = {
        .struct_size = sizeof pixels, .width = 4, .height = 2, .channels = 3, .data = map};
    CHECK_OK(rg_scene_set_environment(square.scene, &pixels, "sky"));
    CHECK_OK(rg_settings_set(settings, "camera", "0 0 4 0 0 8"));
    picture = Render(device, square.scene, settings);
    color = Channel(picture, "color");
    CHECK(fabsf(Pixel(&color, 4, 4)[1] - 3.0f) < 0.01f);
    rg_picture_destroy(picture);
    map[2 * 4 * 3 - 1] = -1.0f;
    CHECK_FAILS(rg_scene_set_environment(square.scene, &pixels, "sky"), RG_ERROR_USAGE, "-1 is no radiance");
    rg_settings_destroy(settings);
    rg_scene_destroy(square.scene);
}

static void MistakesInArraysAreNamed(void) {
    Square square = MakeSquare();
    uint32_t index = 0;
    float values[4] = {2, 0, 0, 0};
    CHECK_FAILS(rg_scene_set(square.scene, RG_MATERIAL, 0, "roughnessFactor", values, 1), RG_ERROR_USAGE,
                "materials[0]: roughnessFactor is 2, must be 0 to 1");
    CHECK_FAILS(rg_scene_set(square.scene, RG_MATERIAL, 0, "roughness", values, 1), RG_ERROR_USAGE,
                "roughnessFactor");
    CHECK_FAILS(rg_scene_set(square.scene, RG_MATERIAL, 0, "baseColorFactor", values, 3), RG_ERROR_USAGE,
                "has 4 numbers, and 3 are given");
    CHECK_FAILS(rg_scene_set(square.scene, RG_MATERIAL, 0, "doubleSided", values, 1), RG_ERROR_USAGE,
                "doubleSided is 2");
    CHECK_FAILS(rg_scene_set(square.scene, RG_MATERIAL, 9, "doubleSided", values, 1), RG_ERROR_USAGE,
                "material 9 does not exist: there are 1");
    CHECK_FAILS(rg_scene_set(square.scene, RG_MESH, 0, "doubleSided", values, 1), RG_ERROR_USAGE,
                "is no number of a mesh");
    CHECK_FAILS(rg_scene_set(square.scene, 9, 0, "doubleSided", values, 1), RG_ERROR_USAGE, "9 is no kind");
    values[0] = 1;
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, 0, "alphaMode", values, 1));
    CHECK_OK(rg_scene_set(square.scene, RG_MATERIAL, 0, "doubleSided", values, 1));
    values[0] = 0;
    CHECK_OK(rg_scene_get(square.scene, RG_MATERIAL, 0, "alphaMode", values, 1));
    CHECK(values[0] == 1);

    double matrix[16];
    memcpy(matrix, kIdentity, sizeof matrix);
    matrix[3] = 1;
    CHECK_FAILS(rg_scene_set_transform(square.scene, 0, matrix), RG_ERROR_USAGE, "last row");
    matrix[3] = 0;
    matrix[0] = NAN;
    CHECK_FAILS(rg_scene_set_transform(square.scene, 0, matrix), RG_ERROR_USAGE, "not finite");
    CHECK_FAILS(rg_scene_add_node(square.scene, "", 5, NULL, &index), RG_ERROR_USAGE,
                "node 5 does not exist");
    CHECK_FAILS(rg_scene_add_instance(square.scene, square.node, square.mesh, &index), RG_ERROR_USAGE,
                "places a mesh already");
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t indices[3] = {0, 1, 3};
    RgMeshDesc desc = {.struct_size = sizeof desc,
                       .vertex_count = 3,
                       .index_count = 3,
                       .positions = positions,
                       .indices = indices};
    CHECK_FAILS(rg_scene_add_mesh(square.scene, &desc, &index), RG_ERROR_USAGE, "3 is not below the 3");
    desc.index_size = 3;
    CHECK_FAILS(rg_scene_add_mesh(square.scene, &desc, &index), RG_ERROR_USAGE, "index_size is 3");
    desc.indices = NULL;
    CHECK_FAILS(rg_scene_add_mesh(square.scene, &desc, &index), RG_ERROR_USAGE, "indices is NULL");
    desc.index_count = 0;
    desc.tangents = positions;
    desc.tangent_stride = 4;
    CHECK_FAILS(rg_scene_add_mesh(square.scene, &desc, &index), RG_ERROR_USAGE,
                "tangents: they need normals");
    desc.tangents = NULL;
    CHECK_OK(rg_scene_add_mesh(square.scene, &desc, &index));
    const uint8_t texel[4] = {0};
    RgPixels pixels = {.struct_size = sizeof pixels, .width = 1, .height = 1, .channels = 2, .data = texel};
    CHECK_FAILS(rg_scene_set_texture(square.scene, 0, "normalTexture", &pixels), RG_ERROR_USAGE,
                "2 channels");
    CHECK_FAILS(rg_scene_set_texture(square.scene, 0, "normal", &pixels), RG_ERROR_USAGE, "normalTexture");
    rg_scene_destroy(square.scene);
}

// --- Judging ---

static void PicturesAreDenoisedExplainedAndVerified(RgDevice* device, const char* file, const char* folder) {
    RgScene* scene = NULL;
    CHECK_OK(rg_scene_load(file, NULL, &scene));
    RgSettings* settings = SmallSettings();
    CHECK_OK(rg_settings_set(settings, "denoise", "regression"));
    RgPicture* picture = Render(device, scene, settings);
    const RgChannel denoised = Channel(picture, "denoised"), color = Channel(picture, "color");
    CHECK(memcmp(denoised.data, color.data, 24 * 18 * 16) != 0);
    rg_picture_destroy(picture);
    CHECK_OK(rg_settings_set(settings, "denoise", "off"));
    CHECK_OK(rg_settings_set(settings, "aov", "albedo,normal"));
    picture = Render(device, scene, settings);
    CHECK_FAILS(rg_picture_denoise(picture, device, "magic"), RG_ERROR_USAGE, "magic");
    CHECK_OK(rg_picture_denoise(picture, device, "regression"));
    Channel(picture, "denoised");

    char* text = NULL;
    CHECK_OK(rg_explain(device, scene, settings, 12, 9, &text));
    CHECK(text != NULL && strstr(text, "12") != NULL && strchr(text, '\n') != NULL);
    rg_text_free(text);
    CHECK_FAILS(rg_explain(device, scene, settings, 24, 0, &text), RG_ERROR_USAGE, "24");

    char path[4096];
    snprintf(path, sizeof path, "%s/judged.exr", folder);
    CHECK_OK(rg_picture_save(picture, NULL, path));
    RgVerdict verdict = {.struct_size = sizeof verdict};
    const RgVerifyDesc of_file = {.struct_size = sizeof of_file, .max_samples = 64, .path = path};
    CHECK_OK(rg_verify(device, scene, settings, &of_file, &verdict, &text));
    CHECK(verdict.is_right && verdict.reference_samples > 0 && strstr(text, "right") != NULL);
    rg_text_free(text);
    float* dark = calloc(24 * 18 * 3, sizeof(float));
    const RgPixels pixels = {
        .struct_size = sizeof pixels, .width = 24, .height = 18, .channels = 3, .data = dark};
    const RgVerifyDesc of_pixels = {.struct_size = sizeof of_pixels, .max_samples = 64, .pixels = &pixels};
    CHECK_OK(rg_verify(device, scene, settings, &of_pixels, &verdict, &text));
    CHECK(!verdict.is_right && strstr(text, "NOT RIGHT") != NULL);
    rg_text_free(text);
    free(dark);
    const RgVerifyDesc of_nothing = {.struct_size = sizeof of_nothing};
    CHECK_FAILS(rg_verify(device, scene, settings, &of_nothing, &verdict, NULL), RG_ERROR_USAGE,
                "neither or both");
    rg_picture_destroy(picture);
    rg_settings_destroy(settings);
    rg_scene_destroy(scene);
}

static void PicturesAreMergedAndCompared(RgDevice* device, const char* file, const char* folder) {
    RgScene* scene = NULL;
    CHECK_OK(rg_scene_load(file, NULL, &scene));
    RgSettings* settings = SmallSettings();
    RgPicture* whole = Render(device, scene, settings);
    CHECK_OK(rg_settings_set(settings, "spp", "1"));
    RgPicture* first = Render(device, scene, settings);
    CHECK_OK(rg_settings_set(settings, "sample-offset", "1"));
    CHECK_OK(rg_settings_set(settings, "spp", "3"));
    RgPicture* rest = Render(device, scene, settings);

    RgPicture* merged = NULL;
    const RgPicture* parts[3] = {rest, first, rest};
    CHECK_OK(rg_merge(parts, 2, &merged));
    const RgChannel color = Channel(merged, "color"), expected = Channel(whole, "color");
    CHECK(memcmp(color.data, expected.data, 24 * 18 * 16) == 0);
    RgPictureInfo info = {.struct_size = sizeof info};
    CHECK_OK(rg_picture_get_info(merged, &info));
    CHECK(info.samples == 4 && info.seconds == 0);
    RgPicture* none = NULL;
    CHECK_FAILS(rg_merge(parts, 3, &none), RG_ERROR_BAD_INPUT, "pictures[2]");
    CHECK_FAILS(rg_merge(NULL, 1, &none), RG_ERROR_USAGE, "rg_merge: pictures is NULL");
    parts[1] = NULL;
    CHECK_FAILS(rg_merge(parts, 2, &none), RG_ERROR_USAGE, "pictures[1] is NULL");
    CHECK_FAILS(rg_merge(parts, 0, &none), RG_ERROR_USAGE, "");
    CHECK(none == NULL);

    RgDifference difference = {.struct_size = sizeof difference};
    const RgCompared a = {.struct_size = sizeof a, .picture = whole},
                     b = {.struct_size = sizeof b, .picture = rest};
    CHECK_OK(rg_compare(device, &a, &a, 0, &difference));
    CHECK(difference.flip == 0 && difference.relative_mse == 0 && difference.ssim > 0.999);
    CHECK_OK(rg_compare(device, &a, &b, 0, &difference));
    CHECK(difference.flip > 0 && difference.relative_mse > 0 && difference.ssim < 1);
    CHECK(difference.relative_mse_of_noise > 0 && difference.has_noise && difference.z_rms > 0);
    double mean = 0;
    for (uint32_t y = 0; y < 18; ++y)
        for (uint32_t x = 0; x < 24; ++x) mean += Pixel(&expected, x, y)[1] / (24.0 * 18.0);
    CHECK(fabs(difference.mean_of_reference[1] - mean) < 1e-5);
    // The same pictures as a file and as pixels, of which the noise is not known
    char path[4096];
    snprintf(path, sizeof path, "%s/compared.exr", folder);
    CHECK_OK(rg_picture_save(rest, NULL, path));
    const RgPixels pixels = {
        .struct_size = sizeof pixels, .width = 24, .height = 18, .channels = 4, .data = expected.data};
    const RgCompared of_file = {.struct_size = sizeof of_file, .path = path},
                     of_pixels = {.struct_size = sizeof of_pixels, .pixels = &pixels};
    RgDifference again = {.struct_size = sizeof again};
    CHECK_OK(rg_compare(device, &a, &of_file, 0, &again));
    CHECK(fabs(again.flip - difference.flip) < 1e-6 && again.has_noise);
    CHECK_OK(rg_compare(device, &of_pixels, &of_file, 3, &again));
    CHECK(again.relative_mse == difference.relative_mse && again.flip != difference.flip);
    CHECK(again.relative_mse_of_noise < difference.relative_mse_of_noise);
    const RgCompared of_two = {.struct_size = sizeof of_two, .path = path, .picture = whole},
                     of_none = {.struct_size = sizeof of_none};
    CHECK_FAILS(rg_compare(device, &of_two, &b, 0, &again), RG_ERROR_USAGE,
                "reference has a picture, a path");
    CHECK_FAILS(rg_compare(device, &a, &of_none, 0, &again), RG_ERROR_USAGE, "picture has a picture, a path");
    CHECK_FAILS(rg_compare(device, &a, NULL, 0, &again), RG_ERROR_USAGE, "picture is NULL");
    CHECK_FAILS(rg_compare(device, &a, &b, 0, NULL), RG_ERROR_USAGE, "difference is NULL");
    CHECK_OK(rg_settings_set(settings, "size", "12x9"));
    RgPicture* small = Render(device, scene, settings);
    const RgCompared of_small = {.struct_size = sizeof of_small, .picture = small};
    CHECK_FAILS(rg_compare(device, &a, &of_small, 0, &again), RG_ERROR_BAD_INPUT, "12x9");
    rg_picture_destroy(small);
    rg_picture_destroy(merged);
    rg_picture_destroy(rest);
    rg_picture_destroy(first);
    rg_picture_destroy(whole);
    rg_settings_destroy(settings);
    rg_scene_destroy(scene);
}

typedef struct {
    uint32_t count;
    bool is_well_formed;
} Heard;
static void Listen(void* user, RgLogLevel level, const char* category, const char* text) {
    Heard* heard = user;
    ++heard->count;
    heard->is_well_formed = level >= RG_LOG_INFO && level <= RG_LOG_ERROR && category[0] && text[0];
}

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    char version[32];
    snprintf(version, sizeof version, "%d.%d.%d", RG_VERSION_MAJOR, RG_VERSION_MINOR, RG_VERSION_PATCH);
    CHECK(strcmp(rg_version(), version) == 0);
    CHECK(strcmp(rg_last_error(), "") == 0 && rg_last_vk_result() == 0);

    Heard heard = {0, false};
    RgDevice* device = NULL;
    CHECK_OK(rg_device_create(&(RgDeviceDesc){.struct_size = sizeof(RgDeviceDesc),
                                              .validation = 1,
                                              .log = {.callback = Listen, .user = &heard}},
                              &device));
    if (device == NULL) return 1;
    CHECK(heard.count > 0 && heard.is_well_formed);
    WrongUseIsAnError(device, argv[1]);
    StructsMayBeOlderOrNewer(device);
    FileIsRenderedAsByTheProgram(device, argv[1], argv[2]);
    ProgressMayStop(device, argv[1]);
    ProgressMayStopBeforeThereIsASample(device);
    ArraysAreSeenAndEdited(device);
    LightsCamerasAndMapsAreSeen(device);
    MistakesInArraysAreNamed();
    PicturesAreDenoisedExplainedAndVerified(device, argv[1], argv[2]);
    PicturesAreMergedAndCompared(device, argv[1], argv[2]);
    RgDeviceInfo info = {.struct_size = sizeof info};
    CHECK_OK(rg_device_get_info(device, &info));
    CHECK(info.validation_messages == 0 && info.name[0] && info.kind[0]);
    rg_device_destroy(device);
    if (g_failures == 0) puts("all checks passed");
    return g_failures == 0 ? 0 : 1;
}
