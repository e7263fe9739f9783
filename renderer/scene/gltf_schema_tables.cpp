// The rows. Ranges are glTF's, but where a picture can be had of what is out of them.
#include <array>
#include <glm/gtc/constants.hpp>

#include "renderer/scene/gltf_schema.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::scene {
namespace {

// --- Making rows ---

struct Row : Property {
    constexpr Row(std::string_view ofName, PropertyType ofPropertyType) {
        name = ofName;
        type = ofPropertyType;
    }
    // With something changed. First, because clang evaluates no call of what it has not read yet.
    template <typename Change>
    constexpr Row With(const Change& change) const {
        Row row = *this;
        change(row);
        return row;
    }
    constexpr Row Required() const {
        return With([](Row& row) { row.isRequired = true; });
    }
    constexpr Row AtLeast(float value) const {
        return With([&](Row& row) { row.min = value; });
    }
    constexpr Row Above(float value) const {
        return With([&](Row& row) { row.min = value, row.excludesMin = true; });
    }
    constexpr Row Below(float value) const {
        return With([&](Row& row) { row.max = value, row.excludesMax = true; });
    }
    constexpr Row Between(float low, float high) const {
        return With([&](Row& row) { row.min = low, row.max = high; });
    }
    constexpr Row OrZero() const {
        return With([](Row& row) { row.allowsZero = true; });
    }
    constexpr Row WholeBetween(uint64_t low, uint64_t high) const {
        return With([&](Row& row) { row.wholeMin = low, row.wholeMax = high; });
    }
    constexpr Row OneOf(std::span<const uint64_t> values) const {
        return With([&](Row& row) { row.numbers = values; });
    }
    constexpr Row OneOf(std::span<const std::string_view> values) const {
        return With([&](Row& row) { row.texts = values; });
    }
    constexpr Row StartsWith(std::string_view text) const {
        return With([&](Row& row) { row.start = text; });
    }
    constexpr Row PutIntoRange() const {
        return With([](Row& row) { row.misfit = Misfit::PutIntoRange, row.topic = "factor"; });
    }
    constexpr Row OrLeftOut(const char* warnAs, const char* instead) const {
        return With(
            [&](Row& row) { row.misfit = Misfit::LeaveOut, row.topic = warnAs, row.remedy = instead; });
    }
    // No warning without a topic.
    constexpr Row OrLeftOutWhateverItIs(const char* warnAs = nullptr, const char* instead = nullptr) const {
        return With(
            [&](Row& row) { row.misfit = Misfit::LeaveOutAny, row.topic = warnAs, row.remedy = instead; });
    }
    constexpr Row PointedAtAs(Target what) const {
        return With([&](Row& row) { row.target = what; });
    }
    constexpr Row OfType(std::string_view value) const {
        return With([&](Row& row) { row.ofType = value; });
    }
};

constexpr Row Flag(std::string_view name) {
    return {name, PropertyType::Bool};
}
constexpr Row Text(std::string_view name) {
    return {name, PropertyType::String};
}
constexpr Row Number(std::string_view name) {
    return {name, PropertyType::Number};
}
constexpr Row Numbers(std::string_view name, size_t count) {
    return Row(name, PropertyType::Numbers).With([&](Row& row) { row.count = count; });
}
constexpr Row Whole(std::string_view name) {
    return {name, PropertyType::Whole};
}
constexpr Row Index(std::string_view name, Target target) {
    return Row(name, PropertyType::Index).With([&](Row& row) { row.target = target; });
}
constexpr Row Indices(std::string_view name, Target target) {
    return Row(name, PropertyType::Indices).With([&](Row& row) { row.target = target; });
}
constexpr Row Object(std::string_view name, std::span<const Property> rows) {
    return Row(name, PropertyType::Object).With([&](Row& row) {
        row.rows = rows.data();
        row.rowCount = rows.size();
    });
}
constexpr Row Objects(std::string_view name, std::span<const Property> rows) {
    return Object(name, rows).With([](Row& row) { row.type = PropertyType::Objects; });
}
constexpr Row Extensions(ExtensionPlace place) {
    return Row("extensions", PropertyType::Extensions).With([&](Row& row) { row.place = place; });
}

// A factor of a material.
constexpr Row Factor(std::string_view name) {
    return Number(name).Between(0.0f, 1.0f).PutIntoRange();
}
constexpr Row Color(std::string_view name) {
    return Numbers(name, 3).Between(0.0f, 1.0f).PutIntoRange();
}
constexpr Row UnboundedColor(std::string_view name) {
    return Numbers(name, 3).AtLeast(0.0f).PutIntoRange();
}

template <typename... Rows>
constexpr std::array<Property, sizeof...(Rows)> Table(const Rows&... rows) {
    return {rows...};
}

// --- Buffers and accessors ---

constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();

constexpr auto kBuffer = Table(Whole("byteLength").WholeBetween(1, kNoLimit).Required(), Text("uri"));

constexpr auto kBufferView =
    Table(Index("buffer", Target::Buffers).Required(), Whole("byteOffset"),
          Whole("byteLength").WholeBetween(1, kNoLimit).Required(), Whole("byteStride").WholeBetween(4, 252));

constexpr std::array<uint64_t, 6> kComponentTypes{5120, 5121, 5122, 5123, 5125, 5126};
constexpr std::array<uint64_t, 3> kIndexTypes{5121, 5123, 5125};
constexpr std::array<std::string_view, 7> kShapes{"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};

constexpr auto kSparseIndices =
    Table(Index("bufferView", Target::BufferViews).Required(), Whole("byteOffset"),
          Whole("componentType").OneOf(kIndexTypes).Required());
constexpr auto kSparseValues =
    Table(Index("bufferView", Target::BufferViews).Required(), Whole("byteOffset"));
constexpr auto kSparse =
    Table(Whole("count").WholeBetween(1, kNoLimit).Required(), Object("indices", kSparseIndices).Required(),
          Object("values", kSparseValues).Required());
constexpr auto kAccessor = Table(Index("bufferView", Target::BufferViews), Whole("byteOffset"),
                                 Whole("componentType").OneOf(kComponentTypes).Required(), Flag("normalized"),
                                 Whole("count").WholeBetween(1, kNoLimit).Required(),
                                 Text("type").OneOf(kShapes).Required(), Object("sparse", kSparse));

// --- Textures ---

constexpr auto kImage = Table(Text("name"), Text("uri"), Index("bufferView", Target::BufferViews));

// OpenGL's numbers.
constexpr std::array<uint64_t, 3> kWraps{10497, 33648, 33071};
constexpr std::array<uint64_t, 2> kMagFilters{9728, 9729};
constexpr std::array<uint64_t, 6> kMinFilters{9728, 9729, 9984, 9985, 9986, 9987};
constexpr auto kSampler = Table(Whole("wrapS").OneOf(kWraps), Whole("wrapT").OneOf(kWraps),
                                Whole("magFilter").OneOf(kMagFilters), Whole("minFilter").OneOf(kMinFilters));

constexpr auto kTexture = Table(Text("name"), Index("sampler", Target::Samplers),
                                Index("source", Target::Images), Extensions(ExtensionPlace::Texture));

// Of EXT_texture_webp.
constexpr auto kTextureSource = Table(Index("source", Target::Images));

// --- Materials ---

constexpr Row kTextureIndex = Index("index", Target::Textures).Required();
constexpr Row kTexCoord = Whole("texCoord")
                              .WholeBetween(0, 1)
                              .OrLeftOut("texCoord", "taken as 0: TEXCOORD_0 and TEXCOORD_1 are read");

constexpr auto kTextureInfo = Table(kTextureIndex, kTexCoord);
constexpr auto kNormalTextureInfo = Table(kTextureIndex, kTexCoord, Number("scale"));
constexpr auto kOcclusionTextureInfo = Table(kTextureIndex, kTexCoord, Factor("strength"));
// Of a texture that nothing reads.
constexpr auto kUnreadTextureInfo = Table(kTextureIndex, Whole("texCoord"));

constexpr auto kPbr = Table(Numbers("baseColorFactor", 4).Between(0.0f, 1.0f).PutIntoRange(),
                            Object("baseColorTexture", kTextureInfo), Factor("metallicFactor"),
                            Factor("roughnessFactor"), Object("metallicRoughnessTexture", kTextureInfo));

// Not glTF's: `extras` belongs to applications, and what is no priority as we mean it may be another's.
constexpr auto kMaterialExtras = Table(Whole("priority")
                                           .WholeBetween(0, std::numeric_limits<uint32_t>::max())
                                           .OrLeftOutWhateverItIs("priority", "taken as 0"));

constexpr std::array<std::string_view, 3> kAlphaModes{"OPAQUE", "MASK", "BLEND"};
constexpr auto kMaterial = Table(
    Text("name"), Object("pbrMetallicRoughness", kPbr), Object("normalTexture", kNormalTextureInfo),
    Object("occlusionTexture", kOcclusionTextureInfo),
    // Above 1 is out of the standard's range, but files from before KHR_materials_emissive_strength mean it.
    UnboundedColor("emissiveFactor"), Object("emissiveTexture", kTextureInfo),
    Text("alphaMode").OneOf(kAlphaModes), Number("alphaCutoff").AtLeast(0.0f).PutIntoRange(),
    Flag("doubleSided"), Extensions(ExtensionPlace::Material),
    Object("extras", kMaterialExtras).OrLeftOutWhateverItIs());

constexpr auto kEmissiveStrength = Table(Number("emissiveStrength").AtLeast(0.0f).PutIntoRange());
constexpr auto kIor = Table(Number("ior").Between(1.0f, Material::kMostIor).OrZero().PutIntoRange());
constexpr auto kSpecular =
    Table(Factor("specularFactor"), Object("specularTexture", kTextureInfo),
          UnboundedColor("specularColorFactor"), Object("specularColorTexture", kTextureInfo));
constexpr auto kTransmission =
    Table(Factor("transmissionFactor"), Object("transmissionTexture", kTextureInfo));
constexpr auto kVolume =
    Table(Number("thicknessFactor").AtLeast(0.0f).PutIntoRange(),
          Object("thicknessTexture", kUnreadTextureInfo), Color("attenuationColor"),
          Number("attenuationDistance").Above(0.0f).OrLeftOut("distance", "taken as infinite"));

// --- Meshes ---

constexpr auto kAttributes =
    Table(Index("POSITION", Target::Accessors), Index("NORMAL", Target::Accessors),
          Index("TANGENT", Target::Accessors), Index("TEXCOORD_0", Target::Accessors),
          Index("TEXCOORD_1", Target::Accessors), Index("COLOR_0", Target::Accessors));
constexpr auto kMorphTarget = Table(Index("POSITION", Target::Accessors), Index("NORMAL", Target::Accessors),
                                    Index("TANGENT", Target::Accessors));
constexpr auto kPrimitive = Table(Object("attributes", kAttributes).Required(),
                                  Index("indices", Target::Accessors), Index("material", Target::Materials),
                                  Whole("mode").WholeBetween(0, 6), Objects("targets", kMorphTarget));
constexpr auto kMesh = Table(Text("name"), Objects("primitives", kPrimitive).Required());

// --- Cameras and lights ---

constexpr auto kPerspective =
    Table(Number("yfov").Above(0.0f).Below(glm::pi<float>()).Required(), Number("aspectRatio").Above(0.0f),
          Number("znear").Above(0.0f).Required(), Number("zfar").Above(0.0f));
constexpr auto kOrthographic = Table(Number("xmag").Required(), Number("ymag").Required(),
                                     Number("znear").AtLeast(0.0f), Number("zfar").Above(0.0f).Required());
constexpr std::array<std::string_view, 2> kCameraTypes{"perspective", "orthographic"};
constexpr auto kCamera = Table(Text("name"), Text("type").OneOf(kCameraTypes).Required(),
                               Object("perspective", kPerspective).OfType("perspective"),
                               Object("orthographic", kOrthographic).OfType("orthographic"));

constexpr auto kSpot = Table(Number("innerConeAngle").AtLeast(0.0f), Number("outerConeAngle").AtLeast(0.0f));
constexpr std::array<std::string_view, 3> kLightTypes{"directional", "point", "spot"};
constexpr auto kLight = Table(Text("name"), Text("type").OneOf(kLightTypes).Required(),
                              Numbers("color", 3).AtLeast(0.0f), Number("intensity").AtLeast(0.0f),
                              Number("range").Above(0.0f), Object("spot", kSpot).OfType("spot"));
constexpr auto kLights = Table(Objects("lights", kLight).PointedAtAs(Target::Lights));
constexpr auto kNodeLight = Table(Index("light", Target::Lights).Required());

// --- Nodes ---

constexpr auto kNode =
    Table(Text("name"), Numbers("translation", 3), Numbers("rotation", 4), Numbers("scale", 3),
          Numbers("matrix", 16), Index("mesh", Target::Meshes), Index("camera", Target::Cameras),
          Index("skin", Target::Skins), Indices("children", Target::Nodes), Extensions(ExtensionPlace::Node));
constexpr auto kScene = Table(Text("name"), Indices("nodes", Target::Nodes));

// --- What is not read: its indices are checked, so that a damaged file is refused whether or not it shows
// ---

constexpr auto kSkin = Table(Indices("joints", Target::Nodes), Index("skeleton", Target::Nodes),
                             Index("inverseBindMatrices", Target::Accessors));
constexpr auto kAnimationSampler =
    Table(Index("input", Target::Accessors).Required(), Index("output", Target::Accessors).Required());
constexpr auto kAnimationTarget = Table(Index("node", Target::Nodes));
constexpr auto kChannel = Table(Index("sampler", Target::AnimationSamplers).Required(),
                                Object("target", kAnimationTarget).Required());
constexpr auto kAnimation =
    Table(Objects("samplers", kAnimationSampler).PointedAtAs(Target::AnimationSamplers),
          Objects("channels", kChannel));

// --- The document ---

constexpr std::array<std::string_view, 1> kMinVersions{"2.0"};
constexpr auto kAsset =
    Table(Text("version").StartsWith("2.").Required(), Text("minVersion").OneOf(kMinVersions));

// What a file is and requires comes first: what follows may be of another shape in files that cannot be read.
// Then extensions, because nodes point at what one holds.
constexpr auto kRoot =
    Table(Object("asset", kAsset).Required(), Row("extensionsRequired", PropertyType::RequiredExtensions),
          Row("extensionsUsed", PropertyType::UsedExtensions), Extensions(ExtensionPlace::Root),
          Objects("buffers", kBuffer).PointedAtAs(Target::Buffers),
          Objects("bufferViews", kBufferView).PointedAtAs(Target::BufferViews),
          Objects("accessors", kAccessor).PointedAtAs(Target::Accessors),
          Objects("images", kImage).PointedAtAs(Target::Images),
          Objects("samplers", kSampler).PointedAtAs(Target::Samplers),
          Objects("textures", kTexture).PointedAtAs(Target::Textures),
          Objects("materials", kMaterial).PointedAtAs(Target::Materials),
          Objects("meshes", kMesh).PointedAtAs(Target::Meshes),
          Objects("cameras", kCamera).PointedAtAs(Target::Cameras),
          Objects("skins", kSkin).PointedAtAs(Target::Skins),
          Objects("nodes", kNode).PointedAtAs(Target::Nodes), Objects("animations", kAnimation),
          Objects("scenes", kScene).PointedAtAs(Target::Scenes), Index("scene", Target::Scenes));

constexpr std::array kExtensions{
    Extension{"KHR_mesh_quantization", ExtensionPlace::Nowhere, {}},
    Extension{"KHR_lights_punctual", ExtensionPlace::Root, kLights},
    Extension{"KHR_lights_punctual", ExtensionPlace::Node, kNodeLight},
    Extension{"EXT_texture_webp", ExtensionPlace::Texture, kTextureSource},
    Extension{"KHR_materials_emissive_strength", ExtensionPlace::Material, kEmissiveStrength},
    Extension{"KHR_materials_ior", ExtensionPlace::Material, kIor},
    Extension{"KHR_materials_specular", ExtensionPlace::Material, kSpecular},
    Extension{"KHR_materials_transmission", ExtensionPlace::Material, kTransmission},
    Extension{"KHR_materials_volume", ExtensionPlace::Material, kVolume},
    Extension{"KHR_materials_unlit", ExtensionPlace::Material, {}},
};

}  // namespace

std::span<const Property> RootProperties() {
    return kRoot;
}

std::span<const Extension> SupportedExtensions() {
    return kExtensions;
}

}  // namespace raygraph::scene
