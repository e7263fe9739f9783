// The reflected interface of a SPIR-V module: bindings, push constants, specialization constants, workgroup
// size. Needs no device. Threads: pure functions, for any thread.
//
// Names are the GLSL names: of the variable for images, samplers and acceleration structures; for a buffer or
// push-constant block its instance name if it has one, otherwise the block's name.
//     layout(...) buffer Materials { Material materials[]; };        -> "Materials"
//     layout(...) buffer Materials { Material data[]; } materials;   -> "materials"
// Each element of an array of resources in set 0 is a binding by its GLSL name:
//     layout(...) uniform sampler2D shadowMaps[4];                   -> "shadowMaps[0]" to "shadowMaps[3]"
// A uniform block of buffer references alone is a table of addresses, each a binding by its member's name:
//     layout(buffer_reference) readonly buffer Materials { Material at[]; };
//     layout(...) uniform Tables { Materials materials; };           -> "materials"
// Drivers for CPUs read through an address with a tenth of the code that a bound storage buffer takes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "rhi/format.h"
#include "rhi/shader_stage.h"
#include "rhi/subresources.h"

namespace raygraph::rhi {

enum class BindingKind : uint8_t {
    StorageImage,           // image2D, image2DArray, imageCube
    SampledImage,           // sampler2D, sampler2DArray, samplerCube: image and sampler combined
    StorageBuffer,          // buffer block
    UniformBuffer,          // uniform block
    AccelerationStructure,  // accelerationStructureEXT
    BufferAddress,          // a buffer reference in a uniform block that has nothing else
};

RAYGRAPH_API VkDescriptorType ToVk(BindingKind kind);
// Returns text such as "storage image" or "sampled image", for errors.
RAYGRAPH_API const char* Name(BindingKind kind);

enum class TexelType : uint8_t { Float, Int, Uint };
RAYGRAPH_API const char* Name(TexelType type);

struct Binding {
    std::string name;
    uint32_t set = 0;
    uint32_t binding = 0;
    uint32_t offset = 0;  // for a buffer address: its offset in the block
    BindingKind kind = BindingKind::StorageBuffer;
    uint32_t count = 1;                      // array size; 0: a runtime array
    bool isReadable = true;                  // false: declared writeonly
    bool isWritable = false;                 // storage images and buffers not declared readonly
    bool isUsed = false;                     // the entry point uses it, so that it must be bound
    ImageShape shape = ImageShape::Plain;    // for images
    TexelType texelType = TexelType::Float;  // for images
    Format imageFormat = Format::Undefined;  // for storage images; Undefined: the shader states none
    uint32_t blockBytes = 0;                 // of a buffer block or what a reference is to, without a
                                             // trailing runtime array
    uint32_t elementBytes = 0;               // stride of the trailing runtime array; 0: there is none
};

struct PushConstantBlock {
    std::string name;    // empty: the shader has none
    uint32_t bytes = 0;  // up to the end of the last member
};

enum class ConstantType : uint8_t { Bool, Int, Uint, Float };

struct SpecializationConstant {
    uint32_t id = 0;
    std::string name;  // empty for an unnamed one, such as local_size_x_id
    ConstantType type = ConstantType::Uint;
    uint32_t defaultValue = 0;  // bits; bool as 0 and 1
};

struct ShaderReflection {
    StageKind stage = StageKind::Compute;
    std::string entryPoint;         // "main"
    std::vector<Binding> bindings;  // sorted by set, then by binding
    PushConstantBlock pushConstants;
    std::vector<SpecializationConstant> specialization;  // sorted by id
    // For compute shaders, with the default values of specialization constants; 0, 0, 0 for other stages.
    std::array<uint32_t, 3> workgroupSize{};
    std::array<int64_t, 3> workgroupSizeIds{-1, -1, -1};  // constant ids of local_size_*_id; -1: fixed
    bool writesLayer = false;                             // a vertex shader writes gl_Layer
};

// Throws Error{Usage} starting with `name` for words that are not a module of one known stage, and for a
// binding of a kind that Raygraph does not support (separate images and samplers, texel buffers, 64-bit
// specialization constants).
RAYGRAPH_API ShaderReflection Reflect(std::span<const uint32_t> spirv, std::string_view name = "shader");

struct BlockMember {
    std::string name;
    uint32_t offset = 0;  // bytes
    ConstantType type = ConstantType::Float;
    uint32_t count = 0;  // components of a scalar or vector; 0: it is something else
};

// Returns the members of the module's push-constant block in order, for programs that fill one by name; none
// if it has no block.
RAYGRAPH_API std::vector<BlockMember> PushConstantMembers(std::span<const uint32_t> spirv);

// Returns a copy of ShaderStage::reflection, or the result of Reflect if the stage has none.
RAYGRAPH_API ShaderReflection ReflectionOf(const ShaderStage& stage);

// Holds the reflection of a stage, with its name for messages.
struct NamedReflection {
    std::string name;
    ShaderReflection reflection;
};

// Describes a binding, merged over a pipeline's stages.
struct BindingInfo : Binding {
    VkShaderStageFlags stages = 0;
    std::string firstShader;  // the shader that declared it first, for messages
    uint32_t element = 0;     // index in the array, if count is above 1
};

// Holds the merged bindings of all stages of one pipeline: the resources that a pass has to bind.
struct RAYGRAPH_API ShaderInterface {
    // The resources of the pass: set 0, sorted by binding, with an entry for each element of an array.
    std::vector<BindingInfo> bindings;
    bool usesTextureTable = false;                       // some stage uses set 1, the bindless textures
    VkShaderStageFlags stages = 0;                       // all stages
    PushConstantBlock pushConstants;                     // the largest block
    std::string pushConstantShader;                      // the shader that has it
    std::vector<SpecializationConstant> specialization;  // constants of all stages, sorted by id

    const BindingInfo* Find(std::string_view bindingName) const;  // null: no such binding
};

// Merges the stages. A binding is readable, writable or used if it is so in any stage. Throws Error{Usage}
// naming both shaders if one binding number has two kinds, names or array sizes, or one name two numbers.
// Throws Error{Usage} naming the shader if it uses a set above 1, set 1 for anything except `sampler2D x[]`
// at binding 0, or a runtime array in set 0.
RAYGRAPH_API ShaderInterface MergeInterface(std::span<const NamedReflection> stages);

}  // namespace raygraph::rhi
