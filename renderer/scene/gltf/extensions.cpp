#include "renderer/scene/gltf/extensions.h"

#include <algorithm>
#include <array>

namespace raygraph::scene {
namespace {

constexpr GltfExtension Read(std::string_view name, std::string_view note) {
    return {name, true, note};
}
constexpr GltfExtension Unsupported(std::string_view name, std::string_view why) {
    return {name, false, why};
}

// clang-format off
constexpr std::array kKnown{
    Read("EXT_lights_ies", "point lights with measured profiles"),
    Read("EXT_lights_image_based", "the environment, where --env and --background give none"),
    Read("EXT_mesh_gpu_instancing", "the mesh at each place"),
    Read("EXT_meshopt_compression", "decoded"),
    Unsupported("EXT_texture_avif", "there is no decoder for AVIF"),
    Read("EXT_texture_webp", "decoded"),
    Read("KHR_animation_pointer", "moves what gltf.md lists, at the time of --at"),
    Read("KHR_draco_mesh_compression", "decoded"),
    Unsupported("KHR_gaussian_splatting", "splats are not drawn"),
    Unsupported("KHR_interactivity", "behaviors are not run"),
    Read("KHR_lights_punctual", "point, spot and directional lights"),
    Read("KHR_materials_anisotropy", "stretched highlights"),
    Read("KHR_materials_clearcoat", "a coat over the surface"),
    Read("KHR_materials_diffuse_transmission", "diffuse light passes through"),
    Read("KHR_materials_dispersion", "media refract colors differently"),
    Read("KHR_materials_emissive_strength", "a factor of what is emitted"),
    Read("KHR_materials_ior", "the index of the dielectric"),
    Read("KHR_materials_iridescence", "a thin film over the surface, below the coat and sheen"),
    Read("KHR_materials_pbrSpecularGlossiness", "archived; read as KHR_materials_specular"),
    Read("KHR_materials_retroreflection", "a draft; facets reflect light back to where it came from"),
    Read("KHR_materials_scatter", "a draft; the medium scatters, or a thin surface does"),
    Read("KHR_materials_sheen", "fibers on the surface"),
    Read("KHR_materials_specular", "strength and color of the reflection"),
    Unsupported("KHR_materials_subsurface", "a proposal of 2021: now KHR_materials_volume_scatter"),
    Read("KHR_materials_transmission", "light passes through"),
    Read("KHR_materials_unlit", "shows its base color"),
    Read("KHR_materials_variants", "one is chosen with --variant"),
    Read("KHR_materials_volume", "the medium absorbs"),
    Read("KHR_materials_volume_scatter",
         "the medium scatters; it is homogeneous, so multiscatterColorTexture is not read"),
    Read("KHR_mesh_quantization", "all types of vertices"),
    Read("KHR_meshopt_compression",
         "decoded as by EXT_meshopt_compression: no version 1 of the codec before meshoptimizer 0.23"),
    Read("KHR_node_visibility", "hides nodes and what is below them"),
    Unsupported("KHR_physics_rigid_bodies", "bodies do not move"),
    Read("KHR_texture_basisu", "decoded"),
    Read("KHR_texture_transform", "in every texture"),
    Read("KHR_xmp_json_ld", "metadata, kept when saved"),
    Unsupported("MSFT_lod", "the finest level is shown, whatever the distance"),
    Read("MSFT_texture_dds", "decoded"),
};
// clang-format on
static_assert(std::ranges::is_sorted(kKnown, {}, &GltfExtension::name));

}  // namespace

std::span<const GltfExtension> KnownExtensions() {
    return kKnown;
}

}  // namespace raygraph::scene
