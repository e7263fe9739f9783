// The rows. Ranges are glTF's, but where a picture can be had of what is out of them.
#include <array>
#include <glm/gtc/constants.hpp>

#include "renderer/scene/gltf/choice_names.h"
#include "renderer/scene/gltf/document.h"
#include "renderer/scene/gltf/lights.h"
#include "renderer/scene/gltf/meshes.h"
#include "renderer/scene/gltf/schema.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {
namespace {

using namespace schema;

constexpr TextRow kName = Text("name").OrOmittedIfInvalid("name", "left out");

// --- Buffers and accessors ---

constexpr auto kBuffer =
    Table(Whole("byteLength").AtLeast(1).Required(), Text("uri"), Extensions(ExtensionPlace::Buffer));

constexpr auto kBufferView =
    Table(Index("buffer", Target::Buffers).Required(), Whole("byteOffset"),
          Whole("byteLength").AtLeast(1).Required(), Whole("byteStride").Between(4, 252),
          Extensions(ExtensionPlace::BufferView));

// EXT_meshopt_compression and KHR_meshopt_compression. tinygltf keeps numbers of extensions as doubles.
constexpr uint64_t kMaxExact = uint64_t{1} << 53;
constexpr auto kMeshoptBuffer = Table(Flag("fallback"));
constexpr std::array<std::string_view, 3> kMeshoptModes{"ATTRIBUTES", "TRIANGLES", "INDICES"};
constexpr std::array<std::string_view, 4> kExtFilters{"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
constexpr std::array<std::string_view, 5> kKhrFilters{"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL",
                                                      "COLOR"};
consteval auto MeshoptView(std::span<const std::string_view> filters) {
    return Table(Index("buffer", Target::Buffers).Required(), Whole("byteOffset").Between(0, kMaxExact),
                 Whole("byteLength").Between(1, kMaxExact).Required(),
                 Whole("byteStride").Between(1, 256).Required(),
                 Whole("count").Between(1, kMaxExact).Required(),
                 Text("mode").OneOf(kMeshoptModes).Required(), Text("filter").OneOf(filters));
}
constexpr auto kExtMeshoptView = MeshoptView(kExtFilters);
constexpr auto kKhrMeshoptView = MeshoptView(kKhrFilters);

constexpr std::array<uint64_t, 6> kComponentTypes{5120, 5121, 5122, 5123, 5125, 5126};
constexpr std::array<uint64_t, 3> kIndexTypes{5121, 5123, 5125};
constexpr std::array<std::string_view, 7> kShapes{"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};

constexpr auto kSparseIndices =
    Table(Index("bufferView", Target::BufferViews).Required(), Whole("byteOffset"),
          Whole("componentType").OneOf(kIndexTypes).Required());
constexpr auto kSparseValues =
    Table(Index("bufferView", Target::BufferViews).Required(), Whole("byteOffset"));
constexpr auto kSparse =
    Table(Whole("count").AtLeast(1).Required(), Object("indices", kSparseIndices).Required(),
          Object("values", kSparseValues).Required());
constexpr auto kAccessor = Table(Index("bufferView", Target::BufferViews), Whole("byteOffset"),
                                 Whole("componentType").OneOf(kComponentTypes).Required(), Flag("normalized"),
                                 Whole("count").AtLeast(1).Required(), Text("type").OneOf(kShapes).Required(),
                                 Object("sparse", kSparse));

// --- Textures ---

constexpr auto kImage = Table(kName, Text("uri"), Index("bufferView", Target::BufferViews));

// These are OpenGL's numbers.
constexpr std::array<uint64_t, 3> kWraps{10497, 33648, 33071};
constexpr std::array<uint64_t, 2> kMagFilters{9728, 9729};
constexpr std::array<uint64_t, 6> kMinFilters{9728, 9729, 9984, 9985, 9986, 9987};
constexpr auto kSampler = Table(Whole("wrapS").OneOf(kWraps), Whole("wrapT").OneOf(kWraps),
                                Whole("magFilter").OneOf(kMagFilters), Whole("minFilter").OneOf(kMinFilters));

constexpr auto kTexture = Table(kName, Index("sampler", Target::Samplers), Index("source", Target::Images),
                                Extensions(ExtensionPlace::Texture));

// These extensions name another file of the same picture.
constexpr auto kTextureSource = Table(Index("source", Target::Images));

// --- Materials ---

constexpr Row kTextureIndex = Index("index", Target::Textures).Required();
constexpr WholeRow kTexCoord =
    Whole("texCoord").Between(0, 1).OrOmitted("texCoord", "taken as 0: TEXCOORD_0 and TEXCOORD_1 are read");

constexpr Row kTextureInfoExtensions = Extensions(ExtensionPlace::TextureInfo);

constexpr auto kTextureInfo = Table(kTextureIndex, kTexCoord, kTextureInfoExtensions);
// A texture that nothing reads.
constexpr auto kUnreadTextureInfo = Table(kTextureIndex, Whole("texCoord"));

// Returns the row of a field of a material or of a texture's transform. A value out of range is clamped, but
// left out where 0 stands for infinite: no number of the range does.
template <typename Owner>
constexpr auto FactorRow(const Field<Owner, float>& field) {
    const NumberRow row = RowFor(field);
    return field.omitsZero ? row.OrOmitted("distance", "taken as infinite") : row.ClampToRange();
}
template <typename Owner, typename T>
constexpr auto FactorRow(const Field<Owner, T>& field) {
    return RowFor(field).ClampToRange();
}
constexpr Row FactorRow(const MaterialField<bool>& field) {
    return RowFor(field);
}
constexpr TextRow FactorRow(const MaterialField<AlphaMode>& field) {
    return Text(field.key).OneOf(kGltfNames<AlphaMode>);
}
// The property is not glTF's: `extras` belongs to applications, so a value that is no valid number may be
// another application's.
constexpr WholeRow FactorRow(const MaterialField<uint32_t>& field) {
    return Whole(field.key)
        .Between(0, std::numeric_limits<uint32_t>::max())
        .OrOmittedIfInvalid(field.name, "taken as 0");
}
template <typename Owner, typename T>
constexpr auto Factor(T Owner::*member) {
    return FactorRow(FieldOf(member));
}
constexpr auto kTextureTransformRows =
    Table(Factor(&TextureTransform::offset), Factor(&TextureTransform::rotation),
          Factor(&TextureTransform::scale), kTexCoord);

// These texture infos have a factor of their own.
constexpr auto kNormalTextureInfo =
    Table(kTextureIndex, kTexCoord, Factor(&Material::normalScale), kTextureInfoExtensions);
constexpr auto kOcclusionTextureInfo =
    Table(kTextureIndex, kTexCoord, Factor(&Material::occlusionStrength), kTextureInfoExtensions);
constexpr std::span<const Property> InfoOf(TextureRef Material::*member) {
    if (member == &Material::occlusionTexture) return kOcclusionTextureInfo;
    const bool isScaled = member == &Material::normalTexture || member == &Material::clearcoatNormalTexture;
    return isScaled ? std::span<const Property>(kNormalTextureInfo) : kTextureInfo;
}
constexpr ObjectRow FactorRow(const TextureField& field) {
    return Object(field.key, InfoOf(field.member));
}

// Holds the rows of one of a material's objects.
struct MaterialRows {
    std::array<Property, 16> rows{};
    size_t count = 0;

    constexpr void Add(const Property& row) { rows[count++] = row; }
    constexpr std::span<const Property> All() const { return {rows.data(), count}; }
};

constexpr auto kScatterTexture = Object("multiscatterColorTexture", kUnreadTextureInfo);

// Returns a row for each field that is in the object.
constexpr MaterialRows RowsOf(std::string_view object) {
    MaterialRows rows;
    ForEachFieldOf(object == kSpecularGlossiness, [&](const auto& field) {
        if (field.object == object && *field.key != 0 && KeyPartsOf(field.key).object.empty())
            rows.Add(FactorRow(field));
    });
    if (object == FieldOf(&Material::multiscatterColorFactor).object) rows.Add(kScatterTexture);
    return rows;
}

constexpr MaterialRows kPbr = RowsOf("pbrMetallicRoughness");
constexpr MaterialRows kMaterialExtras = RowsOf("extras");
constexpr MaterialRows kMaterial = [] {
    MaterialRows rows;
    rows.Add(kName);
    rows.Add(Object("pbrMetallicRoughness", kPbr.All()));
    const MaterialRows own = RowsOf("");
    for (const Property& row : own.All()) rows.Add(row);
    rows.Add(Extensions(ExtensionPlace::Material));
    rows.Add(Extras(kMaterialExtras.All()));
    return rows;
}();

// Holds the extensions that fields are in, each once.
struct MaterialExtensions {
    std::array<std::string_view, 64> names{};
    size_t count = 0;
};
constexpr MaterialExtensions kMaterialExtensions = [] {
    MaterialExtensions found;
    ForEachMaterialField([&](const auto& field) {
        const std::string_view name = field.object;
        if (!name.starts_with("KHR_")) return;
        for (size_t i = 0; i < found.count; ++i)
            if (found.names[i] == name) return;
        found.names[found.count++] = name;
    });
    return found;
}();
constexpr auto kMaterialTables = [] {
    std::array<MaterialRows, kMaterialExtensions.count> tables;
    for (size_t i = 0; i < tables.size(); ++i) tables[i] = RowsOf(kMaterialExtensions.names[i]);
    return tables;
}();

// --- Meshes ---

template <typename MakeRow>
consteval auto AttributeTable(const MakeRow& makeRow) {
    std::array<Property, kAttributeCount> rows;
    for (size_t i = 0; i < rows.size(); ++i) rows[i] = makeRow(kAttributeNames[i]);
    return rows;
}
constexpr auto kReadAttributes =
    AttributeTable([](const char* name) { return Index(name, Target::Accessors); });
// The attributes that are read, and those that are left out with a warning.
constexpr auto kAttributes = [] {
    std::array<Property, kAttributeCount + 1> rows;
    for (size_t i = 0; i < kAttributeCount; ++i) rows[i] = kReadAttributes[i];
    rows[kAttributeCount] = Index(kUnreadJoints, Target::Accessors);
    return rows;
}();
constexpr auto kMorphTarget =
    Table(Index("POSITION", Target::Accessors), Index("NORMAL", Target::Accessors),
          Index("TANGENT", Target::Accessors), Index("TEXCOORD_0", Target::Accessors),
          Index("TEXCOORD_1", Target::Accessors), Index("COLOR_0", Target::Accessors));
constexpr auto kPrimitive =
    Table(Object("attributes", kAttributes).Required(), Index("indices", Target::Accessors),
          Index("material", Target::Materials), Whole("mode").Between(0, 6), Objects("targets", kMorphTarget),
          Extensions(ExtensionPlace::Primitive));
// KHR_draco_mesh_compression: ids of the compressed attributes.
constexpr WholeRow UniqueId(const char* attribute) {
    return Whole(attribute).Between(0, std::numeric_limits<uint32_t>::max() - 1);
}
constexpr auto kDracoAttributes = AttributeTable([](const char* name) { return UniqueId(name); });
constexpr auto kDraco = Table(Index("bufferView", Target::BufferViews).Required(),
                              Object("attributes", kDracoAttributes).Required());
// KHR_materials_variants.
constexpr auto kVariant = Table(kName);
constexpr auto kVariants = Table(Objects("variants", kVariant).ReferencedAs(Target::Variants));
constexpr auto kVariantMapping =
    Table(Indices("variants", Target::Variants).Required(), Index("material", Target::Materials).Required());
constexpr auto kVariantMappings = Table(Objects("mappings", kVariantMapping));
constexpr auto kMesh = Table(kName, Objects("primitives", kPrimitive).Required(), NumberList("weights"));

// --- Cameras and lights ---

constexpr auto kPerspective = Table(Number("yfov").Above(0.0f).Below(glm::pi<float>()).Required(),
                                    Number("aspectRatio").Above(0.0f).OrOmitted("aspectRatio", "ignored"),
                                    Number("znear").Above(0.0f).Required(),
                                    Number("zfar").Above(0.0f).OrOmitted("zfar", "taken as infinite"));
constexpr auto kOrthographic = Table(Number("xmag").Required(), Number("ymag").Required(),
                                     Number("znear").AtLeast(0.0f), Number("zfar").Above(0.0f).Required());
constexpr std::array<std::string_view, 2> kCameraTypes{"perspective", "orthographic"};
constexpr auto kCamera = Table(kName, Text("type").OneOf(kCameraTypes).Required(),
                               Object("perspective", kPerspective).OfType("perspective"),
                               Object("orthographic", kOrthographic).OfType("orthographic"));

template <typename T>
consteval auto LightRow(T Light::*member) {
    return RowFor(FieldOf(member));
}
constexpr auto kSpot = Table(LightRow(&Light::innerConeAngle), LightRow(&Light::outerConeAngle));
constexpr auto kLight =
    Table(kName, Text("type").OneOf(kGltfNames<LightType>).Required(), LightRow(&Light::color),
          LightRow(&Light::intensity), LightRow(&Light::range).OrOmitted("range", "taken as infinite"),
          Object(light_fields::kSpot, kSpot).OfType(GltfName(LightType::Spot)));
constexpr auto kLights = Table(Objects("lights", kLight).ReferencedAs(Target::Lights));
constexpr auto kNodeLight = Table(Index("light", Target::Lights).Required());

constexpr std::array<std::string_view, 1> kProfileTypes{"application/x-ies-lm-63"};
constexpr auto kProfile = Table(kName, Text("uri"), Index("bufferView", Target::BufferViews),
                                Text("mimeType").OneOf(kProfileTypes));
constexpr auto kProfiles = Table(Objects("lights", kProfile).ReferencedAs(Target::LightProfiles));
constexpr auto kNodeProfile =
    Table(Index("light", Target::LightProfiles).Required(), Number("multiplier").AtLeast(0.0f).ClampToRange(),
          Numbers("color", 3).Between(0.0f, 1.0f).ClampToRange());

// EXT_lights_image_based. A path tracer does not need the irradiance.
constexpr auto kImageLight =
    Table(kName, Numbers("rotation", 4), Number("intensity").AtLeast(0.0f).ClampToRange(),
          Whole("specularImageSize").Between(1, 1u << 30),
          IndexLists("specularImages", Target::Images, 6).Required());
constexpr auto kImageLights = Table(Objects("lights", kImageLight).ReferencedAs(Target::ImageLights));
constexpr auto kSceneLight = Table(Index("light", Target::ImageLights).Required());

// --- Nodes ---

constexpr auto kNode = Table(
    kName, Numbers("translation", 3), Numbers("rotation", 4), Numbers("scale", 3), Numbers("matrix", 16),
    Index("mesh", Target::Meshes), Index("camera", Target::Cameras), Index("skin", Target::Skins),
    NumberList("weights"), Indices("children", Target::Nodes), Extensions(ExtensionPlace::Node));
constexpr auto kNodeVisibility = Table(Flag("visible"));
// EXT_mesh_gpu_instancing; its other attributes belong to applications.
constexpr auto kInstanceAttributes =
    Table(Index("TRANSLATION", Target::Accessors), Index("ROTATION", Target::Accessors),
          Index("SCALE", Target::Accessors));
constexpr auto kInstancing = Table(Object("attributes", kInstanceAttributes));
constexpr auto kScene = Table(kName, Indices("nodes", Target::Nodes), Extensions(ExtensionPlace::Scene));

// --- Skins and animations ---

constexpr auto kSkin = Table(kName, Indices("joints", Target::Nodes).Required(),
                             Index("inverseBindMatrices", Target::Accessors));
constexpr std::array<std::string_view, 3> kInterpolations{"LINEAR", "STEP", "CUBICSPLINE"};
constexpr auto kAnimationSampler =
    Table(Index("input", Target::Accessors).Required(), Index("output", Target::Accessors).Required(),
          Text("interpolation").OneOf(kInterpolations));
// KHR_animation_pointer is no line of kOtherExtensions: ExtensionPlace has no value for an animation's
// target.
constexpr auto kPointer = Table(Text("pointer").Required());
constexpr auto kTargetExtensions = Table(Object(kAnimationPointer, kPointer));
constexpr auto kAnimationTarget =
    Table(Index("node", Target::Nodes), Text("path").Required(), Object("extensions", kTargetExtensions));
constexpr auto kChannel = Table(Index("sampler", Target::AnimationSamplers).Required(),
                                Object("target", kAnimationTarget).Required());
constexpr auto kAnimation =
    Table(kName, Objects("samplers", kAnimationSampler).ReferencedAs(Target::AnimationSamplers).Required(),
          Objects("channels", kChannel).Required());

// --- The document ---

constexpr std::array<std::string_view, 1> kMinVersions{"2.0"};
constexpr auto kAsset =
    Table(Text("version").StartsWith("2.").Required(), Text("minVersion").OneOf(kMinVersions));

// The asset and the required extensions come first: in files that cannot be read, the rest may have another
// shape. Then extensions, because nodes point at objects that one holds.
constexpr auto kRoot =
    Table(Object("asset", kAsset).Required(), Row("extensionsRequired", PropertyType::RequiredExtensions),
          Row("extensionsUsed", PropertyType::UsedExtensions), Extensions(ExtensionPlace::Root),
          Objects("buffers", kBuffer).ReferencedAs(Target::Buffers),
          Objects("bufferViews", kBufferView).ReferencedAs(Target::BufferViews),
          Objects("accessors", kAccessor).ReferencedAs(Target::Accessors),
          Objects("images", kImage).ReferencedAs(Target::Images),
          Objects("samplers", kSampler).ReferencedAs(Target::Samplers),
          Objects("textures", kTexture).ReferencedAs(Target::Textures),
          Objects("materials", kMaterial.All()).ReferencedAs(Target::Materials),
          Objects("meshes", kMesh).ReferencedAs(Target::Meshes),
          Objects("cameras", kCamera).ReferencedAs(Target::Cameras),
          Objects("skins", kSkin).ReferencedAs(Target::Skins),
          Objects("nodes", kNode).ReferencedAs(Target::Nodes), Objects("animations", kAnimation),
          Objects("scenes", kScene).ReferencedAs(Target::Scenes), Index("scene", Target::Scenes));

constexpr std::array kOtherExtensions{
    Extension{"EXT_meshopt_compression", ExtensionPlace::Buffer, kMeshoptBuffer},
    Extension{"EXT_meshopt_compression", ExtensionPlace::BufferView, kExtMeshoptView},
    Extension{"KHR_meshopt_compression", ExtensionPlace::Buffer, kMeshoptBuffer},
    Extension{"KHR_meshopt_compression", ExtensionPlace::BufferView, kKhrMeshoptView},
    Extension{"KHR_draco_mesh_compression", ExtensionPlace::Primitive, kDraco},
    Extension{"KHR_lights_punctual", ExtensionPlace::Root, kLights},
    Extension{"KHR_lights_punctual", ExtensionPlace::Node, kNodeLight},
    Extension{kProfileExtension, ExtensionPlace::Root, kProfiles},
    Extension{kProfileExtension, ExtensionPlace::Node, kNodeProfile},
    Extension{kImageLightExtension, ExtensionPlace::Root, kImageLights},
    Extension{kImageLightExtension, ExtensionPlace::Scene, kSceneLight},
    Extension{"EXT_mesh_gpu_instancing", ExtensionPlace::Node, kInstancing},
    Extension{"KHR_node_visibility", ExtensionPlace::Node, kNodeVisibility},
    Extension{"EXT_texture_webp", ExtensionPlace::Texture, kTextureSource},
    Extension{"MSFT_texture_dds", ExtensionPlace::Texture, kTextureSource},
    Extension{"KHR_texture_basisu", ExtensionPlace::Texture, kTextureSource},
    Extension{kTextureTransform, ExtensionPlace::TextureInfo, kTextureTransformRows},
    Extension{"KHR_materials_variants", ExtensionPlace::Root, kVariants},
    Extension{"KHR_materials_variants", ExtensionPlace::Primitive, kVariantMappings},
};

constexpr auto kExtensions = [] {
    std::array<Extension, kOtherExtensions.size() + kMaterialTables.size()> all;
    for (size_t i = 0; i < kOtherExtensions.size(); ++i) all[i] = kOtherExtensions[i];
    for (size_t i = 0; i < kMaterialTables.size(); ++i)
        all[kOtherExtensions.size() + i] = {kMaterialExtensions.names[i], ExtensionPlace::Material,
                                            kMaterialTables[i].All()};
    return all;
}();

}  // namespace

std::span<const Property> RootProperties() {
    return kRoot;
}

std::span<const Extension> SupportedExtensions() {
    return kExtensions;
}

}  // namespace raygraph::scene
