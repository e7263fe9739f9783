#include "renderer/scene/extensions.h"

#include <algorithm>
#include <array>

namespace raygraph::scene {
namespace {

constexpr GltfExtension Read(std::string_view name, std::string_view test, std::string_view note) {
    return {name, true, note, test};
}
constexpr GltfExtension NotRead(std::string_view name, std::string_view why) {
    return {name, false, why, {}};
}

// clang-format off
constexpr std::array kKnown{
    Read("EXT_lights_ies", "IesLightScene.IrradianceOnAPlaneIsThatOfTheProfile",
         "point lights with measured profiles"),
    Read("EXT_lights_image_based", "ImageLightScene.LightsTheSceneFromEachSideAsItsFileSays",
         "the environment, where --env and --background give none"),
    Read("EXT_mesh_gpu_instancing", "Instancing.EachIsTranslatedAfterRotationAfterScaleWithinItsNode",
         "the mesh at each place"),
    Read("EXT_meshopt_compression", "Meshopt.AttributesAndTrianglesAreWhatWasEncoded", "decoded"),
    NotRead("EXT_texture_avif", "there is no decoder for AVIF"),
    Read("EXT_texture_webp", "Textures.WebpExtensionsImageIsPreferred", "decoded"),
    Read("KHR_animation_pointer", "AnimationPointer.ShowsInAFrozenScene",
         "moves what gltf.md lists, at the time of --at"),
    Read("KHR_draco_mesh_compression", "Draco.EveryMethodGivesBackTheMesh", "decoded"),
    NotRead("KHR_gaussian_splatting", "splats are not drawn"),
    NotRead("KHR_interactivity", "behaviors are not run"),
    Read("KHR_lights_punctual", "ImportedScene.EveryKindOfPunctualLightLightsAsItsFileSays",
         "point, spot and directional lights"),
    Read("KHR_materials_anisotropy", "TraceAnisotropy.Trace_FilesHighlightLiesAsTheFileSays",
         "stretched highlights"),
    Read("KHR_materials_clearcoat", "TraceClearcoat.Trace_CoatReflectsAndDimsWhatIsBelow",
         "a coat over the surface"),
    Read("KHR_materials_diffuse_transmission",
         "TraceDiffuseTransmission.Trace_LampBehindASheetLightsItsFront", "diffuse light passes through"),
    Read("KHR_materials_dispersion", "TraceDispersion.Trace_BluePassesAtAnotherAngleThanRed",
         "media refract colors differently"),
    Read("KHR_materials_emissive_strength", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord",
         "a factor of what is emitted"),
    Read("KHR_materials_ior", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord",
         "the index of the dielectric"),
    Read("KHR_materials_iridescence", "TraceIridescence.Trace_ThinFilmReflectsByItsThickness",
         "a thin film over the surface, below the coat and sheen"),
    Read("KHR_materials_pbrSpecularGlossiness", "Glossiness.PictureIsThatOfTheSameMaterialSaidOtherwise",
         "archived; read as KHR_materials_specular"),
    Read("KHR_materials_retroreflection",
         "TraceRetroreflection.Trace_LampAtTheCameraIsSeenInTheSurface",
         "a draft; facets reflect light back to where it came from"),
    Read("KHR_materials_sheen", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord", "fibers on the surface"),
    Read("KHR_materials_specular", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord",
         "strength and color of the reflection"),
    NotRead("KHR_materials_subsurface", "a proposal of 2021: now KHR_materials_volume_scatter"),
    Read("KHR_materials_transmission", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord",
         "light passes through"),
    Read("KHR_materials_unlit", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord", "shows its base color"),
    Read("KHR_materials_variants", "ImportedVariants.PictureIsOfTheMaterialsOfTheVariant",
         "one is chosen with --variant"),
    Read("KHR_materials_volume", "ImportedScene.EveryFactorOfAMaterialIsInItsRecord", "the medium absorbs"),
    Read("KHR_materials_volume_scatter", "TraceScattering.Trace_MediumReturnsLightByItsAlbedo",
         "the medium scatters; it is homogeneous, so multiscatterColorTexture is not read"),
    Read("KHR_mesh_quantization", "Quantization.NodeScalesTheMeshBack", "all types of vertices"),
    Read("KHR_meshopt_compression", "Meshopt.AttributesAndTrianglesAreWhatWasEncoded",
         "decoded as by EXT_meshopt_compression: no version 1 of the codec before meshoptimizer 0.23"),
    Read("KHR_node_visibility", "ImportedNodes.HiddenNodesAreNotSeenAndDoNotShine",
         "hides nodes and what is below them"),
    NotRead("KHR_physics_rigid_bodies", "bodies do not move"),
    Read("KHR_texture_basisu", "TextureExtensions.ImageOfTheExtensionIsReadAndRequiredOnesLoad", "decoded"),
    Read("KHR_texture_transform", "MaterialTextures.TransformsScaleThenRotateThenMove", "in every texture"),
    Read("KHR_xmp_json_ld", "SaveGltf.MetadataIsKeptWhereItWas", "metadata, kept when saved"),
    NotRead("MSFT_lod", "the finest level is shown, whatever the distance"),
    Read("MSFT_texture_dds", "TextureExtensions.ImageOfTheExtensionIsReadAndRequiredOnesLoad", "decoded"),
};
// clang-format on
static_assert(std::ranges::is_sorted(kKnown, {}, &GltfExtension::name));

}  // namespace

std::span<const GltfExtension> KnownExtensions() {
    return kKnown;
}

}  // namespace raygraph::scene
