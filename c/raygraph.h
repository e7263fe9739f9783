// raygraph.h: the C interface of Raygraph, for hosts in C11, C++ and languages that call C. docs/c.md has a
// host from top to bottom.
//
// Results. A function that can fail returns an RgResult, RG_OK or what went wrong; rg_last_error has the line
// that says what, of the calling thread. After an error nothing has been written to the outputs. No exception
// leaves the library. A null handle, or a null pointer where a value is needed, is RG_ERROR_USAGE.
//
// Structs. One that begins with `struct_size` may get further fields at its end. Set all of it to zero and
// struct_size to its sizeof: { .struct_size = sizeof(RgDeviceDesc), ... }. Zero is the default of every
// field. A library that is older than the header refuses fields that it does not know, unless they are zero.
// Structs that the library fills are given in the same way; it writes no more than struct_size bytes. Structs
// without struct_size never change.
//
// Handles. What rg_..._create, _load, _adopt, _read and rg_render return is destroyed by the _destroy of its
// type, once, in any order: an object lives until the last of those that were made with it is gone, too. The
// Vulkan objects of a host outlive all handles that were made on them. Destroying NULL does nothing.
//
// Threads. An RgDevice may be used by several threads at once, as may functions of no handle. Everything else
// is used by one thread at a time: a scene, settings or a picture by itself; an RgRenderer together with the
// scenes on its device, viewports, host images and picks. Callbacks are called on the thread that does the
// work, and must not call back into the library, except where it says so.
//
// Texts are UTF-8 and end with a zero. Those that the library returns live as long as their handle, unless it
// says otherwise. Pictures and maps have rows from the top. Units are those of glTF: meters, radians, candela
// and lux; +y is up.
#ifndef RAYGRAPH_H
#define RAYGRAPH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RG_API __attribute__((visibility("default")))

// The version of this header; while the major one is 0, header and library have the same minor version.
#define RG_VERSION_MAJOR 0
#define RG_VERSION_MINOR 2
#define RG_VERSION_PATCH 0

// The value of an index that refers to nothing.
#define RG_NONE 0xFFFFFFFFu

#ifdef __cplusplus
extern "C" {
#endif

// Vulkan's own declarations of its types, which C and C++ let stand beside those of vulkan_core.h: hosts that
// use no Vulkan need no header of it. Formats, layouts and results are the numbers of Vulkan's enumerators.
typedef struct VkInstance_T* VkInstance;
typedef struct VkPhysicalDevice_T* VkPhysicalDevice;
typedef struct VkDevice_T* VkDevice;
typedef struct VkQueue_T* VkQueue;
typedef struct VkCommandBuffer_T* VkCommandBuffer;
typedef struct VkImage_T* VkImage;
typedef struct VkSemaphore_T* VkSemaphore;
typedef struct VkBuffer_T* VkBuffer;
typedef struct VkDeviceMemory_T* VkDeviceMemory;
typedef struct VkBufferCreateInfo VkBufferCreateInfo;
typedef struct VkImageCreateInfo VkImageCreateInfo;
typedef struct VkMemoryRequirements VkMemoryRequirements;
typedef void (*PFN_vkVoidFunction)(void);
typedef PFN_vkVoidFunction (*PFN_vkGetInstanceProcAddr)(VkInstance instance, const char* name);

typedef struct RgRequirements RgRequirements;  // what a physical device needs to be a device of the library
typedef struct RgDevice RgDevice;              // a Vulkan device
typedef struct RgScene RgScene;                // a scene on the host
typedef struct RgSettings RgSettings;          // options by name
typedef struct RgPicture RgPicture;            // a rendered picture
typedef struct RgRenderer RgRenderer;          // frames on a device
typedef struct RgGpuScene RgGpuScene;          // a scene on a device
typedef struct RgViewport RgViewport;          // a view of a scene on a device
typedef struct RgHostImage RgHostImage;        // an image of the host, for a viewport's picture
typedef struct RgPick RgPick;                  // a question about a pixel

// --- Results ---

typedef int32_t RgResult;
enum {
    RG_OK = 0,
    RG_ERROR_USAGE = 1,          // the call asks for something impossible; the line names what and why
    RG_ERROR_BAD_INPUT = 2,      // a file is missing, malformed, hostile or of an unknown kind
    RG_ERROR_IO = 3,             // a file cannot be written
    RG_ERROR_NO_DEVICE = 4,      // no Vulkan device meets the requirements
    RG_ERROR_OUT_OF_MEMORY = 5,  // host or device memory is exhausted
    RG_ERROR_DEVICE_LOST = 6,    // the device stopped; destroy all that was made with it
    RG_ERROR_VULKAN = 7,         // any other call of Vulkan failed: rg_last_vk_result
    RG_ERROR_INTERNAL = 8,       // a fault of the library
    RG_ERROR_STOPPED = 9,        // a callback has ended the call before there was a result
};

// Returns the line of the last error of the calling thread, "" before the first one. It is valid until the
// thread's next call that fails.
RG_API const char* rg_last_error(void);
// Returns the VkResult behind that error, 0 if there was none.
RG_API int32_t rg_last_vk_result(void);
// Returns the version of the library, such as "0.2.0". The text lives as long as the program.
RG_API const char* rg_version(void);
// Frees a text that a function has returned through a `char**`.
RG_API void rg_text_free(char* text);

// --- Messages ---

typedef uint32_t RgLogLevel;
enum {
    RG_LOG_DEFAULT = 0,  // RG_LOG_INFO
    RG_LOG_DEBUG = 1,
    RG_LOG_INFO = 2,
    RG_LOG_WARNING = 3,
    RG_LOG_ERROR = 4,
};

// Takes a message of one line; both texts live as long as the call. It may be called from several threads at
// once, possibly under locks of the device or of the host's queue.
typedef void (*RgLogCallback)(void* user, RgLogLevel level, const char* category, const char* text);

typedef struct RgLog {
    RgLogCallback callback;  // NULL: nobody listens
    void* user;
    RgLogLevel least;  // messages below it are not made
    uint32_t reserved;
} RgLog;

// --- Devices ---

typedef struct RgDeviceDesc {
    uint32_t struct_size;
    uint32_t validation;          // 1: the validation layers check every call
    const char* select;           // an index, or a part of the name; NULL: the most suitable device
    const char* cache_directory;  // of pipelines; NULL: $XDG_CACHE_HOME/raygraph, else ~/.cache/raygraph
    uint64_t memory_limit;        // bytes of device memory that may be used; 0: no limit
    uint32_t frames_in_flight;    // 0: 2
    uint32_t reserved;
    RgLog log;
} RgDeviceDesc;

// Creates a device of the library's own. `desc` may be NULL.
RG_API RgResult rg_device_create(const RgDeviceDesc* desc, RgDevice** device);
// Waits for what renders that were stopped have left behind (RgProgressCallback).
RG_API void rg_device_destroy(RgDevice* device);

// Says what a host's VkDevice has to have. RG_ERROR_NO_DEVICE for a physical device that cannot be used: the
// line says why. `loader` is the function by which `instance` was created, for Vulkan 1.3 or later.
RG_API RgResult rg_requirements_create(PFN_vkGetInstanceProcAddr loader, VkInstance instance,
                                       VkPhysicalDevice physical_device, RgRequirements** requirements);
RG_API void rg_requirements_destroy(RgRequirements* requirements);

// The optional features of a device that the library uses if it may.
typedef uint32_t RgFeatures;
enum {
    RG_FEATURE_RAY_QUERY = 1 << 0,
    RG_FEATURE_POSITION_FETCH = 1 << 1,
    RG_FEATURE_SHADER_CLOCK = 1 << 2,
    RG_FEATURE_INVOCATION_REORDER = 1 << 3,
    RG_FEATURE_OPACITY_MICROMAP = 1 << 4,
    RG_FEATURE_WIREFRAME = 1 << 5,      // fillModeNonSolid
    RG_FEATURE_CLIP_DISTANCE = 1 << 6,  // shaderClipDistance
    RG_FEATURE_MULTI_DRAW_INDIRECT = 1 << 7,
    RG_FEATURE_DRAW_INDIRECT_FIRST_INSTANCE = 1 << 8,
    RG_FEATURE_BUFFER_INT64_ATOMICS = 1 << 9,     // shaderBufferInt64Atomics
    RG_FEATURE_TEXTURE_COMPRESSION_BC = 1 << 10,  // textureCompressionBC
    RG_FEATURE_SAMPLER_ANISOTROPY = 1 << 11,
    RG_FEATURE_PIPELINE_STATISTICS = 1 << 12,  // pipelineExecutableInfo
    RG_FEATURE_MEMORY_BUDGET = 1 << 13,        // VK_EXT_memory_budget
    RG_FEATURE_LAYERED_TARGETS = 1 << 14,      // shaderOutputLayer
};

// Holds what VkDeviceCreateInfo takes. The pointers are those of the RgRequirements.
typedef struct RgDeviceSetup {
    uint32_t struct_size;
    uint32_t queue_family;  // the first one for graphics, compute and transfer
    // VkPhysicalDeviceFeatures2 with its chain, for pNext: all that is required, and the optional features
    // that the device has. A host may set more flags in it, and chain more behind it.
    void* features;
    const char* const* extensions;
    uint32_t extension_count;
    RgFeatures optional_features;  // those in the chain
    // Families for other queues, whose work can run beside graphics; RG_NONE: the device has none.
    uint32_t compute_family;
    uint32_t transfer_family;
} RgDeviceSetup;
RG_API RgResult rg_requirements_get(const RgRequirements* requirements, RgDeviceSetup* setup);

typedef uint32_t RgMemoryKind;
enum {
    RG_MEMORY_DEVICE = 0,    // fast on the device, not mapped
    RG_MEMORY_UPLOAD = 1,    // mapped, written by the CPU in order, read by the device
    RG_MEMORY_READBACK = 2,  // mapped and cached, written by the device, read by the CPU
};

// Describes the memory of one resource, or of a block that several share.
typedef struct RgMemoryRequest {
    uint32_t struct_size;
    // Mapped kinds need memory that is host-visible and host-coherent. RG_MEMORY_DEVICE should be
    // device-local, but may be other memory when that is full.
    RgMemoryKind kind;
    const char* name;               // of the resource or block; it lives as long as the call
    uint64_t alignment;             // bytes, beside the alignment of the requirements
    uint32_t must_be_device_local;  // 1: never other memory
    uint32_t is_only_copied;  // 1: no shader accesses it, so that mapped memory need not be near the device
    uint32_t is_dedicated;    // 1: it is large and lives long: an allocation of its own
    uint32_t reserved;
} RgMemoryRequest;

typedef struct RgMemory {
    uint32_t struct_size;
    uint32_t memory_type;  // its index in VkPhysicalDeviceMemoryProperties
    VkDeviceMemory memory;
    uint64_t offset;  // bytes in `memory`
    uint64_t size;    // bytes
    void* mapped;     // where the CPU sees it, of mapped kinds
    void* handle;     // for the host's own use
} RgMemory;

// Gives the memory of a host that manages all of it. Called from any thread, several at once. The first three
// return the VkResult of the call that failed, and have then created nothing. They fill `memory`, which is
// zero but for its struct_size. Memory of buffers and blocks is allocated with
// VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT.
typedef struct RgMemoryAllocator {
    uint32_t struct_size;
    uint32_t reserved;
    void* user;
    // Create the resource, and bind memory to it. The library destroys it before it frees the memory, both
    // without VkAllocationCallbacks.
    int32_t (*create_buffer)(void* user, const VkBufferCreateInfo* info, const RgMemoryRequest* request,
                             VkBuffer* buffer, RgMemory* memory);
    int32_t (*create_image)(void* user, const VkImageCreateInfo* info, const RgMemoryRequest* request,
                            VkImage* image, RgMemory* memory);
    // Allocates a block, to which the library binds images and buffers at its offset.
    int32_t (*allocate)(void* user, const VkMemoryRequirements* requirements, const RgMemoryRequest* request,
                        RgMemory* memory);
    void (*free)(void* user, const RgMemory* memory);
} RgMemoryAllocator;

// The objects of a host, which outlive the device and all that is made with it.
typedef struct RgAdoptDesc {
    uint32_t struct_size;
    uint32_t queue_family;
    PFN_vkGetInstanceProcAddr loader;
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    VkQueue queue;  // for graphics, compute and transfer
    // Queues for passes that may run beside others, and for uploads; NULL: the work goes to the first queue.
    VkQueue compute_queue;
    VkQueue transfer_queue;
    uint32_t compute_family;
    uint32_t transfer_family;
    const char* const* extensions;  // the device extensions that the host has enabled
    uint32_t extension_count;
    RgFeatures optional_features;  // those that the host has enabled: Vulkan cannot be asked for them
    uint32_t debug_utils;          // 1: the instance has VK_EXT_debug_utils, and objects get names
    uint32_t frames_in_flight;     // 0: 2
    // Called around every use of a queue, where other threads of the host use them, too; both or neither.
    void (*lock_queue)(void* user);
    void (*unlock_queue)(void* user);
    void* lock_user;
    const char* cache_directory;  // of pipelines; NULL: none is kept
    uint64_t memory_limit;        // bytes of device memory that may be used; 0: no limit
    RgLog log;
    // Copied; what it points to outlives the device. NULL: the library allocates device memory itself.
    const RgMemoryAllocator* allocator;
} RgAdoptDesc;
// RG_ERROR_NO_DEVICE names what the host's device lacks.
RG_API RgResult rg_device_adopt(const RgAdoptDesc* desc, RgDevice** device);

typedef struct RgDeviceInfo {
    uint32_t struct_size;
    uint32_t validation_messages;  // so far; of an adopted device they reach the host's own messenger
    const char* name;
    const char* driver;
    const char* kind;      // "cpu", "integrated", "discrete", "virtual" or "other"
    uint64_t memory_used;  // bytes of device memory
} RgDeviceInfo;
RG_API RgResult rg_device_get_info(const RgDevice* device, RgDeviceInfo* info);

// Names a submission on a device. A value alone says nothing: several queues count by themselves.
typedef struct RgToken {
    uint32_t queue;  // 0 the first, 1 for compute, 2 for transfers
    uint32_t reserved;
    uint64_t value;  // 0: no work
} RgToken;
// The host's command buffer with this token (rg_frame_record) has completed: its fence or semaphore says so.
RG_API RgResult rg_device_complete(RgDevice* device, RgToken token);
RG_API RgResult rg_device_has_completed(const RgDevice* device, RgToken token, bool* has_completed);
// Waits until it has. RG_ERROR_USAGE for a buffer of the host that it has not completed.
RG_API RgResult rg_device_wait(RgDevice* device, RgToken token);

typedef struct RgSemaphoreUse {
    VkSemaphore semaphore;
    uint64_t value;  // of a timeline semaphore; 0 of a binary one
} RgSemaphoreUse;
// Returns that for which submissions of the host can wait. It never tells of command buffers of the host.
RG_API RgResult rg_device_after(const RgDevice* device, RgToken token, RgSemaphoreUse* use);

// --- Scenes ---

typedef struct RgLoadDesc {
    uint32_t struct_size;
    uint32_t reserved;
    const char* scene;        // of the file, by name or index; NULL: its default
    const char* variant;      // of the materials, by name or index; NULL: none
    const char* points;       // the radius that points are given, in meters or as "0.2%" of the scene's size;
    const char* lines;        // the same of lines; NULL: left out
    const char* environment;  // an equirectangular .hdr or .exr; NULL: none
    const char* root;         // the folder that files named by the scene are confined to; NULL: its own
    RgLog log;                // of what was skipped or repaired
} RgLoadDesc;

// Loads a glTF file, .gltf or .glb. `desc` may be NULL. RG_ERROR_BAD_INPUT names the file and the mistake.
RG_API RgResult rg_scene_load(const char* path, const RgLoadDesc* desc, RgScene** scene);
// Creates an empty scene. Pictures record `name` as that of its file.
RG_API RgResult rg_scene_create(const char* name, RgScene** scene);
RG_API void rg_scene_destroy(RgScene* scene);

// The kinds of objects, each of which is known by its index from 0 on.
typedef uint32_t RgObject;
enum {
    RG_NODE = 0,  // places what it has, and the nodes below it
    RG_MESH = 1,
    RG_MATERIAL = 2,
    RG_INSTANCE = 3,  // a mesh placed by a node
    RG_LIGHT = 4,
    RG_CAMERA = 5,
};
RG_API RgResult rg_scene_count(const RgScene* scene, RgObject kind, uint32_t* count);
// The first object of this name; instances have that of their node. RG_ERROR_USAGE if there is none.
RG_API RgResult rg_scene_find(const RgScene* scene, RgObject kind, const char* name, uint32_t* index);
// `name` lives until the object gets another one or the scene is gone.
RG_API RgResult rg_scene_get_name(const RgScene* scene, RgObject kind, uint32_t index, const char** name);

// Numbers of an object by the name that glTF has for them:
//   materials: "baseColorFactor" (4), "metallicFactor", "roughnessFactor", "emissiveFactor" (3),
//              "doubleSided", and all others of the extensions that are read (docs/c.md); "alphaMode" is 0
//              opaque, 1 mask, 2 blend
//   lights:    "color" (3), "intensity" in cd or, of a directional one, lx, "range", "innerConeAngle",
//              "outerConeAngle"
//   cameras:   "yFov" in radians, or "xMag" and "yMag" of an orthographic one
//   nodes:     "visible"
// A flag is 0 or 1. RG_ERROR_USAGE for another name or another count, and for numbers out of range, which the
// line says; then nothing changes.
RG_API RgResult rg_scene_set(RgScene* scene, RgObject kind, uint32_t index, const char* name,
                             const float* values, uint32_t count);
RG_API RgResult rg_scene_get(const RgScene* scene, RgObject kind, uint32_t index, const char* name,
                             float* values, uint32_t count);

// Matrices are those of glTF: 16 numbers, column by column, so that the translation is in 12 to 14. They are
// double, so that places far from the origin keep their digits. The last row is 0, 0, 0, 1.
RG_API RgResult rg_scene_set_transform(RgScene* scene, uint32_t node, const double matrix[16]);
RG_API RgResult rg_scene_get_transform(const RgScene* scene, uint32_t node, double matrix[16]);
RG_API RgResult rg_scene_get_world_transform(const RgScene* scene, uint32_t node, double matrix[16]);

// Adds a node, below a parent or, with RG_NONE, at the top. `matrix` may be NULL: the identity.
RG_API RgResult rg_scene_add_node(RgScene* scene, const char* name, uint32_t parent, const double matrix[16],
                                  uint32_t* node);
// Adds glTF's default material.
RG_API RgResult rg_scene_add_material(RgScene* scene, const char* name, uint32_t* material);

// Arrays of triangles, which are copied. Strides are bytes from one vertex to the next; 0: without gaps.
typedef struct RgMeshDesc {
    uint32_t struct_size;
    uint32_t material;
    const char* name;
    uint32_t vertex_count;
    uint32_t index_count;
    const float* positions;  // 3 a vertex
    const float* normals;    // 3; NULL: those of the triangles
    const float* uvs;        // 2, (0, 0) is the upper left corner of a texture; may be NULL
    const float* colors;     // 4, linear; may be NULL
    const float* tangents;   // 4, for normal maps, w is the sign of the bitangent; may be NULL
    uint64_t position_stride;
    uint64_t normal_stride;
    uint64_t uv_stride;
    uint64_t color_stride;
    uint64_t tangent_stride;
    // Counter-clockwise from the front; NULL, with an index_count of 0: each three vertices are a triangle.
    const void* indices;
    uint32_t index_size;  // bytes: 2 or 4; 0: 4
    uint32_t reserved;
} RgMeshDesc;
RG_API RgResult rg_scene_add_mesh(RgScene* scene, const RgMeshDesc* desc, uint32_t* mesh);
// Lets a node, which has none, place a mesh.
RG_API RgResult rg_scene_add_instance(RgScene* scene, uint32_t node, uint32_t mesh, uint32_t* instance);

typedef uint32_t RgLightKind;
enum { RG_LIGHT_DIRECTIONAL = 0, RG_LIGHT_POINT = 1, RG_LIGHT_SPOT = 2 };
// Lights shine, and cameras look, along -z of their node.
RG_API RgResult rg_scene_add_light(RgScene* scene, uint32_t node, RgLightKind kind, const char* name,
                                   uint32_t* light);
RG_API RgResult rg_scene_add_camera(RgScene* scene, uint32_t node, const char* name, uint32_t* camera);

// Texels, which are copied.
typedef struct RgPixels {
    uint32_t struct_size;
    uint32_t width;
    uint32_t height;
    uint32_t channels;    // 3 or 4
    uint64_t row_stride;  // bytes from one row to the next; 0: without gaps
    const void* data;     // uint8_t of a texture, float of radiance
} RgPixels;
// Sets the texture "baseColorTexture", "normalTexture" and so on of a material. Colors are sRGB, as in glTF.
// `pixels` may be NULL: none.
RG_API RgResult rg_scene_set_texture(RgScene* scene, uint32_t material, const char* name,
                                     const RgPixels* pixels);
// Lights the scene by an equirectangular map of linear radiance; pictures record `name` as that of its file.
RG_API RgResult rg_scene_set_environment(RgScene* scene, const RgPixels* pixels, const char* name);
RG_API RgResult rg_scene_load_environment(RgScene* scene, const char* path, const RgLog* log);

// --- Settings ---
// Options of `raygraph render` by their names without dashes, with their texts: "size" "640x360", "spp" "64",
// "max-depth" "8", "camera" "Camera 1" or "eye target up fov", "background" "0,0,0" (docs/cli.md). Those that
// are no setting of the linear picture: "spp", "time", "error", "sample-offset", "aov" (a list with commas),
// "denoise" ("on", "off" or the name of a denoiser), "exposure", "tonemap", "white-point".

RG_API RgResult rg_settings_create(RgSettings** settings);
RG_API void rg_settings_destroy(RgSettings* settings);
// `text` may be NULL: the default. RG_ERROR_USAGE for an unknown name and a malformed text; then nothing
// changes.
RG_API RgResult rg_settings_set(RgSettings* settings, const char* name, const char* text);
// Returns the text of a setting, that of the default if none was set. It lives until the setting changes.
RG_API RgResult rg_settings_get(const RgSettings* settings, const char* name, const char** text);
// Returns the name with this index, NULL beyond the last one. Names live as long as the program.
RG_API const char* rg_setting_name(uint32_t index);

// --- Rendering offline ---

typedef struct RgProgress {
    uint32_t struct_size;
    uint32_t samples;         // of the picture, so far
    uint32_t samples_wanted;  // 0: until the time is up
    uint32_t reserved;
    double samples_per_second;  // over all pixels; 0: not known yet
    double relative_error;      // below 0: not known
    double seconds_left;        // below 0: not known
} RgProgress;
// Is called on the thread in rg_render: some times a second, with 0 samples, until there is one, and after
// each sample. False ends the render with what there is; without a sample the call returns RG_ERROR_STOPPED
// at once, and what cannot be ended, such as a shader that the driver compiles, goes on on another thread,
// until rg_device_destroy has waited for it.
typedef bool (*RgProgressCallback)(void* user, const RgProgress* progress);

// Renders a picture with the bits of `raygraph render` on the same device. `settings` may be NULL; without
// "spp", "time" and "error" it has 64 samples. `progress` may be NULL. It waits for the picture.
RG_API RgResult rg_render(RgDevice* device, RgScene* scene, const RgSettings* settings,
                          RgProgressCallback progress, void* user, RgPicture** picture);
// Merges pictures of different samples of one picture: the result has the bits of one render of all of them.
// RG_ERROR_BAD_INPUT names the first difference.
RG_API RgResult rg_merge(const RgPicture* const* pictures, uint32_t count, RgPicture** merged);
// Reads an .exr that rg_picture_save or `raygraph render` has written.
RG_API RgResult rg_picture_read(const char* path, RgPicture** picture);
RG_API void rg_picture_destroy(RgPicture* picture);

typedef struct RgPictureInfo {
    uint32_t struct_size;
    uint32_t width;
    uint32_t height;
    uint32_t was_stopped;  // 1: by the progress callback
    uint64_t samples;
    double relative_error;  // standard error of a pixel over the picture's mean; below 0: not known
    double seconds;         // of sampling; 0 for a picture that was read or merged
} RgPictureInfo;
RG_API RgResult rg_picture_get_info(const RgPicture* picture, RgPictureInfo* info);

typedef uint32_t RgNumber;
enum { RG_FLOAT32 = 0, RG_UINT32 = 1, RG_UINT8 = 2 };
// An array of a picture, in its memory.
typedef struct RgChannel {
    uint32_t struct_size;
    RgNumber number;
    uint32_t width;
    uint32_t height;
    uint32_t channels;      // numbers of a pixel
    uint32_t pixel_stride;  // bytes from one pixel to the next; rows have no gaps
    const void* data;
} RgChannel;
// "color" (radiance and coverage, the mean over the samples), "denoised", "variance" (of one sample), and the
// AOVs: "albedo", "normal", "depth" (meters along the view, infinite where nothing is hit), "instance" and
// "material" (RG_NONE there) and so on. RG_ERROR_USAGE lists those that the picture has.
RG_API RgResult rg_picture_get_channel(const RgPicture* picture, const char* name, RgChannel* channel);
// Returns the name with this index, NULL beyond the last one.
RG_API const char* rg_picture_channel_name(const RgPicture* picture, uint32_t index);

// Denoises a picture that has the AOV "denoising", or "albedo" and "normal": "denoised" and the display are
// made again, the latter as for a picture that was read, and channels that were asked for before are gone.
// `denoiser` may be NULL: the default. RG_ERROR_BAD_INPUT for a picture that cannot be denoised.
RG_API RgResult rg_picture_denoise(RgPicture* picture, RgDevice* device, const char* denoiser);
// The picture as a screen shows it: sRGB, 4 RG_UINT8 a pixel. Of a picture that was read or merged it is made
// by `device`, which may be NULL for others.
RG_API RgResult rg_picture_display(RgPicture* picture, RgDevice* device, RgChannel* channel);
// Writes a .png or .jpg of the display, an .exr with all channels that can be resumed and merged, or an .hdr.
// The file appears whole or not at all. `device` as of rg_picture_display.
RG_API RgResult rg_picture_save(RgPicture* picture, RgDevice* device, const char* path);

// --- Judging pictures ---

// Says why a pixel of rg_render with these settings has its color, as `raygraph explain` prints it. Free the
// text with rg_text_free.
RG_API RgResult rg_explain(RgDevice* device, RgScene* scene, const RgSettings* settings, uint32_t x,
                           uint32_t y, char** text);

// A picture to be compared: one of the three.
typedef struct RgCompared {
    uint32_t struct_size;
    uint32_t reserved;
    const RgPicture* picture;
    const char* path;        // .exr, .hdr or .png
    const RgPixels* pixels;  // linear radiance (float), whose noise is not known
} RgCompared;
// The numbers of `raygraph compare`.
typedef struct RgDifference {
    uint32_t struct_size;
    uint32_t has_noise;            // 1: the variance of a picture is known; 0: those that begin with z_ are 0
    double relative_mse;           // mean of (picture - reference)^2 / (reference^2 + 0.01)
    double relative_mse_of_noise;  // what the known noise adds to it
    double flip;
    double ssim;
    double mean_of_reference[3];  // linear
    double mean[3];
    double z_rms;                      // difference over noise; 1 where noise is all that there is
    double z_beyond_three;             // share beyond 3; 0.0027 then
    double z_of_mean[3];               // of the mean over the picture
    uint64_t z_differs_without_noise;  // values that differ although neither picture has noise there
} RgDifference;
// Compares two pictures of one size. FLIP and SSIM see them with this exposure, in stops.
RG_API RgResult rg_compare(RgDevice* device, const RgCompared* reference, const RgCompared* picture,
                           float exposure, RgDifference* difference);

typedef struct RgVerifyDesc {
    uint32_t struct_size;
    uint32_t max_samples;  // of the reference; 0: 1024
    // The picture: a file, or linear radiance (float) whose noise is estimated. One of the two.
    const char* path;
    const RgPixels* pixels;
    double tolerance;             // relative error of a tile or pixel that is right; 0: 0.05
    const char* cache_directory;  // keeps references; NULL: none
} RgVerifyDesc;
typedef struct RgVerdict {
    uint32_t struct_size;
    uint32_t is_right;    // 1: it differs from the reference by no more than noise and tolerance
    uint32_t is_decided;  // 1: more samples of the reference would hardly change that
    uint32_t reserved;
    uint64_t reference_samples;
    double relative_mse;
    double flip;
    double ssim;
} RgVerdict;
// Renders a reference until it can judge the picture. `text`, which may be NULL, gets the verdict in lines,
// with what is off; free it with rg_text_free.
RG_API RgResult rg_verify(RgDevice* device, RgScene* scene, const RgSettings* settings,
                          const RgVerifyDesc* desc, RgVerdict* verdict, char** text);

// --- Viewports ---
// A frame: rg_frame_begin, rg_viewport_show for each viewport, and rg_frame_execute or rg_frame_record.

RG_API RgResult rg_renderer_create(RgDevice* device, RgRenderer** renderer);
RG_API void rg_renderer_destroy(RgRenderer* renderer);

// Puts a copy of the scene, in its rest pose, on the renderer's device. Instances have the indices of the
// scene, without those that are scaled to nothing in that pose.
RG_API RgResult rg_gpu_scene_create(RgRenderer* renderer, RgScene* scene, RgGpuScene** gpu_scene);
RG_API void rg_gpu_scene_destroy(RgGpuScene* gpu_scene);
// Replaces all of it. After an error the scene before it is shown as before.
RG_API RgResult rg_gpu_scene_set(RgGpuScene* gpu_scene, RgScene* scene);
// Applies what has been edited in the scene that was set: transforms and visibility of nodes, numbers of
// materials and lights. RG_ERROR_USAGE if objects or textures were added: those need rg_gpu_scene_set.
RG_API RgResult rg_gpu_scene_update(RgGpuScene* gpu_scene, RgScene* scene);
// Moves instances, without a scene in between: `matrices` has 16 numbers for each, from object to world.
RG_API RgResult rg_gpu_scene_set_transforms(RgGpuScene* gpu_scene, const uint32_t* instances,
                                            const double* matrices, uint32_t count);

typedef struct RgViewportDesc {
    uint32_t struct_size;
    uint32_t width;  // pixels
    uint32_t height;
    uint32_t reserved;
    const char* name;  // unique among the viewports of the renderer; NULL: "viewport"
} RgViewportDesc;
// The camera is that of the scene, or frames its bounds.
RG_API RgResult rg_viewport_create(RgGpuScene* gpu_scene, const RgViewportDesc* desc, RgViewport** viewport);
RG_API void rg_viewport_destroy(RgViewport* viewport);
// A size without area shows nothing.
RG_API RgResult rg_viewport_set_size(RgViewport* viewport, uint32_t width, uint32_t height);

typedef struct RgCamera {
    uint32_t struct_size;
    uint32_t is_orthographic;
    double eye[3];
    double target[3];
    float up[3];           // zero: +y
    float y_fov;           // perspective: vertical angle in radians; 0: 40 degrees
    float height;          // orthographic: meters seen from bottom to top
    float aperture;        // radius of the lens in meters; 0: a pinhole
    float focus_distance;  // meters; 0: that of the target
    float z_near;          // meters, of raster views; 0: 0.01
} RgCamera;
RG_API RgResult rg_viewport_set_camera(RgViewport* viewport, const RgCamera* camera);

typedef uint32_t RgView;
enum {
    RG_VIEW_PATH_TRACED = 0,
    RG_VIEW_RASTER = 1,
    RG_VIEW_WIPE = 2,  // path-traced left of a line, raster right of it
    RG_VIEW_SIDE_BY_SIDE = 3,
    RG_VIEW_DIFFERENCE = 4,
    RG_VIEW_RELATIVE_ERROR = 5,
    RG_VIEW_FLIP = 6,
    RG_VIEW_REAL_TIME = 8,  // path-traced, without most of the noise while something moves
};
RG_API RgResult rg_viewport_set_view(RgViewport* viewport, RgView view);
// Takes the settings that a viewport has: how paths are traced, "camera" if it was set, the lens, the light
// from infinity, "denoise", "exposure" and "tonemap". It shows the picture of rg_render with them, but for
// the size.
RG_API RgResult rg_viewport_set_settings(RgViewport* viewport, const RgSettings* settings);

// Limits the work of a frame.
typedef struct RgBudget {
    uint32_t struct_size;
    uint32_t samples_per_frame;  // 0: with a limit as many as fit, else one
    double frame_ms;             // of device time; 0: no limit
    uint32_t max_samples;        // the picture is complete with these; 0: never
    uint32_t never_waits;        // 1: shows a preview while pipelines are made, which takes seconds
} RgBudget;
RG_API RgResult rg_viewport_set_budget(RgViewport* viewport, const RgBudget* budget);

typedef struct RgViewportProgress {
    uint32_t struct_size;
    uint32_t samples;           // of the path-traced picture, in every pixel
    uint32_t denoised_samples;  // of the denoised picture that is shown; 0: none is
    uint32_t is_preview;  // 1: the picture has no samples of the scene, because pipelines are being made
    double frame_ms;      // of device time, of the last measured frame; 0: not known
} RgViewportProgress;
RG_API RgResult rg_viewport_get_progress(const RgViewport* viewport, RgViewportProgress* progress);

// An image of the host that a viewport's picture is shown in.
typedef struct RgHostImageDesc {
    uint32_t struct_size;
    uint32_t width;
    uint32_t height;
    // A VkFormat. VK_FORMAT_R8G8B8A8_UNORM and _SRGB: the image needs VK_IMAGE_USAGE_TRANSFER_DST_BIT, all
    // others VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT. Texels are display-encoded; in an sRGB format the decoded
    // values are.
    int32_t format;
    VkImage image;
    int32_t layout_after;  // the VkImageLayout in which the host gets it back; 0: SHADER_READ_ONLY_OPTIMAL
    uint32_t reserved;
} RgHostImageDesc;
RG_API RgResult rg_host_image_create(RgDevice* device, const RgHostImageDesc* desc, RgHostImage** image);
RG_API void rg_host_image_destroy(RgHostImage* image);
// Tells that the host has left the image in this VkImageLayout since it was shown. Between two frames.
RG_API RgResult rg_host_image_return(RgHostImage* image, int32_t layout);

// Semaphores of the host for the submission of rg_frame_execute; rg_frame_record has none.
typedef struct RgSemaphores {
    uint32_t struct_size;
    uint32_t wait_count;
    const RgSemaphoreUse* waits;
    const RgSemaphoreUse* signals;
    uint32_t signal_count;
    uint32_t reserved;
} RgSemaphores;

// Waits until at most frames_in_flight - 1 frames are pending, then opens a frame. A frame that is open is
// dropped. RG_ERROR_USAGE where it would wait for a command buffer of the host that it has not completed.
RG_API RgResult rg_frame_begin(RgRenderer* renderer);
// Tells whether rg_frame_begin would wait now.
RG_API RgResult rg_frame_would_block(const RgRenderer* renderer, bool* would_block);
// Declares the viewport's passes, and that its picture replaces the contents of the image, whose size is the
// viewport's. `semaphores` may be NULL. Without area it shows nothing. After an error, drop the frame.
RG_API RgResult rg_viewport_show(RgViewport* viewport, RgHostImage* image, const RgSemaphores* semaphores);
// Submits the frame. After an error the frame is dropped, and images are as before it.
RG_API RgResult rg_frame_execute(RgRenderer* renderer, RgToken* token);
// Records the frame into a primary command buffer of the host, of the device's queue family, in the recording
// state and outside of rendering; what was bound in it is lost. The host submits it exactly once, before
// later frames, and calls rg_device_complete with the token when its fence has been signaled: until then the
// frame is in flight. After an error the frame is dropped, and the host resets the buffer.
RG_API RgResult rg_frame_record(RgRenderer* renderer, VkCommandBuffer commands, RgToken* token);
RG_API RgResult rg_frame_drop(RgRenderer* renderer);

// Asks what is seen at the center of a pixel. A later frame answers; asking and polling never wait.
RG_API RgResult rg_viewport_pick(RgViewport* viewport, uint32_t x, uint32_t y, RgPick** pick);
typedef struct RgPickResult {
    uint32_t struct_size;
    uint32_t is_hit;  // 1: a surface is seen, and the other fields are valid
    uint32_t instance;
    uint32_t material;
    float position[3];  // in the world
    float normal[3];
    float depth;         // meters along the view
    uint32_t primitive;  // triangle
} RgPickResult;
// `is_ready` gets whether there is an answer, which is then in `result`.
RG_API RgResult rg_pick_poll(RgPick* pick, bool* is_ready, RgPickResult* result);
RG_API void rg_pick_destroy(RgPick* pick);

#ifdef __cplusplus
}
#endif

#endif  // RAYGRAPH_H
